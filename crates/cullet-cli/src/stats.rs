//! What a run did and how long it took, as JSON for `--stats`.
//!
//! All times are in milliseconds of wall time for one frame, the median one when there were
//! several, except for `cpu_min_ms`: processor time of the whole process, all threads. Stages never
//! overlap, whatever happens within them, so `total` is their sum (of the frame: and of what lies
//! between them). `parts` tells what some of them consist of.

use std::time::Duration;

use cullet::{FrameStats, LoadTimes, PrepareTimes};
use serde::Serialize;
use serde_json::Value;

/// Changes whenever a key changes its meaning or goes.
const SCHEMA: u32 = 1;

/// The times of all measured frames.
#[derive(Clone, Debug)]
pub struct Frames {
    /// The frame of median time (the faster of two in the middle).
    pub median: FrameStats,
    /// Wall time of the fastest.
    pub min: Duration,
    /// Least processor time of any; `None` when the system does not tell.
    pub cpu_min: Option<Duration>,
}

impl Frames {
    /// Sums up frames with their processor times; `None` when there are none.
    pub fn of(mut frames: Vec<(FrameStats, Option<Duration>)>) -> Option<Frames> {
        frames.sort_by_key(|(stats, _)| stats.total);
        let (median, _) = *frames.get(frames.len().checked_sub(1)? / 2)?;
        let cpu_min = frames.iter().filter_map(|(_, cpu)| *cpu).min();
        Some(Frames { median, min: frames[0].0.total, cpu_min })
    }
}

/// Times outside the frame.
#[derive(Clone, Copy, Debug)]
pub struct Around {
    /// Reading and decoding the scene.
    pub load: Duration,
    /// Parts of it, all threads together.
    pub load_times: LoadTimes,
    /// Boxes, clusters, texture pyramids.
    pub prepare: Duration,
    /// Parts of it, all threads together.
    pub prepare_times: PrepareTimes,
    /// Samples to file bytes, all pictures.
    pub encode: Duration,
}

/// The report; its fields are the keys.
#[derive(Debug, Serialize)]
pub struct Report<'a> {
    schema: u32,
    version: &'static str,
    frame: f64,
    min_ms: f64,
    median_ms: f64,
    cpu_min_ms: Option<f64>,
    stages: Stages,
    parts: Parts,
    total: f64,
    boxes_tested: u64,
    objects: Objects,
    clusters: Clusters,
    triangles: Triangles,
    pixels_shaded: u64,
    samples_written: u64,
    scratch_bytes: u64,
    peak_rss_bytes: Option<u64>,
    warnings: &'a [String],
    left_out: &'a [String],
    settings: Value,
}

#[derive(Debug, Serialize)]
struct Stages {
    load: f64,
    prepare: f64,
    cull: f64,
    geometry: f64,
    raster: f64,
    shade: f64,
    resolve: f64,
    encode: f64,
}

/// What stages consist of. Parts are done side by side, and their times are of all threads together.
#[derive(Debug, Serialize)]
struct Parts {
    /// Of `load`: vertices and triangles.
    geometry: f64,
    /// Of `load`: pixels of images.
    images: f64,
    /// Of `load` and `prepare`: smaller copies of images.
    pyramids: f64,
    /// Of `prepare`: meshes cut into clusters.
    clusters: f64,
}

#[derive(Debug, Serialize)]
struct Objects {
    r#in: u64,
    culled: CulledObjects,
    drawn: u64,
}

#[derive(Debug, Serialize)]
struct CulledObjects {
    empty: u64,
    outside: u64,
    /// By `--min-size`.
    small: u64,
}

#[derive(Debug, Serialize)]
struct Clusters {
    r#in: u64,
    culled: CulledClusters,
    drawn: u64,
}

#[derive(Debug, Serialize)]
struct CulledClusters {
    outside: u64,
    between_samples: u64,
    hidden: u64,
}

#[derive(Debug, Serialize)]
struct Triangles {
    r#in: u64,
    culled: CulledTriangles,
    clipped: u64,
    drawn: u64,
}

#[derive(Debug, Serialize)]
struct CulledTriangles {
    /// Of objects that were culled whole.
    with_object: u64,
    /// Of clusters that were culled whole.
    with_cluster: u64,
    not_finite: u64,
    outside: u64,
    zero_area: u64,
    facing_away: u64,
}

impl<'a> Report<'a> {
    /// Puts a report together. `total` is one load, preparation, frame and encoding.
    pub fn new(
        frames: &Frames,
        around: &Around,
        warnings: &'a [String],
        left_out: &'a [String],
        settings: Value,
    ) -> Self {
        let stats = &frames.median;
        let (objects, clusters, triangles) = (&stats.objects, &stats.clusters, &stats.triangles);
        Report {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION"),
            frame: ms(stats.total),
            min_ms: ms(frames.min),
            median_ms: ms(stats.total),
            cpu_min_ms: frames.cpu_min.map(ms),
            stages: Stages {
                load: ms(around.load),
                prepare: ms(around.prepare),
                cull: ms(stats.stages.cull),
                geometry: ms(stats.stages.geometry),
                raster: ms(stats.stages.raster),
                shade: ms(stats.stages.shade),
                resolve: ms(stats.stages.resolve),
                encode: ms(around.encode),
            },
            parts: Parts {
                geometry: ms(around.load_times.geometry),
                images: ms(around.load_times.images),
                pyramids: ms(around.load_times.pyramids + around.prepare_times.pyramids),
                clusters: ms(around.prepare_times.clusters),
            },
            total: ms(around.load + around.prepare + stats.total + around.encode),
            boxes_tested: stats.boxes_tested,
            objects: Objects {
                r#in: objects.n_in,
                culled: CulledObjects {
                    empty: objects.n_empty,
                    outside: objects.n_outside,
                    small: objects.n_small,
                },
                drawn: objects.n_drawn,
            },
            clusters: Clusters {
                r#in: clusters.n_in,
                culled: CulledClusters {
                    outside: clusters.n_outside,
                    between_samples: clusters.n_between_samples,
                    hidden: clusters.n_hidden,
                },
                drawn: clusters.n_drawn,
            },
            triangles: Triangles {
                r#in: triangles.n_in
                    + stats.n_triangles_of_culled_objects
                    + stats.n_triangles_of_culled_clusters,
                culled: CulledTriangles {
                    with_object: stats.n_triangles_of_culled_objects,
                    with_cluster: stats.n_triangles_of_culled_clusters,
                    not_finite: triangles.n_not_finite,
                    outside: triangles.n_outside,
                    zero_area: triangles.n_zero_area,
                    facing_away: triangles.n_facing_away,
                },
                clipped: triangles.n_clipped,
                drawn: triangles.n_drawn,
            },
            pixels_shaded: stats.pixels_shaded,
            samples_written: stats.samples_written,
            scratch_bytes: stats.scratch_bytes,
            peak_rss_bytes: peak_rss_bytes(),
            warnings,
            left_out,
            settings,
        }
    }
}

/// A value as indented JSON with a line end.
pub fn json(value: &impl Serialize) -> Vec<u8> {
    let mut text = serde_json::to_vec_pretty(value).expect("these values have no odd keys");
    text.push(b'\n');
    text
}

fn ms(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

/// The most memory this process ever held, where the system tells (Linux).
fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(ms: u64) -> (FrameStats, Option<Duration>) {
        let stats = FrameStats { total: Duration::from_millis(ms), ..FrameStats::default() };
        (stats, Some(Duration::from_millis(10 * ms)))
    }

    #[test]
    fn the_median_is_a_frame_that_happened() {
        let frames = Frames::of([9, 1, 4, 2].map(frame).to_vec()).unwrap();
        assert_eq!(frames.median.total, Duration::from_millis(2));
        assert_eq!(frames.min, Duration::from_millis(1));
        assert_eq!(frames.cpu_min, Some(Duration::from_millis(10)));
        assert!(Frames::of(Vec::new()).is_none());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn this_process_takes_some_memory() {
        assert!(peak_rss_bytes().unwrap() > 100_000);
    }
}
