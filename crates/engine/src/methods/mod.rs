//! The methods: the passes that each frame records, and the renderer that runs them over windows and bands of the
//! image.

pub mod abuffer;
pub mod approximate;
pub mod brightness;
mod bytes;
pub mod deep;
pub(crate) mod edl;
pub mod ellipsoids;
pub mod encode;
mod engine;
pub(crate) mod explain;
mod facts;
pub mod fading;
mod frame;
mod frame_profile;
pub mod image_space;
mod linear;
pub mod linked_list;
mod lists;
mod mean;
pub mod one_layer;
pub mod opaque;
mod outputs;
mod own;
mod parts;
pub mod peel;
pub mod peel_layers;
pub mod points;
mod prelude;
mod projected;
mod projecting;
pub mod renderer;
pub mod see_through;
mod several;
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
pub use explain::Step;
pub use facts::{Facts, ThinCloud};
pub use frame::{Factors, Frame};
pub use frame_profile::{FrameProfile, PassProfile};
pub use linear::linear;
pub(crate) use mean::QUARTERS;
pub use mean::{Mean, SAMPLES};
pub use outputs::{Colors, Outputs};
pub use parts::{DrawnPart, SamplePart, SampleSteps};
pub(crate) use renderer::brought;
pub use renderer::{PointSource, Rendered, Renderer, Upload};
pub use target::{Layer, Pixels, PixelsGroup, Target};

pub use crate::frame_error::{Error, PartError};
pub use crate::passes::compose::Stop;
pub use crate::passes::timeline::Timeline;

use crate::gpu::shader::Shader;
use crate::gpu::{Device, DeviceInfo};
use crate::passes::bin::{self, Bins};
use crate::passes::project::{self, Footprint};
use crate::passes::tiles::Tiles;
use crate::passes::{radix, scan};
use crate::scene::{Hybrid, Interpolated, Method, Mlab, Tail, Wavelet};
use abuffer::Shown;
use engine::Engine;
use explain::{Absent, CLEAR, PassGroup, SCAN};
use own::Own;

/// Returns the engine of a method.
pub(crate) fn engine_of(method: &Method) -> Box<dyn Engine> {
    use approximate::{ApproximateEngine, ApproximateKind};
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
            approximate(discs, ApproximateKind::Hybrid { k, core_alpha_min, tail })
        }
        Method::Mlab(Mlab { discs, nodes }) => approximate(discs, ApproximateKind::Mlab(nodes)),
        Method::Moments(settings) => fading(settings.discs, Fading::Moments(settings)),
        Method::Wavelet(Wavelet { discs, rank }) => fading(discs, Fading::Wavelet(rank)),
        Method::Weighted(discs) => approximate(discs, ApproximateKind::Weighted),
        Method::Average(discs) => approximate(discs, ApproximateKind::Average),
        Method::Unsorted(discs) => approximate(discs, ApproximateKind::Unsorted),
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

/// A family of methods, or stages that several families share.
pub(crate) struct Family {
    /// Passes, and why frames without them leave them out.
    groups: &'static [fn() -> PassGroup],
    /// Returns the passes with their variants.
    pub shaders: fn() -> Vec<Shader>,
}

const fn family(groups: &'static [fn() -> PassGroup], shaders: fn() -> Vec<Shader>) -> Family {
    Family { groups, shaders }
}

/// Every family, in the order in which plans list passes that a frame leaves out.
pub(crate) const FAMILIES: &[Family] = &[
    family(&[opaque::counter_group], project::shaders),
    family(&[spbr::pass_group], spbr::shaders),
    family(&[tiled::order_group, tiled::presorted_group], bin::shaders),
    family(&[], radix::shaders),
    family(&[stochastic::pass_group], stochastic::shaders),
    family(&[soft::disc_group], Vec::new),
    family(&[tiled::stage_group], sorted::shaders),
    family(&[], approximate::shaders),
    family(&[], fading::shaders),
    family(&[soft::sphere_group], soft::shaders),
    family(&[abuffer::count_group, abuffer::list_group], abuffer::shaders),
    family(&[], linked_list::shaders),
    family(&[abuffer::ellipsoid_group], ellipsoids::shaders),
    family(&[deep::pass_group], Vec::new),
    family(&[peel::pass_group], peel::shaders),
    family(&[splats::pass_group], splats::shaders),
    family(&[one_layer::pass_group], one_layer::shaders),
    family(&[|| PassGroup::new(&CLEAR, Absent::Discs("every pixel is written"))], Vec::new),
    family(&[|| PassGroup::new(&SCAN, Absent::Always("nothing is counted"))], scan::shaders),
    family(&[image_space::pass_group], image_space::shaders),
    family(&[peel_layers::pass_group], peel_layers::shaders),
    family(&[opaque::pass_group], opaque::shaders),
    family(&[points::pass_group], points::shaders),
    family(&[], edl::shaders),
    family(&[], encode::shaders),
    family(&[], shadows::shaders),
];

/// Returns all passes that some frame runs, in the order in which plans list those that a frame leaves out.
pub(crate) fn pass_groups() -> impl Iterator<Item = PassGroup> {
    FAMILIES.iter().flat_map(|family| family.groups).map(|group| group())
}

/// Buffers of all engines, kept from frame to frame.
pub(crate) struct Buffers {
    /// Tiles of large splats, for passes that visit splats one by one.
    pub tiles: Tiles,
    /// All others.
    pub resources: Resources,
}

/// The building blocks of engines.
pub(crate) struct Resources {
    /// Lists of fragments.
    pub lists: abuffer::ABuffer,
    /// Tiles of ordered splats.
    pub bins: Bins,
    /// Solid points of a window that has soft ones; soft points of one whose layer they are.
    pub layer: Layer,
    /// `true` if the soft points of the last window were counted.
    pub soft_counted: bool,
    /// Buffers that a family has for itself.
    pub own: Own,
}

impl Buffers {
    /// Allocates only the small buffers.
    ///
    /// # Errors
    /// Out of memory.
    pub fn new(device: &Device) -> Result<Self, Error> {
        let (lists, bins) = (abuffer::ABuffer::new(device)?, Bins::new(device)?);
        let resources = Resources { lists, bins, layer: Layer::default(), soft_counted: false, own: Own::default() };
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

/// Returns the names of the methods that a device can't run because it lacks the subgroups that tiles of splats need.
/// The soft methods need them too where there are solid points.
pub fn without_subgroups(device: &DeviceInfo) -> Vec<&'static str> {
    if device.subgroup.is_some() { Vec::new() } else { need_subgroups(device) }
}

/// Returns the names of the methods that go through tiles of splats whatever they draw on this device.
pub fn need_subgroups(device: &DeviceInfo) -> Vec<&'static str> {
    let needs = |method: &Method| engine_of(method).needs_subgroups(device);
    Method::all().iter().filter(|method| needs(method)).map(Method::name).collect()
}
