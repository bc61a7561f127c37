//! What the figures were measured on.

use serde::Serialize;

/// As far as the system tells.
#[derive(Clone, Debug, Serialize)]
pub struct Machine {
    /// The processor's name.
    pub processor: String,
    /// Threads that can run at once.
    pub cores: usize,
    /// The widest instruction set in use.
    pub simd: String,
    /// System and architecture.
    pub system: String,
    /// `release` or `debug`.
    pub build: &'static str,
    /// Runnable programs per core when the run began, averaged over a minute; `None` where the
    /// system does not tell. Above 1, other programs were in the way.
    pub load_per_core: Option<f64>,
}

impl Machine {
    /// This one, now.
    pub fn here() -> Machine {
        let cores = std::thread::available_parallelism().map_or(1, |n| n.get());
        let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
        let load = std::fs::read_to_string("/proc/loadavg").ok();
        let load = load.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
        let simd = cullet::cull::wide::levels().first().map_or("scalar", |(name, _)| *name);
        Machine {
            processor: processor.unwrap_or_else(|| "unknown".into()),
            cores,
            simd: simd.replace("scalar", "fallback"),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            build: if cfg!(debug_assertions) { "debug" } else { "release" },
            load_per_core: load.map(|load| load / cores as f64),
        }
    }

    /// In one line.
    pub fn words(&self) -> String {
        let Machine { processor, cores, simd, system, build, load_per_core } = self;
        let load = load_per_core.map_or(String::new(), |load| format!(", load {load:.2} per core"));
        format!("{processor}, {cores} cores, {simd}, {system}, {build} build{load}")
    }
}
