//! SIGINT and SIGTERM: remove what is unfinished, then go with the code that names them.

/// Starts to listen. Where that is impossible the system's own behaviour stays.
#[cfg(unix)]
pub fn listen() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
    let wait = move || {
        if let Some(signal) = signals.forever().next() {
            let _held = crate::output::abandon();
            std::process::exit(128 + signal);
        }
    };
    let _ = std::thread::Builder::new().name("signals".into()).spawn(wait);
}

/// There are no such signals here.
#[cfg(not(unix))]
pub fn listen() {}
