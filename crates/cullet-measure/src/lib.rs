//! How fast, how true? Every figure Cullet publishes about itself comes from here.
//!
//! *Fast*: [`Stopwatch`] times one piece of work until the figure holds still, [`Rounds`]
//! times rivals in turn so that a busy machine slows them all alike; both answer with a
//! [`Summary`] of seconds. *True*: two [`Picture`]s of one size go in, a number comes out:
//! [`max_abs`], [`mae`], [`mse`], [`psnr`], [`changed_pixels`], [`split_psnr`], [`ssim`], or
//! a whole [`ErrorMap`] from [`flip()`] ([`Perceived`] compares one picture with many), which
//! [`heatmap`] paints. [`ulps`] counts the floats
//! between two results, [`ids_differ_ppm`] the pixels that show another object. [`standings`]
//! weighs one against the other: which trades nothing beats. [`Table`] prints any of it.
//!
//! Values to values: nothing here reads files or prints. Image figures are the same on every
//! machine: sums run in row order in f64, transcendental functions come from `libm`.
//!
//! ```
//! use cullet_measure::{Picture, flip, psnr, PIXELS_PER_DEGREE};
//!
//! let reference = Picture::from_rgb(2, 1, &[255u8, 0, 0, 10, 20, 30])?;
//! let candidate = Picture::from_rgb(2, 1, &[255u8, 0, 0, 10, 20, 40])?;
//! assert!(psnr(&reference, &candidate)? > 35.0);
//! assert!(flip(&reference, &candidate, PIXELS_PER_DEGREE)?.mean() < 0.1);
//! # Ok::<(), cullet_measure::MeasureError>(())
//! ```

mod color;
mod convolve;
mod edges;
mod error;
mod error_map;
mod flip;
mod heatmap;
mod ids;
mod interleave;
mod pareto;
mod picture;
mod pixelwise;
mod ssim;
mod stopwatch;
mod summary;
mod table;
mod ulps;

pub use edges::{EDGE_GRADIENT, SplitPsnr, edge_mask, split_psnr};
pub use error::MeasureError;
pub use error_map::ErrorMap;
pub use flip::{PIXELS_PER_DEGREE, Perceived, flip};
pub use heatmap::{heat_color, heatmap};
pub use ids::{ids_differ_ppm, relative_quantile};
pub use interleave::{Comparison, Order, Rounds};
pub use pareto::{Standing, Trade, dominated_by, standings};
pub use picture::{Picture, Sample};
pub use pixelwise::{changed_pixels, mae, max_abs, mse, psnr};
pub use ssim::ssim;
pub use stopwatch::Stopwatch;
pub use summary::Summary;
pub use table::{Align, Table, csv_field};
pub use ulps::{ulps, ulps64};
