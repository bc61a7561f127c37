//! The window: minifb on one side, the [`App`] on the other, nothing in between.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use cullet_view::{App, Input, Key, Request};
use minifb::{InputCallback, MouseButton, MouseMode, Window, WindowOptions};

use crate::{Failure, OUTPUT, print, screenshot};

/// Opens a window on `app` and stays until it is closed.
pub fn run(mut app: App, scene: &str) -> Result<(), Failure> {
    let mut window = open(&app, scene)?;
    let keys = Keys::default();
    window.set_input_callback(Box::new(keys.clone()));
    window.set_target_fps(60);
    let mut mouse = Mouse::default();
    let mut clock = Clock::default();
    let mut stale = true;
    while window.is_open() {
        let mut moving = false;
        for input in inputs(&app, &window, &keys, &mut mouse) {
            moving |= !matches!(input, Input::Key(_));
            stale = true;
            match app.input(input) {
                None => {}
                Some(Request::Quit) => return Ok(()),
                Some(Request::PrintCamera(file)) => print(&file),
                Some(Request::Screenshot) => {
                    let (Ok(notice) | Err(notice)) = screenshot(&mut app);
                    app.set_notice(notice);
                }
            }
        }
        let draws = stale || app.is_coarse();
        if draws {
            app.draw(moving);
        }
        stale = false;
        if let Some(frame_time) = clock.tick(draws) {
            app.set_frame_time(frame_time);
        }
        // The picture is handed over even if it is the same: a window that was covered asks again.
        let (width, height) = app.size();
        window
            .update_with_buffer(app.pixels(), width as usize, height as usize)
            .map_err(|error| Failure::new(OUTPUT, format!("the window is lost: {error}")))?;
    }
    Ok(())
}

fn open(app: &App, scene: &str) -> Result<Window, Failure> {
    let (width, height) = app.size();
    let title = format!("{scene} - Cullet");
    let options = WindowOptions { resize: true, ..WindowOptions::default() };
    Window::new(&title, width as usize, height as usize, options).map_err(|error| {
        let remedy = "set DISPLAY to an X11 server, or draw a picture with `cullet render`";
        Failure::new(OUTPUT, format!("no window can be opened ({error}): {remedy}"))
    })
}

/// What happened since the last frame.
fn inputs(app: &App, window: &Window, keys: &Keys, mouse: &mut Mouse) -> Vec<Input> {
    let mut inputs: Vec<_> = keys.take(window.is_active()).into_iter().map(Input::Key).collect();
    inputs.extend(mouse.drag(window));
    let (width, height) = window.get_size();
    let size = (width.max(1) as u32, height.max(1) as u32);
    if size != app.size() {
        inputs.push(Input::Resize(size.0, size.1));
    }
    if let Some((_, steps)) = window.get_scroll_wheel() {
        inputs.push(Input::Zoom(steps.into()));
    }
    inputs
}

/// Keys as the window system tells them. Asking for the keys that are down would lose those that
/// are tapped faster than frames are drawn.
#[derive(Clone, Debug, Default)]
struct Keys(Rc<RefCell<KeyLog>>);

#[derive(Debug, Default)]
struct KeyLog {
    pressed: Vec<Key>,
    /// A held key repeats its press; only the first one counts.
    held: Vec<minifb::Key>,
}

impl Keys {
    fn take(&self, active: bool) -> Vec<Key> {
        let mut log = self.0.borrow_mut();
        if !active {
            log.held.clear(); // releases go to another window
        }
        std::mem::take(&mut log.pressed)
    }
}

impl InputCallback for Keys {
    fn add_char(&mut self, _: u32) {}

    fn set_key_state(&mut self, key: minifb::Key, down: bool) {
        let mut log = self.0.borrow_mut();
        let held = log.held.contains(&key);
        log.held.retain(|&other| other != key);
        if down {
            log.held.push(key);
            log.pressed.extend(meaning(key).filter(|_| !held));
        }
    }
}

fn meaning(key: minifb::Key) -> Option<Key> {
    use minifb::Key as K;
    Some(match key {
        K::B => Key::B,
        K::C => Key::C,
        K::Escape => Key::Escape,
        K::F | K::Home => Key::F,
        K::H => Key::H,
        K::P => Key::P,
        K::R => Key::R,
        K::Space => Key::Space,
        K::Key0 | K::NumPad0 => Key::Digit(0),
        K::Key1 | K::NumPad1 => Key::Digit(1),
        K::Key2 | K::NumPad2 => Key::Digit(2),
        K::Key3 | K::NumPad3 => Key::Digit(3),
        K::Key4 | K::NumPad4 => Key::Digit(4),
        K::Key5 | K::NumPad5 => Key::Digit(5),
        _ => return None,
    })
}

/// Where the pointer was while which button was down.
#[derive(Debug, Default)]
struct Mouse(Option<(MouseButton, f32, f32)>);

impl Mouse {
    /// What the pointer dragged since the last frame.
    fn drag(&mut self, window: &Window) -> Option<Input> {
        let buttons = [MouseButton::Left, MouseButton::Right, MouseButton::Middle];
        let down = buttons.into_iter().find(|&button| window.get_mouse_down(button));
        let now = down.zip(window.get_unscaled_mouse_pos(MouseMode::Pass));
        let now = now.map(|(button, (x, y))| (button, x, y));
        let (before, now) = (std::mem::replace(&mut self.0, now)?, now?);
        let (right, down) = (f64::from(now.1 - before.1), f64::from(now.2 - before.2));
        if before.0 != now.0 || (right, down) == (0.0, 0.0) {
            return None;
        }
        Some(match now.0 {
            MouseButton::Left => Input::Turn { right, down },
            _ => Input::Pan { right, down },
        })
    }
}

/// How long frames take, evened out, as far as one follows the other.
#[derive(Debug, Default)]
struct Clock {
    last: Option<Instant>,
    mean: Option<f64>,
}

impl Clock {
    /// Called once per frame; `draws`: this one was drawn anew.
    fn tick(&mut self, draws: bool) -> Option<Duration> {
        let now = Instant::now();
        let last = std::mem::replace(&mut self.last, draws.then_some(now));
        let seconds = (now - last.filter(|_| draws)?).as_secs_f64();
        let mean = self.mean.map_or(seconds, |mean| mean + 0.2 * (seconds - mean));
        self.mean = Some(mean);
        Some(Duration::from_secs_f64(mean))
    }
}
