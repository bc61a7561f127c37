//! The viewer as a state machine: inputs go in, pictures and requests come out.
//!
//! No window, no clock and no files: the same inputs give the same pixels, whether a hand or a
//! script made them. What the outside has to do is asked for by a [`Request`].

use std::time::Duration;

use cullet::cull::Test;
use cullet::{
    Camera, Frame, FrameStats, Pass, Passes, Prepared, Renderer, Settings, View, Viewport,
    frame_direction,
};

use crate::hud::{self, GREY, Line, WHITE, span};
use crate::marks::{Mark, marks, plane_color};
use crate::overlay::{Canvas, Lines, Stroke};
use crate::{Orbit, camera_file};

/// What keys and the mouse do, for the help overlay and for `--help`.
pub const HELP: [(&str, &str); 15] = [
    ("left drag", "orbit"),
    ("right drag", "pan (middle drag too)"),
    ("wheel", "zoom"),
    ("F, Home", "frame everything"),
    ("Space", "freeze the culling frustum, or let it go"),
    ("B", "boxes by verdict, while frozen"),
    ("1", "test: corners (all eight behind one plane)"),
    ("2", "test: p-vertex (one corner per plane)"),
    ("3", "test: reverse (frustum beyond one face)"),
    ("4", "test: both (2, then 3)"),
    ("5", "test: sat (exact); 0 draws everything"),
    ("R", "half resolution while moving, if slow"),
    ("P", "save a screenshot here"),
    ("C", "print the camera file"),
    ("H, Escape", "this help; quit"),
];

/// A frame that takes longer is drawn at half resolution while the camera moves.
const SLOW: Duration = Duration::from_millis(50);

/// A key that means something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// Boxes on or off.
    B,
    /// Print the camera.
    C,
    /// 0 to 5: choose a test; others mean nothing.
    Digit(u8),
    /// Quit.
    Escape,
    /// Frame everything.
    F,
    /// Help on or off.
    H,
    /// Save a screenshot.
    P,
    /// Half resolution while moving, on or off.
    R,
    /// Freeze or unfreeze.
    Space,
}

/// What a hand does. Distances in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Input {
    /// A key goes down.
    Key(Key),
    /// The pointer turns the scene.
    Turn {
        /// To the right.
        right: f64,
        /// Down.
        down: f64,
    },
    /// The pointer shifts the scene.
    Pan {
        /// To the right.
        right: f64,
        /// Down.
        down: f64,
    },
    /// Steps of the wheel, towards the scene.
    Zoom(f64),
    /// The picture takes another size; 0 counts as 1.
    Resize(u32, u32),
}

/// What the outside has to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Come to an end.
    Quit,
    /// Save the picture as it is.
    Screenshot,
    /// Give this camera file to the user.
    PrintCamera(String),
}

/// Everything the viewer knows.
#[derive(Debug)]
pub struct App {
    prepared: Prepared,
    viewport: Viewport,
    orbit: Orbit,
    frozen: Option<Frozen>,
    test: Test,
    boxes: bool,
    help: bool,
    adaptive: bool,
    notice: Option<String>,
    frame_time: Option<Duration>,
    renderer: Renderer,
    frame: Frame,
    stats: FrameStats,
    /// How long the last frame of full size took.
    full_frame: Duration,
    coarse: bool,
    pixels: Vec<u32>,
}

/// A view that culling is held to, and what it says of each object.
#[derive(Debug)]
struct Frozen {
    view: View,
    marks: Vec<Mark>,
}

impl App {
    /// Starts with `camera`, or with everything in view.
    pub fn new(prepared: Prepared, camera: Option<&Camera>, viewport: Viewport) -> App {
        let orbit = match camera {
            Some(camera) => Orbit::new(camera, &prepared.bounds()),
            None => framed(&prepared, viewport, cullet::DEFAULT_DIRECTION),
        };
        App {
            prepared,
            viewport,
            orbit,
            frozen: None,
            test: Test::PVertex,
            boxes: true,
            help: false,
            adaptive: true,
            notice: None,
            frame_time: None,
            renderer: Renderer::default(),
            frame: Frame::default(),
            stats: FrameStats::default(),
            full_frame: Duration::ZERO,
            coarse: false,
            pixels: Vec::new(),
        }
    }

    /// Takes one input.
    pub fn input(&mut self, input: Input) -> Option<Request> {
        self.notice = None;
        let height = f64::from(self.viewport.height());
        match input {
            Input::Key(key) => return self.key(key),
            Input::Turn { right, down } => self.orbit.turn(right / height, down / height),
            Input::Pan { right, down } => self.orbit.pan(right / height, down / height),
            Input::Zoom(steps) => self.orbit.zoom(steps),
            Input::Resize(width, height) => {
                if let Ok(viewport) = Viewport::new(width.max(1), height.max(1)) {
                    self.viewport = viewport;
                }
            }
        }
        None
    }

    fn key(&mut self, key: Key) -> Option<Request> {
        match key {
            Key::B => self.boxes = !self.boxes,
            Key::F => {
                let direction = self.orbit.camera().back();
                self.orbit = framed(&self.prepared, self.viewport, direction);
            }
            Key::H => self.help = !self.help,
            Key::R => {
                self.adaptive = !self.adaptive;
                let now = if self.adaptive { "half if slow" } else { "full" };
                self.notice = Some(format!("resolution while moving: {now}"));
            }
            Key::Space => {
                self.frozen = match self.frozen.take() {
                    None => Some(self.froze(self.view())),
                    Some(_) => None,
                }
            }
            Key::Digit(digit) => {
                if let Some(test) = test_of(digit) {
                    self.test = test;
                    self.frozen = self.frozen.take().map(|frozen| self.froze(frozen.view));
                }
            }
            Key::Escape => return Some(Request::Quit),
            Key::P => return Some(Request::Screenshot),
            Key::C => {
                let (width, height) = (self.viewport.width(), self.viewport.height());
                let file = camera_file(self.orbit.camera(), width, height);
                return Some(Request::PrintCamera(file));
            }
        }
        None
    }

    fn froze(&self, view: View) -> Frozen {
        Frozen { view, marks: marks(&self.prepared, &view, self.test) }
    }

    /// What the window shows now.
    pub fn view(&self) -> View {
        View::new(self.orbit.camera(), self.viewport)
    }

    /// Whether culling is held to the view of an earlier moment.
    pub fn is_frozen(&self) -> bool {
        self.frozen.is_some()
    }

    /// Whether the last picture was drawn at half resolution, and deserves to be drawn again once
    /// the camera rests.
    pub fn is_coarse(&self) -> bool {
        self.coarse
    }

    /// What was culled and drawn in the last picture.
    pub fn stats(&self) -> &FrameStats {
        &self.stats
    }

    /// Sides of the picture, px.
    pub fn size(&self) -> (u32, u32) {
        (self.viewport.width(), self.viewport.height())
    }

    /// Tells how long frames take, for the display.
    pub fn set_frame_time(&mut self, frame_time: Duration) {
        self.frame_time = Some(frame_time);
    }

    /// Shows one line until the next input.
    pub fn set_notice(&mut self, notice: impl Into<String>) {
        self.notice = Some(notice.into());
    }

    /// The last picture: 0RGB, row-major, of [`App::size`].
    pub fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    /// Draws the picture. `moving`: the next one is expected soon, so haste is better than detail.
    pub fn draw(&mut self, moving: bool) {
        let view = self.view();
        self.coarse = moving && self.adaptive && self.full_frame > SLOW;
        let drawn = if self.coarse { View::new(view.camera(), half(self.viewport)) } else { view };
        let settings = Settings {
            cull: self.test,
            cull_view: self.frozen.as_ref().map(|frozen| frozen.view),
            passes: match self.frozen {
                Some(_) => Passes::COLOR.with(Pass::Depth),
                None => Passes::COLOR,
            },
            antialias: cullet::Antialias::None,
            ..Settings::default()
        };
        self.stats = self.renderer.render(&self.prepared, &drawn, &settings, &mut self.frame);
        if !self.coarse {
            self.full_frame = self.stats.total;
        }
        let (width, height) = (self.viewport.width() as usize, self.viewport.height() as usize);
        copy_scaled(&self.frame, width, height, &mut self.pixels);

        let canvas = Canvas { pixels: &mut self.pixels, width, height };
        if let Some(frozen) = &self.frozen {
            let lines = Lines::new(canvas, &view, &self.frame);
            draw_frozen(lines, &self.prepared, frozen, self.boxes, hud::scale(height) as f64);
        }
        self.draw_hud(width, height);
    }

    fn draw_hud(&mut self, width: usize, height: usize) {
        let panels = [
            Some((self.status(), [0, 0])),
            self.frozen.as_ref().map(|frozen| (self.legend(frozen), [0, 1])),
            self.help.then(|| (help(), [1, 0])),
            self.notice.as_ref().map(|notice| (vec![vec![span(WHITE, notice)]], [1, 1])),
        ];
        let mut canvas = Canvas { pixels: &mut self.pixels, width, height };
        let scale = hud::scale(height);
        for (lines, [right, down]) in panels.into_iter().flatten() {
            let (w, h) = hud::size(&lines, scale);
            let at = |side: usize, own: usize, end: usize| match end {
                0 => 8 * scale,
                _ => side.saturating_sub(own + 8 * scale),
            };
            hud::panel(&mut canvas, at(width, w, right), at(height, h, down), &lines);
        }
    }

    /// What is drawn, and how fast.
    fn status(&self) -> Vec<Line> {
        let (objects, triangles) = (self.stats.objects, self.stats.triangles);
        let speed = self.frame_time.map_or(String::new(), |time| {
            let seconds = time.as_secs_f64().max(1e-6);
            format!("{:.0} fps  {:.1} ms  ", 1.0 / seconds, seconds * 1e3)
        });
        let coarse = if self.coarse { "  half resolution" } else { "" };
        let row = |name: &str, value: String, note: String| {
            vec![span(GREY, format!("{name:<10}")), span(WHITE, value), span(GREY, note)]
        };
        vec![
            vec![
                span(WHITE, speed),
                span(GREY, format!("{}x{}{coarse}", self.viewport.width(), self.viewport.height())),
            ],
            row(
                "objects",
                format!("{} drawn  {} culled", objects.n_drawn, objects.n_outside),
                format!("  of {}", objects.n_in),
            ),
            row(
                "triangles",
                format!("{} drawn", triangles.n_drawn),
                format!("  of {} in drawn objects", triangles.n_in),
            ),
            row("test", test_name(self.test), "  H: help".into()),
        ]
    }

    /// How many objects got which verdict.
    fn legend(&self, frozen: &Frozen) -> Vec<Line> {
        let count = |mark| frozen.marks.iter().filter(|&&found| found == mark).count();
        let total = frozen.marks.len();
        let mut lines = vec![
            vec![span(WHITE, "frustum frozen")],
            vec![span(GREY, format!("{total} objects by {}", test_name(self.test)))],
        ];
        for mark in Mark::ALL {
            let n = count(mark);
            if mark.is_kept() || n > 0 {
                let name =
                    format!("{}{}", if mark.is_outside() { "out: " } else { "" }, mark.name());
                lines.push(vec![
                    span(mark.color(), format!("{name:<20}")),
                    span(WHITE, format!("{n:>7}")),
                ]);
            }
        }
        lines
    }
}

/// The frozen frustum, and a box around every object in the colour of its verdict. What matters
/// most comes last, on top.
fn draw_frozen(
    mut lines: Lines<'_>,
    prepared: &Prepared,
    frozen: &Frozen,
    boxes: bool,
    scale: f64,
) {
    let thin = |color, opacity| Stroke { color, width: scale, opacity, behind: 0.2 };
    let layer = |mark: Mark| match mark {
        Mark::FalseVisible => Some(2),
        mark if mark.is_outside() => Some(0),
        mark => mark.is_kept().then_some(1),
    };
    for (i, opacity) in [0.7, 0.9, 1.0].into_iter().enumerate().filter(|_| boxes) {
        for (item, &mark) in prepared.items().iter().zip(&frozen.marks) {
            if layer(mark) == Some(i) {
                lines.aabb(&item.bounds, &thin(mark.color(), opacity));
            }
        }
    }
    // An endless frustum is cut off where the scene ends.
    let camera = frozen.view.camera();
    let corners = prepared.bounds().corners().into_iter();
    let reach = corners.map(|corner| (camera.eye() - corner).dot(camera.back()));
    let reach = reach.filter(|reach| reach.is_finite()).fold(0.0, f64::max);
    let white = Stroke { color: 0xff_ffff, width: 2.0 * scale, opacity: 1.0, behind: 0.4 };
    lines.frustum(&frozen.view, reach, &white, plane_color);
}

fn help() -> Vec<Line> {
    let line =
        |(key, what): (&str, &str)| vec![span(WHITE, format!("{key:<12}")), span(GREY, what)];
    HELP.into_iter().map(line).collect()
}

fn framed(prepared: &Prepared, viewport: Viewport, direction: glam::DVec3) -> Orbit {
    let camera = frame_direction(prepared, viewport.aspect(), direction);
    Orbit::new(&camera, &prepared.bounds()).with_near_eye()
}

fn test_of(digit: u8) -> Option<Test> {
    let tests = [Test::None, Test::Corners, Test::PVertex, Test::Reverse, Test::Both, Test::Sat];
    tests.get(usize::from(digit)).copied()
}

/// The name that `cullet render --cull` knows.
fn test_name(test: Test) -> String {
    test.name().replace('_', "-")
}

fn half(viewport: Viewport) -> Viewport {
    let half = Viewport::new(viewport.width().div_ceil(2), viewport.height().div_ceil(2));
    half.unwrap_or(viewport)
}

/// The colours of `frame` as 0RGB words, each pixel repeated as often as it takes to fill
/// `width * height`.
fn copy_scaled(frame: &Frame, width: usize, height: usize, pixels: &mut Vec<u32>) {
    pixels.clear();
    let (columns, rows) = (frame.width as usize, frame.height as usize);
    for y in 0..height {
        let row = &frame.rgba8[y * rows / height * columns..][..columns];
        let word = |[r, g, b, _]: [u8; 4]| u32::from_be_bytes([0, r, g, b]);
        pixels.extend((0..width).map(|x| word(row[x * columns / width])));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cullet::scene::synth::synth;

    fn app() -> App {
        let prepared = Prepared::new(synth("box-grid:4").unwrap()).unwrap();
        App::new(prepared, None, Viewport::new(160, 90).unwrap())
    }

    fn picture(app: &mut App) -> Vec<u32> {
        app.draw(false);
        app.pixels().to_vec()
    }

    fn press(app: &mut App, key: Key) -> Option<Request> {
        app.input(Input::Key(key))
    }

    #[test]
    fn keys_that_ask_for_something() {
        let mut app = app();
        assert_eq!(press(&mut app, Key::Escape), Some(Request::Quit));
        assert_eq!(press(&mut app, Key::P), Some(Request::Screenshot));
        let Some(Request::PrintCamera(file)) = press(&mut app, Key::C) else { panic!() };
        assert!(file.contains("\"width\": 160"), "{file}");
        assert_eq!(press(&mut app, Key::Digit(9)), None);
    }

    #[test]
    fn everything_that_toggles_shows_and_goes_away_again() {
        let mut app = app();
        app.input(Input::Zoom(8.0));
        let plain = picture(&mut app);
        for key in [Key::H, Key::Space] {
            press(&mut app, key);
            assert_ne!(picture(&mut app), plain, "{key:?}");
            press(&mut app, key);
            assert_eq!(picture(&mut app), plain, "{key:?}");
        }
        press(&mut app, Key::R);
        assert_ne!(picture(&mut app), plain, "there is a notice");
        app.input(Input::Zoom(0.0));
        assert_eq!(picture(&mut app), plain, "the notice is gone");
    }

    #[test]
    fn boxes_show_while_frozen() {
        let mut app = app();
        let plain = picture(&mut app);
        press(&mut app, Key::B);
        assert_eq!(picture(&mut app), plain);
        press(&mut app, Key::Space);
        let without = picture(&mut app);
        press(&mut app, Key::B);
        assert_ne!(picture(&mut app), without);
    }

    #[test]
    fn a_frozen_frustum_keeps_what_it_saw_wherever_the_camera_goes() {
        let mut app = app();
        app.input(Input::Zoom(12.0));
        app.draw(false);
        let seen = app.stats().objects.n_drawn;
        assert!(0 < seen && seen < app.stats().objects.n_in);
        press(&mut app, Key::Space);
        assert!(app.is_frozen());
        app.input(Input::Zoom(-14.0));
        app.input(Input::Turn { right: 40.0, down: 10.0 });
        app.draw(false);
        assert_eq!(app.stats().objects.n_drawn, seen);
        press(&mut app, Key::Digit(0));
        app.draw(false);
        assert_eq!(app.stats().objects.n_drawn, app.stats().objects.n_in);
        press(&mut app, Key::Digit(2));
        press(&mut app, Key::Space);
        app.draw(false);
        assert_eq!(app.stats().objects.n_outside, 0, "seen from afar, nothing is outside");
    }

    #[test]
    fn the_marks_agree_with_the_renderer() {
        let mut app = app();
        app.input(Input::Zoom(12.0));
        press(&mut app, Key::Space);
        app.input(Input::Zoom(-20.0));
        for digit in 0..=5 {
            press(&mut app, Key::Digit(digit));
            app.draw(false);
            let marks = &app.frozen.as_ref().unwrap().marks;
            let n_kept = marks.iter().filter(|mark| mark.is_kept()).count();
            assert_eq!(n_kept as u64, app.stats().objects.n_drawn, "{digit}");
            let in_vain = marks.contains(&Mark::FalseVisible);
            assert!(!in_vain || digit != 5, "the exact test keeps nothing in vain");
            assert!(in_vain || digit != 0, "no test keeps everything");
        }
    }

    #[test]
    fn slow_frames_are_coarse_while_moving_and_fine_at_rest() {
        let mut app = app();
        let fine = picture(&mut app);
        app.full_frame = 2 * SLOW;
        app.draw(true);
        assert!(app.is_coarse());
        assert_ne!(app.pixels(), fine);
        assert_eq!(app.full_frame, 2 * SLOW, "a coarse frame says nothing about a full one");
        assert_eq!(picture(&mut app), fine);
        assert!(!app.is_coarse());
        app.full_frame = 2 * SLOW;
        press(&mut app, Key::R);
        app.draw(true);
        assert!(!app.is_coarse());
    }

    #[test]
    fn framing_undoes_a_walk_but_keeps_the_direction() {
        let mut app = app();
        let camera = *app.orbit.camera();
        app.input(Input::Zoom(5.0));
        app.input(Input::Pan { right: 30.0, down: -20.0 });
        press(&mut app, Key::F);
        assert!((app.orbit.camera().eye() - camera.eye()).length() < 1e-9);
        app.input(Input::Turn { right: 30.0, down: 0.0 });
        let back = app.orbit.camera().back();
        press(&mut app, Key::F);
        assert!((app.orbit.camera().back() - back).length() < 1e-12);
    }

    #[test]
    fn any_size_can_be_drawn() {
        let mut app = app();
        press(&mut app, Key::H);
        press(&mut app, Key::Space);
        for (width, height) in [(0, 0), (1, 1), (3, 200), (201, 7)] {
            app.input(Input::Resize(width, height));
            app.full_frame = 2 * SLOW;
            app.draw(true);
            app.draw(false);
            assert_eq!(app.pixels().len() as u32, width.max(1) * height.max(1));
        }
        app.input(Input::Resize(u32::MAX, 1));
        assert_eq!(app.size(), (201, 7));
    }

    #[test]
    fn an_empty_scene_is_a_background() {
        let scene = cullet::scene::Scene::default();
        let mut app = App::new(Prepared::new(scene).unwrap(), None, Viewport::new(64, 48).unwrap());
        for key in [Key::Space, Key::F, Key::Digit(5), Key::H] {
            press(&mut app, key);
            app.draw(false);
        }
        assert_eq!(app.stats().objects.n_in, 0);
    }
}
