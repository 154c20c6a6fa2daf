//! The counts of a frame, which explain its plan, its times and its memory.

use super::Outcome;
use super::spbr::{Adjusted, Form};
use crate::passes::bin::BinSurvey;
use crate::passes::project::Stats;
use crate::passes::raster::Walker;

/// The counts of a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Facts {
    /// Points of the scene, without those that [`Frame::detail`](super::Frame::detail) leaves out.
    pub points: u64,
    /// Points in the picture: at most as many as a limit of them allows. Without one, `points`.
    pub shown: u64,
    /// Gaussians among `points`.
    pub gaussians: u64,
    /// Splats whose rectangle touches the image (summed over windows; solid plus soft points, if a method separates
    /// them).
    pub visible: u64,
    /// Splats of more pixels than one invocation should walk (1024 on a CPU, 64 on a GPU), which are visited tile by
    /// tile.
    pub large: u64,
    /// Windows whose lists were filled in order of depth, from sorted splats.
    pub ordered: u64,
    /// Pairs of a splat and a tile that it meets, if splats were sorted.
    pub tile_entries: u64,
    /// Counters of the tiles' splats by run in the window with most of them, if splats are sorted.
    pub tile_cells: u64,
    /// Numbers of splats in a tile and the tiles with each, ascending, over all windows; only where
    /// [`Renderer::notes_tiles`](super::Renderer::notes_tiles) asks.
    pub tile_histogram: Vec<(u32, u64)>,
    /// Fragments of all lists.
    pub fragments: u64,
    /// Longest list.
    pub max_list: u32,
    /// Longest list to sort: a soft sphere has several fragments there, but counts once in the numbers above.
    pub max_events: u32,
    /// Layers that were peeled, the most of any window.
    pub layers: u32,
    /// Tiles of 16 × 16 pixels of all images that filters had, layer by layer and window by window.
    pub image_tiles: u64,
    /// Tiles processed by each filter: background fill, occlusion fill, smoothing, antialiasing; all iterations.
    pub filtered_tiles: [u64; 4],
    /// Iterations of background fill and occlusion fill that had tiles, the most of any layer and window.
    pub closing_runs: [u32; 2],
    /// Samples that a stochastic method took of each pixel.
    pub samples: u32,
    /// Ensembles that were drawn.
    pub ensembles: u32,
    /// Slots dealt to them: points of all clouds, each counted for every ensemble that contains it.
    pub slots: u64,
    /// The way the nearest points of ensembles are found.
    pub form: Option<Form>,
    /// Points of ensembles that are on the device at a time, if they are more than fit.
    pub streamed: Option<u64>,
    /// Bytes of them that went to the device during the frame.
    pub uploaded_bytes: u64,
    /// `true` if a pixel's nearest point has to be cleared between ensembles.
    pub renewed: bool,
    /// `true` if points of ensembles may cover more pixels than one invocation walks.
    pub listed: bool,
    /// Clouds too thin for their opacity, by their place in the list of clouds, with the thousandths that they reach of
    /// it.
    pub thin: Vec<ThinCloud>,
    /// The adjustment of the numbers of points that are dealt to ensembles.
    pub adjusted: Option<Adjusted>,
    /// Points that are not soft, of methods that tell; the others are.
    pub solid_points: u64,
    /// Splats of soft points among the visible ones.
    pub soft_visible: u64,
    /// Splats of soft points among the large ones.
    pub soft_large: u64,
    /// Bytes of the fragments that are stored at a time.
    pub fragment_bytes: u64,
    /// Bands over all windows; windows with anything in them, if splats are sorted.
    pub bands: u64,
    /// Drawings of opaque splats in three passes: windows of `hqs` and `splats` with anything in them, windows of the
    /// soft methods with solid points, layers of `one-layer` over all windows.
    pub splatted: u64,
    /// Windows of `one-layer` in which a layer of soft points covers opaque ones.
    pub layered: u64,
    /// Images through the eyes of a light that were made for shadows: 0 without shadows, and where the cloud has them.
    pub light_views: u64,
    /// Columns and rows of these images.
    pub light_resolution: u32,
    /// Images that were drawn one after the other: four at once are one.
    pub images: u64,
    /// Windows of the image; of each that is drawn for it, where it has samples.
    pub windows: u64,
    /// Images of windows whose nearest points were found with those of earlier ones.
    pub shared_walks: u64,
    /// Points of windows that were shaded once for all images.
    pub shaded_points: u64,
    /// Largest number of device bytes at any time of the frame, cloud and image included.
    pub peak_device_bytes: u64,
    /// The raster path: `compute` or `hardware`.
    pub raster: &'static str,
}

/// A cloud with fewer points per pixel than its opacity needs, for any number of ensembles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ThinCloud {
    /// Index of the cloud among the clouds of the scene.
    pub cloud: u32,
    /// Opacity of its surface in the image, in thousandths.
    pub reached: u32,
}

impl Facts {
    /// Adds a finished window.
    pub(super) fn note(&mut self, stats: &[Stats], walker: Walker) {
        self.windows += 1;
        self.raster = match walker {
            Walker::Compute => "compute",
            Walker::Hardware => "hardware",
        };
        self.meet(stats);
    }

    /// Adds the counts of a projection.
    pub(super) fn meet(&mut self, stats: &[Stats]) {
        for s in stats {
            self.visible += u64::from(s.visible);
            self.large += u64::from(s.large);
        }
    }

    /// Adds a window whose splats were binned.
    pub(super) fn note_binned(&mut self, cells: u64, entries: u64) {
        self.tile_cells = self.tile_cells.max(cells);
        self.tile_entries += entries;
    }

    /// Adds a window whose splats were only surveyed, not binned.
    pub(super) fn note_survey(&mut self, survey: BinSurvey) -> Outcome {
        match survey {
            BinSurvey::Nothing => {}
            BinSurvey::TooLarge => return Outcome::Overflow,
            BinSurvey::Cells(cells) => {
                self.tile_cells = self.tile_cells.max(cells);
                self.bands += 1;
            }
        }
        Outcome::Done
    }
}
