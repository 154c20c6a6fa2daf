//! The depth-complexity sweep: layers per pixel × pixels, for every method that blends discs or soft spheres, on scenes
//! with exact values of both.
//!
//! **Scenes.** In both built-in scenes every pixel has exactly as many fragments as the scene has layers, because a
//! mean says little about lists: [`Workload::Stack`] has few discs over the whole image, [`Workload::Mosaic`] many
//! discs of 9 pixels. They differ only in the work needed to reach the fragments. α = 1 − 2^(−1/layers): the stack
//! transmits half of the light for any number of layers, so every layer contributes to the image and none may be left
//! out. For soft methods the same points are soft spheres, whose chord through the center has that opacity.
//!
//! **Times.** A cell of the sweep is one scene. Each method renders it once with buffers of its own, which gives memory
//! and image, and once more to warm up. Then all methods of discs take turns, and after them all of soft spheres, so
//! that a machine that slows down affects all of them.
//!
//! **Errors.** Every method is compared with the exact picture of what it draws, in float64: the discs one behind the
//! other, or the integrals of the soft spheres (`soft-base`). The error of an exact method has a bound that follows
//! from its roundings. That of an approximation is stated, since its size is the method's own. That of a stochastic one
//! is counted in the standard errors that the method states.
//!
//! **Limits.** A cell is skipped, with the reason in the report, if it exceeds the allowed number of fragments, if a
//! method's own times so far predict too long a frame, or if a method can't render it.

mod entry;
mod files;
mod page;
pub(super) mod sweep;

use serde::{Deserialize, Serialize};

use super::fit::{PowerLaw, power_law};

use pellucid_core::metrics::error_text;
use pellucid_session::area::PixelArea;

pub use entry::{Entry, Expected};
pub use files::{FILES, Report, write};
pub use page::expected;
pub use sweep::run;

/// Built-in scene that gives the layers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Workload {
    /// Each layer is a disc over the whole image.
    Stack,
    /// Each layer is tiled by discs of 3 × 3 pixels.
    Mosaic,
}

impl Workload {
    /// List of the workloads.
    pub const ALL: [Self; 2] = [Self::Stack, Self::Mosaic];

    /// The built-in scene's name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stack => "stack",
            Self::Mosaic => "mosaic",
        }
    }
}

/// The extent of the sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Width and height of the square images, in pixels, ascending.
    pub sides: Vec<u32>,
    /// Layers per pixel, ascending.
    pub layers: Vec<u32>,
    /// Methods that are compared, see [`Entry::all`].
    pub entries: Vec<Entry>,
    /// Frames behind each median, at least 1.
    pub frames: u32,
    /// Cells with more fragments are skipped.
    pub max_fragments: u64,
    /// Cells in which a method's frame is predicted to take longer, in seconds, are skipped for this method.
    pub max_seconds: f64,
    /// Seed of the scenes and of the pixels that are compared with the reference.
    pub seed: u64,
    /// Device memory in bytes, see [`pellucid_engine::methods::Frame::memory_budget`].
    pub memory_budget: Option<u64>,
}

impl Settings {
    /// The whole sweep: 1 to 4096 layers over 64², 256² and 1024² pixels.
    pub fn full(entries: Vec<Entry>) -> Self {
        Self {
            sides: vec![64, 256, 1024],
            layers: (0..=12).map(|power| 1 << power).collect(),
            entries,
            frames: 5,
            max_fragments: 1 << 26,
            max_seconds: 2.0,
            seed: 0,
            memory_budget: None,
        }
    }

    /// A part of it for a quick look and for tests: 1 to 1024 layers by fours, over 64² and 256² pixels.
    pub fn quick(entries: Vec<Entry>) -> Self {
        Self {
            sides: vec![64, 256],
            layers: (0..=5).map(|power| 1 << (2 * power)).collect(),
            frames: 3,
            max_fragments: 1 << 20,
            ..Self::full(entries)
        }
    }

    /// Scenes that a run goes through.
    pub fn cells(&self) -> usize {
        Workload::ALL.len() * self.sides.len() * self.layers.len()
    }
}

/// The measurements of one method on one scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cell {
    /// The scene.
    pub workload: Workload,
    /// Width and height of the image in pixels.
    pub side: u32,
    /// Fragments in each pixel.
    pub layers: u32,
    /// side².
    pub pixels: u64,
    /// Splats of the scene.
    pub points: u64,
    /// layers · pixels.
    pub fragments: u64,
    /// Fragments that the method counted; `None` if it doesn't count any.
    pub counted: Option<u64>,
    /// [`Entry::name`].
    pub method: &'static str,
    /// Device time of all passes.
    pub gpu_ms: Spread,
    /// Time from the first submission to the end of read-back, on the host's clock.
    pub wall_ms: Spread,
    /// Largest number of device bytes at any time of a frame, cloud and image included.
    pub peak_device_bytes: u64,
    /// Bytes of the fragment buffer.
    pub fragment_bytes: u64,
    /// Bands that the image was cut into.
    pub bands: u64,
    /// Error against the exact picture in float64.
    pub error: Deviation,
    /// The error that is expected.
    #[serde(rename = "kind")]
    pub expected: Expected,
    /// Each pass in the order of its first run.
    pub passes: Vec<PassSpread>,
}

impl Cell {
    /// Millions of fragments per second of device time.
    pub fn mfragments_per_s(&self) -> f64 {
        self.fragments as f64 / (1e3 * self.gpu_ms.median)
    }

    /// Largest error that the roundings of an exact method explain; `None` for other methods.
    pub fn bound(&self) -> Option<f64> {
        if let Expected::Exact(bound) = self.expected { Some(bound) } else { None }
    }

    /// True if the error is within what is expected of the method; `None` for an approximation, of which no error is
    /// expected.
    pub fn holds(&self) -> Option<bool> {
        self.expected.holds(&self.error)
    }

    /// [`Self::peak_device_bytes`] over fragments.
    pub fn bytes_per_fragment(&self) -> f64 {
        self.peak_device_bytes as f64 / self.fragments as f64
    }
}

/// The sampling error of a scene's exact picture: that of looking at the center of each pixel in place of its area.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Area {
    /// The scene.
    pub workload: Workload,
    /// Width and height of the image in pixels.
    pub side: u32,
    /// Fragments in each pixel.
    pub layers: u32,
    /// Error and numbers of samples.
    #[serde(flatten)]
    pub error: PixelArea,
}

/// Summary of some measurements of one value.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    /// The least.
    pub min: f64,
    /// The middle one, or the mean of the middle two.
    pub median: f64,
    /// The greatest.
    pub max: f64,
}

impl Spread {
    /// Summarizes values; 0 if empty.
    pub fn from_values(values: Vec<f64>) -> Self {
        let min = values.iter().copied().reduce(f64::min).unwrap_or(0.0);
        let max = values.iter().copied().reduce(f64::max).unwrap_or(0.0);
        Self { min, median: pellucid_engine::profile::median(values), max }
    }
}

/// The error of an image against the reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Deviation {
    /// Largest difference in linear R, G, B and A.
    pub max: f64,
    /// Root of the mean squared difference in linear R, G, B.
    pub rmse: f64,
    /// Pixels that were compared: all, or a random sample.
    pub pixels: usize,
    /// `rmse` over the root mean square of the standard errors that the image states of these pixels: about 1 if they
    /// are right. `None` for an image without standard errors.
    pub standard_errors: Option<f64>,
}

/// A pass with its time, summed over all batches of fragments.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PassSpread {
    /// Name as in `plan`.
    pub name: &'static str,
    /// Device time.
    pub gpu_ms: Spread,
}

/// A cell that was not measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Skipped {
    /// The scene.
    pub workload: Workload,
    /// Width and height of the image in pixels.
    pub side: u32,
    /// Fragments in each pixel.
    pub layers: u32,
    /// [`Entry::name`].
    pub method: &'static str,
    /// Reason for the omission.
    pub reason: String,
}

/// The growth of a method's time with the number of layers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Slope {
    /// The scene.
    pub workload: Workload,
    /// Width and height of the image in pixels.
    pub side: u32,
    /// [`Entry::name`].
    pub method: &'static str,
    /// Least and most layers of the cells that were fitted: the deeper half of those measured, at least three.
    pub layers: [u32; 2],
    /// Milliseconds of device time over layers.
    #[serde(flatten)]
    pub law: PowerLaw,
}

impl Slope {
    /// The slope of a cell's series among some; `None` where the series is too short.
    pub fn of<'a>(slopes: &'a [Self], cell: &Cell) -> Option<&'a Self> {
        slopes.iter().find(|s| (s.workload, s.side, s.method) == (cell.workload, cell.side, cell.method))
    }
}

/// All that a run found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sweep {
    /// Measured cells, in the order of measurement.
    pub cells: Vec<Cell>,
    /// The others.
    pub skipped: Vec<Skipped>,
    /// Sampling errors of the exact pictures of scenes, as far as there was time.
    pub areas: Vec<Area>,
}

impl Sweep {
    /// The cells of one line of the plots, by ascending layers.
    pub fn series(&self, workload: Workload, side: u32, method: &str) -> Vec<&Cell> {
        let belongs = |cell: &&Cell| cell.workload == workload && cell.side == side && cell.method == method;
        self.cells.iter().filter(belongs).collect()
    }

    /// The last cell of each series.
    pub fn deepest(&self) -> Vec<&Cell> {
        let is_last = |cell: &&Cell| {
            let series = self.series(cell.workload, cell.side, cell.method);
            series.last().is_some_and(|last| last.layers == cell.layers)
        };
        self.cells.iter().filter(is_last).collect()
    }

    /// The largest sampling error of each workload, as one line; none if none was measured.
    pub fn area_text(&self) -> Option<String> {
        let largest = |workload: &Workload| {
            let of_it = self.areas.iter().filter(|area| area.workload == *workload);
            of_it.max_by(|a, b| a.error.rmse.total_cmp(&b.error.rmse))
        };
        let text = |area: &Area| {
            let Area { workload, side, layers, error } = area;
            let PixelArea { method, against, rmse, .. } = error;
            let (name, rmse) = (workload.name(), error_text(*rmse));
            format!("{name} RMSE {rmse} ({method}, {side} × {side} pixels, {layers} layers, against {against} samples)")
        };
        let found: Vec<String> = Workload::ALL.iter().filter_map(largest).map(text).collect();
        let about = "pixel area: the exact picture with 1 sample in a pixel against itself with more, at most";
        (!found.is_empty()).then(|| format!("{about}: {}", found.join("; ")))
    }

    /// The growth of time in each series that is long enough.
    ///
    /// Only the deeper half of a series is fitted: shallow frames cost the same for any number of layers.
    pub fn slopes(&self) -> Vec<Slope> {
        let mut slopes = Vec::new();
        for &Cell { workload, side, method, .. } in self.deepest() {
            let series = self.series(workload, side, method);
            let deep = &series[series.len() - series.len().div_ceil(2).max(3).min(series.len())..];
            if deep.len() < 3 {
                continue;
            }
            let points: Vec<_> = deep.iter().map(|cell| (f64::from(cell.layers), cell.gpu_ms.median)).collect();
            if let Some(law) = power_law(&points) {
                let layers = [deep[0].layers, deep[deep.len() - 1].layers];
                slopes.push(Slope { workload, side, method, layers, law });
            }
        }
        slopes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(method: &'static str, layers: u32, ms: f64) -> Cell {
        Cell {
            workload: Workload::Stack,
            side: 8,
            layers,
            pixels: 64,
            points: layers.into(),
            fragments: 64 * u64::from(layers),
            counted: None,
            method,
            gpu_ms: Spread::from_values(vec![ms]),
            wall_ms: Spread::from_values(vec![ms]),
            peak_device_bytes: 0,
            fragment_bytes: 0,
            bands: 1,
            error: Deviation { max: 0.0, rmse: 0.0, pixels: 64, standard_errors: None },
            expected: Expected::Stated,
            passes: Vec::new(),
        }
    }

    #[test]
    fn slopes_are_those_of_the_deeper_half_of_each_method() {
        let mut cells: Vec<Cell> = [1, 2, 4, 8].map(|layers| cell("flat", layers, 5.0)).into();
        // A fixed cost up to 4 layers, then quadratic: of seven cells the last four are fitted.
        let deep = [16.0, 16.0, 16.0, 64.0, 256.0, 1024.0, 4096.0];
        cells.extend(deep.iter().enumerate().map(|(i, ms)| cell("deep", 1 << i, *ms)));
        cells.extend([1, 2].map(|layers| cell("short", layers, 5.0)));
        let sweep = Sweep { cells, ..Sweep::default() };
        let slopes = sweep.slopes();
        let found: Vec<_> = slopes.iter().map(|s| (s.method, s.layers, s.law.exponent)).collect();
        assert!(matches!(found[..], [("flat", [2, 8], _), ("deep", [8, 64], _)]), "{found:?}");
        assert!(found[0].2.abs() < 1e-12 && (found[1].2 - 2.0).abs() < 1e-12, "{found:?}");
        assert_eq!(sweep.deepest().iter().map(|cell| cell.layers).collect::<Vec<_>>(), [8, 64, 2]);
    }

    #[test]
    fn the_line_of_the_pixel_area_has_the_largest_error_of_each_scene() {
        let area = |workload, layers, rmse| {
            let error = PixelArea { method: "abuffer".to_owned(), samples: 1, against: 64, rmse };
            Area { workload, side: 8, layers, error }
        };
        let areas = [(Workload::Stack, 1, 0.0), (Workload::Mosaic, 1, 0.01), (Workload::Mosaic, 4, 0.25)];
        let areas = areas.map(|(workload, layers, rmse)| area(workload, layers, rmse)).to_vec();
        let text = Sweep { areas, ..Sweep::default() }.area_text().unwrap();
        let [stack, mosaic] = ["stack RMSE 0 (abuffer", "mosaic RMSE 2.50e-1 (abuffer, 8 × 8 pixels, 4 layers"];
        assert!(text.starts_with("pixel area: ") && text.contains(stack) && text.contains(mosaic), "{text}");
        assert_eq!(Sweep::default().area_text(), None);
    }

    #[test]
    fn spreads_by_hand() {
        assert_eq!(Spread::from_values(vec![3.0, 1.0, 2.0]), Spread { min: 1.0, median: 2.0, max: 3.0 });
        assert_eq!(Spread::from_values(Vec::new()), Spread { min: 0.0, median: 0.0, max: 0.0 });
    }
}
