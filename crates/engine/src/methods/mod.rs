//! The methods: the passes that each frame records, and the renderer that runs them over windows and bands of the
//! image.

pub mod abuffer;
pub mod approximate;
pub mod brightness;
mod bytes;
pub mod cost;
pub mod deep;
pub(crate) mod edl;
pub mod ellipsoids;
pub mod encode;
mod engine;
mod error;
pub(crate) mod explain;
mod facts;
pub mod fading;
mod frame;
mod frame_profile;
pub mod image_space;
pub mod linked_list;
mod lists;
pub mod one_layer;
pub mod opaque;
mod parts;
pub mod peel;
pub mod peel_layers;
pub mod points;
mod projecting;
mod reach;
pub mod renderer;
pub mod see_through;
pub mod shadows;
pub mod soft;
pub mod sorted;
pub mod spbr;
pub mod splats;
pub mod stochastic;
mod target;
mod tiled;
mod told;
mod walker;

#[doc(hidden)]
pub use engine::Switches;
pub use error::Error;
pub use explain::Step;
pub use facts::{Facts, ThinCloud};
pub use frame::{Factors, Frame};
pub use frame_profile::{FrameProfile, PassProfile};
pub use parts::{DrawnPart, PartError, SamplePart, SampleSteps};
pub use reach::{need_subgroups, without_subgroups};
pub use renderer::{Rendered, Renderer};
pub use sorted::Stop;
pub use target::{Pixels, PixelsGroup, Target};

pub use crate::passes::timeline::Timeline;

use crate::gpu::Device;
use crate::passes::bin::Bins;
use crate::passes::project::Footprint;
use crate::passes::tiles::Tiles;
use crate::scene::{Hybrid, Interpolated, Method, Mlab, Tail, Wavelet};
use abuffer::Shown;
use engine::Engine;
use explain::{Absent, CLEAR, PassGroup, SCAN};

/// Returns the engine of a method.
pub(crate) fn engine_of(method: &Method) -> Box<dyn Engine> {
    use approximate::{ApproximateEngine, Kind};
    use fading::{Fading, FadingEngine};
    use soft::{ExpressEngine, Interior, SpheresEngine};
    let relief = method.relief();
    let nearest = |splats, footprint| Box::new(opaque::NearestEngine { splats, footprint, relief });
    let outlined = |of: Interpolated| nearest(of.splats, projecting::outlined(of.shape));
    let three_pass = |settings, footprint| Box::new(splats::SplatsEngine { settings, footprint });
    let approximate = |discs, kind| Box::new(ApproximateEngine { discs, kind });
    let fading = |discs, fading| Box::new(FadingEngine { discs, fading });
    let ensembles = |ensembles| Box::new(spbr::EnsembleEngine { ensembles });
    match *method {
        Method::Points => Box::new(points::PointsEngine),
        Method::Squares(splats) => nearest(splats, Footprint::Square),
        Method::Circles(splats) | Method::Sphere(splats) => nearest(splats, Footprint::Disc),
        Method::Paraboloid(settings) | Method::Cone(settings) => outlined(settings),
        Method::ABuffer(discs) => Box::new(lists::ListEngine { discs, linked: false, shown: Shown::First }),
        Method::LinkedList(discs) => Box::new(lists::ListEngine { discs, linked: true, shown: Shown::First }),
        Method::Sorted(discs) => Box::new(sorted::SortedEngine { discs }),
        Method::Peel(peel) => Box::new(peel::PeelEngine { peel }),
        Method::Stochastic(settings) => Box::new(stochastic::StochasticEngine { settings }),
        Method::Hybrid(Hybrid { discs, k, core_alpha_min, tail, moments }) => {
            let tail = (tail == Tail::Moments).then_some(moments);
            approximate(discs, Kind::Hybrid { k, core_alpha_min, tail })
        }
        Method::Mlab(Mlab { discs, nodes }) => approximate(discs, Kind::Mlab(nodes)),
        Method::Moments(settings) => fading(settings.discs, Fading::Moments(settings)),
        Method::Wavelet(Wavelet { discs, rank }) => fading(discs, Fading::Wavelet(rank)),
        Method::Weighted(discs) => approximate(discs, Kind::Weighted),
        Method::Average(discs) => approximate(discs, Kind::Average),
        Method::Unsorted(discs) => approximate(discs, Kind::Unsorted),
        Method::Hqs(settings) => three_pass(settings, projecting::outlined(settings.shape)),
        Method::Splats(settings) => three_pass(settings, Footprint::Oriented),
        Method::SoftBase(soft) => Box::new(SpheresEngine { soft, interior: Interior::integrated(soft.layout) }),
        Method::SoftConcentric(soft) => {
            Box::new(SpheresEngine { soft, interior: Interior::Shells(soft.shells, soft.pixels_per_shell) })
        }
        Method::SoftExpress(soft) => Box::new(ExpressEngine { soft }),
        Method::OneLayer(settings) => Box::new(one_layer::OneLayerEngine { settings }),
        Method::ImageSpace(filters) => Box::new(image_space::ImageSpaceEngine { filters }),
        Method::PeelLayers(settings) => Box::new(peel_layers::PeelLayersEngine { settings }),
        Method::Spbr(settings) => ensembles(settings.ensembles),
        Method::SpbrSimplified(settings) => ensembles(settings.ensembles),
    }
}

/// Returns all passes that some frame runs, in the order in which plans list those that a frame leaves out.
pub(crate) fn pass_groups() -> Vec<PassGroup> {
    let mut groups = vec![opaque::counter_group(), spbr::pass_group(), tiled::order_group(), tiled::presorted_group()];
    groups.extend(stochastic::pass_groups());
    groups.extend([
        soft::disc_group(),
        tiled::stage_group(),
        soft::sphere_group(),
        abuffer::count_group(),
        abuffer::list_group(),
        abuffer::ellipsoid_group(),
        deep::pass_group(),
        peel::pass_group(),
        splats::pass_group(),
        one_layer::pass_group(),
        PassGroup::new(&CLEAR, Absent::Discs("every pixel is written")),
        opaque::tile_group(),
        PassGroup::new(&SCAN, Absent::Always("nothing is counted")),
        image_space::pass_group(),
        peel_layers::pass_group(),
        opaque::pass_group(),
        points::pass_group(),
    ]);
    groups
}

/// Buffers of all engines, kept from frame to frame.
pub(crate) struct Buffers {
    /// Tiles of large splats, for passes that visit splats one by one.
    pub tiles: Tiles,
    /// All others.
    pub resources: Resources,
}

/// The building blocks of engines. Several engines share the first ones.
pub(crate) struct Resources {
    /// Lists of fragments.
    pub lists: abuffer::ABuffer,
    /// Tiles of ordered splats.
    pub bins: Bins,
    /// Splats in three passes.
    pub splatter: splats::Splatter,
    /// Solid points of a window that has soft ones; soft points of one whose layer they are.
    pub layer: soft::Layer,
    /// The nearest splats and points.
    pub opaque: opaque::Opaque,
    /// Filtered images of points.
    pub filterer: image_space::Filterer,
    /// Sums for each pixel.
    pub approximations: approximate::Approximations,
    /// Fading of the light of each pixel.
    pub fadings: fading::Fadings,
    /// Samples of pixels.
    pub sampler: stochastic::Sampler,
    /// Layers of discs.
    pub peeler: peel::Peeler,
    /// Layers of filtered images.
    pub layer_peeler: peel_layers::LayerPeeler,
    /// Soft discs in a presorted order.
    pub soft_discs: soft::express::SoftDiscs,
    /// `true` if the soft points of the last window were counted.
    pub soft_counted: bool,
    /// Ensembles of points.
    pub ensembles: spbr::Ensembles,
}

impl Buffers {
    /// Allocates only the small buffers.
    ///
    /// # Errors
    /// Out of memory.
    pub fn new(device: &Device) -> Result<Self, Error> {
        let resources = Resources {
            lists: abuffer::ABuffer::new(device)?,
            bins: Bins::new(device)?,
            splatter: splats::Splatter::default(),
            layer: soft::Layer::default(),
            opaque: opaque::Opaque::default(),
            filterer: image_space::Filterer::new(device)?,
            approximations: approximate::Approximations::default(),
            fadings: fading::Fadings::default(),
            sampler: stochastic::Sampler::default(),
            peeler: peel::Peeler::new(device)?,
            layer_peeler: peel_layers::LayerPeeler::new(device)?,
            soft_discs: soft::express::SoftDiscs::default(),
            soft_counted: false,
            ensembles: spbr::Ensembles::default(),
        };
        Ok(Self { tiles: Tiles::new(device)?, resources })
    }
}

/// The outcome of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The window is in the target.
    Done,
    /// A 32-bit sum overflowed, or something whose size depends on the window takes too much memory: it must be cut.
    Overflow,
}
