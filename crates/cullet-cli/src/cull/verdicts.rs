//! What every test says of every box, as text.

use cullet::cull::{Aabb, Fate, Frustum, Sat, Test, Verdict, visible};

/// The tests reported, in the order of the ladder.
pub const TESTS: [Test; 6] =
    [Test::Sphere, Test::Corners, Test::PVertex, Test::Reverse, Test::Both, Test::Sat];

/// Appends lines of `--verdicts` for boxes from number `first` on; `camera` is given when there are
/// several.
pub fn lines(verdicts: &[Verdict], first: usize, camera: Option<usize>, text: &mut String) {
    use std::fmt::Write;
    let camera = camera.map_or(String::new(), |camera| format!(",\"camera\":{camera}"));
    for (i, verdict) in (first..).zip(verdicts) {
        let [corners, p_vertex, reverse, both, sat] =
            [Test::Corners, Test::PVertex, Test::Reverse, Test::Both, Test::Sat]
                .map(|test| verdict.keeps(test));
        let class = match verdict.fate {
            Fate::Invalid => "invalid",
            Fate::Inside => "inside",
            Fate::Crossing => "crossing",
            _ => "outside",
        };
        let _ = writeln!(
            text,
            "{{\"i\":{i},\"corners\":{corners},\"p_vertex\":{p_vertex},\"reverse\":{reverse},\
             \"both\":{both},\"sat\":{sat},\"class\":\"{class}\"{camera}}}"
        );
    }
}

/// Whether `test` keeps `bounds`; `sat` is made from `frustum`.
pub fn keeps(test: Test, bounds: &Aabb, frustum: &Frustum, sat: &Sat) -> bool {
    match test {
        Test::Sat => sat.visible(bounds),
        test => visible(test, frustum, bounds),
    }
}
