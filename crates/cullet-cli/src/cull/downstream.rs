//! What culling saves where it matters: in the real renderer.

use std::time::Duration;

use cullet::{Camera, CullTest, Frame, FrameStats, Prepared, Renderer, Settings, View, Viewport};

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
}

impl Drawn {
    /// Triangles that were transformed.
    pub fn n_triangles(&self) -> u64 {
        self.frame.triangles.n_in
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
    for round in 0..=rounds {
        for (mode, frames) in modes.iter().zip(&mut frames) {
            let Mode { test, hierarchy } = *mode;
            let settings = Settings { cull: test, hierarchy, threads: 1, ..Settings::default() };
            let stats = renderer.render(prepared, &view, &settings, &mut frame);
            if round > 0 {
                frames.push(stats);
            }
        }
    }
    let median = |frames: &mut Vec<FrameStats>| {
        frames.sort_by_key(|stats| stats.total);
        frames.get(frames.len() / 2).copied()
    };
    let drawn = modes.iter().zip(&mut frames);
    drawn.filter_map(|(mode, frames)| Some(Drawn { mode: *mode, frame: median(frames)? })).collect()
}
