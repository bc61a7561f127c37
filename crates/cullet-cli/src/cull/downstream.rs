//! What culling saves where it matters: in the real renderer.

use std::time::Duration;

use cullet::{Camera, CullTest, Frame, FrameStats, Prepared, Renderer, Settings, View, Viewport};
use cullet_measure::Summary;

/// A way to cull, as `cullet render` offers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mode {
    /// `--cull`.
    pub test: CullTest,
    /// `--hierarchy`.
    pub hierarchy: bool,
}

impl Mode {
    /// Nothing is culled.
    pub const NONE: Mode = Mode { test: CullTest::None, hierarchy: false };
    /// What `cullet render` does when not told otherwise.
    pub const DEFAULT: Mode = Mode { test: CullTest::Both, hierarchy: true };
    /// All that are compared.
    pub const ALL: [Mode; 8] = [
        Mode::NONE,
        Mode { test: CullTest::Corners, hierarchy: false },
        Mode { test: CullTest::PVertex, hierarchy: false },
        Mode { test: CullTest::Reverse, hierarchy: false },
        Mode { test: CullTest::Both, hierarchy: false },
        Mode { test: CullTest::Sat, hierarchy: false },
        Mode::DEFAULT,
        Mode { test: CullTest::Sat, hierarchy: true },
    ];

    /// For tables.
    pub fn name(self) -> String {
        format!("{}{}", self.test.name(), if self.hierarchy { " + tree" } else { "" })
    }
}

/// The frames of one mode.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// How it culled.
    pub mode: Mode,
    /// The frame of median time.
    pub frame: FrameStats,
    /// The time of the fastest.
    pub min: Duration,
    /// Half the interquartile range of the times over their median; `None` for one frame.
    pub spread: Option<f64>,
}

impl Drawn {
    /// Triangles that were transformed.
    pub fn n_triangles(&self) -> u64 {
        self.frame.triangles.n_in + self.frame.n_triangles_of_culled_clusters
    }

    /// The time of the whole frame, ms.
    pub fn ms(&self) -> f64 {
        ms(self.frame.total)
    }
}

/// Milliseconds.
pub fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

/// Draws `rounds` frames in each of `modes`, in turn, after one of each; one thread.
pub fn draw(
    prepared: &Prepared,
    camera: &Camera,
    viewport: Viewport,
    modes: &[Mode],
    rounds: u32,
) -> Vec<Drawn> {
    let view = View::new(camera, viewport);
    let (mut renderer, mut frame) = (Renderer::default(), Frame::default());
    let mut frames = vec![Vec::new(); modes.len()];
    for round in 0..=rounds as usize {
        for turn in 0..modes.len() {
            // None is always the first, or always behind the same one.
            let i = (turn + round) % modes.len();
            let Mode { test, hierarchy } = modes[i];
            let settings = Settings { cull: test, hierarchy, threads: 1, ..Settings::default() };
            let stats = renderer.render(prepared, &view, &settings, &mut frame);
            if round > 0 {
                frames[i].push(stats);
            }
        }
    }
    let drawn = modes.iter().zip(&mut frames);
    drawn.filter_map(|(mode, frames)| summed_up(*mode, frames)).collect()
}

fn summed_up(mode: Mode, frames: &mut [FrameStats]) -> Option<Drawn> {
    frames.sort_by_key(|stats| stats.total);
    let times: Vec<f64> = frames.iter().map(|stats| stats.total.as_secs_f64()).collect();
    let spread = (times.len() > 1).then(|| Summary::of(&times)).flatten();
    let spread = spread.map(|summary| summary.spread());
    Some(Drawn { mode, frame: frames[frames.len() / 2], min: frames[0].total, spread })
}

/// Percent of the time without culling that a way of culling saves, by the fastest frames; `None`
/// where it spared no triangle, or less than the spread of the times.
pub fn saved_percent(all: &Drawn, drawn: &Drawn) -> Option<f64> {
    let spared = drawn.frame.n_triangles_of_culled_objects > 0;
    let saved = 1.0 - drawn.min.as_secs_f64() / all.min.as_secs_f64();
    let spread = all.spread?.max(drawn.spread?);
    (spared && saved.abs() > spread).then_some(100.0 * saved)
}
