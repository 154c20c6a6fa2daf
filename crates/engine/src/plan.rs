//! Decides from the facts of a scene which passes run, each with its reason, and which method `auto` becomes.

pub use crate::methods::Step;

use crate::gpu::Device;
use crate::methods::explain::FramePlan;
use crate::methods::soft::SoftModel;
use crate::methods::{Colors, Facts, Frame, Renderer, brought, engine_of, pass_groups};
use crate::passes::project::{DeviceCloud, Parts};
use crate::points::Points;
use crate::scene::{
    Density, DiscShape, Discs, Falloff, GaussianSettings, Kernel, LongLists, Method, MethodChoice, Order, Raster,
    ScreenSplats, Soft, Spbr,
};

/// Returns the method for these points: `auto` is replaced by one that is exact for them.
///
/// Opaque splats need no transparency: the nearest decides. Flat splats only need an order of splats. Splats that may
/// cross need an order of fragments.
pub fn resolve(choice: MethodChoice, points: &Points) -> (Method, String) {
    resolve_factored(choice, points, 1.0)
}

/// [`resolve`] for points whose opacities are multiplied by a factor.
fn resolve_factored(choice: MethodChoice, points: &Points, factor: f32) -> (Method, String) {
    let discs = match choice {
        MethodChoice::Auto(discs) => discs,
        MethodChoice::Fixed(method) => return (method, format!("the method {} was requested", method.name())),
    };
    let transparent = points.opacities.iter().filter(|a| **a * factor < 1.0).count();
    // Of points that only stand for others.
    let may_be = points.whole.as_ref().is_some_and(|whole| whole.is_transparent);
    // Estimated normals shade and tilt nothing.
    let is_tilted = |i: usize| points.own_normal(i).is_some();
    if has_gaussians(points) {
        return resolve_gaussians(discs);
    }
    // Of no effect, not even where a method refuses them.
    let discs = Discs { gaussians: GaussianSettings::default(), ..discs };
    let oriented = discs.shape == DiscShape::Oriented && (0..points.len()).any(is_tilted);
    if oriented {
        (Method::ABuffer(discs), "oriented discs may cross, so their fragments are sorted in each pixel".to_owned())
    } else if transparent == 0 && !may_be && discs.falloff == Falloff::Flat {
        // Without the clamp of opaque splats, so that the image is the one that `abuffer` would give.
        let splats = ScreenSplats { max_pixel_radius: f32::MAX, ..Default::default() };
        (Method::Circles(splats), "every point is opaque, so each pixel shows its nearest splat".to_owned())
    } else {
        let why = match discs.falloff {
            Falloff::Flat => format!("{transparent} of {} points are transparent", points.len()),
            Falloff::Gaussian => "a Gaussian falloff makes every splat transparent".to_owned(),
        };
        let method = if discs.raster == Raster::Hardware { Method::ABuffer(discs) } else { Method::Sorted(discs) };
        (method, format!("{why}, and all of them face the screen"))
    }
}

/// The method for scenes with Gaussians, which never are opaque throughout.
fn resolve_gaussians(discs: Discs) -> (Method, String) {
    if discs.gaussians.kernel == Kernel::Ellipsoid {
        return (
            Method::ABuffer(discs),
            "rays pass through ellipsoids, so their entries and exits are sorted in each pixel".to_owned(),
        );
    }
    match Method::ABuffer(discs).order() {
        Order::Pixel => {
            (Method::ABuffer(discs), "Gaussians cross, so their fragments are sorted in each pixel".to_owned())
        }
        order => {
            let why = format!("Gaussians are ordered by `{}`, so one order of splats serves all pixels", order.word());
            (if discs.shape == DiscShape::Oriented { Method::ABuffer(discs) } else { Method::Sorted(discs) }, why)
        }
    }
}

/// Returns the method for a frame: like [`resolve`], except that `abuffer` takes the place of `sorted` where `sorted`
/// can't draw the frame. Times decide nothing, so the same scene gets the same method on every device that can draw it.
/// The frame may have any method.
pub fn choose(
    renderer: &Renderer,
    cloud: &DeviceCloud,
    points: &Points,
    choice: MethodChoice,
    frame: &Frame,
) -> (Method, String) {
    match (choice, resolve_factored(choice, points, frame.factors.opacity)) {
        (MethodChoice::Auto(_), (Method::Sorted(discs), why)) => match unsortable(renderer, cloud, frame) {
            Some(reason) => (Method::ABuffer(discs), format!("{why}; {reason}")),
            None => (Method::Sorted(discs), why),
        },
        (_, resolved) => resolved,
    }
}

/// Returns the reason why `sorted` can't draw a frame.
fn unsortable(renderer: &Renderer, cloud: &DeviceCloud, frame: &Frame) -> Option<String> {
    if frame.shading.edl.edl {
        return Some("eye-dome lighting needs lists of fragments, which abuffer makes".to_owned());
    }
    if renderer.device().info().subgroup.is_none() {
        return Some("the device has no subgroup shuffles, which sorted needs".to_owned());
    }
    // Points that are read a part at a time need no more memory than a part.
    let fits = cloud.supply().is_some() || renderer.can_sort(cloud, frame);
    (!fits).then(|| format!("there is not enough memory to sort {} splats", cloud.len()))
}

/// Returns the method that forms the image of another one exactly, except for rounding: `abuffer` for discs, and
/// `soft-base` for soft points, with a softness in place of a factor λ, whose meaning differs between their models.
/// Ensembles are exact for no finite number: of `spbr` it is itself, as if nothing was said of their number and
/// brightness. Gaussians keep their order, which is not every method's by default. `None` for methods whose image no
/// other one draws.
pub fn exact(method: &Method, points: &Points) -> Option<Method> {
    if let Some(soft) = method.soft() {
        let model = SoftModel::new(method, soft, Parts::count(points, soft.threshold).median_radius);
        // Settings differ only in how they form the same image; `pixels_per_shell` is the scene's.
        let Soft { shells, layout, equalize, long_lists, .. } = Soft::default();
        let density = Density::Softness(model.peak);
        return Some(Method::SoftBase(Soft { density, shells, layout, equalize, long_lists, ..*soft }));
    }
    if let Method::Spbr(spbr) = method {
        return Some(Method::Spbr(Spbr { ensembles: Spbr::default().ensembles, brighten: false, ..*spbr }));
    }
    let mut discs = *method.discs()?;
    if has_gaussians(points) && method.order() != Method::ABuffer(discs).order() {
        discs.gaussians.order = Some(method.order());
    }
    Some(Method::ABuffer(Discs { raster: Raster::default(), long_lists: LongLists::default(), ..discs }))
}

/// Returns `true` if two splats may lie one way in one pixel and the other way in another: oriented discs, and
/// Gaussians that are ordered by pixels. A method that orders splats once is not exact for them ([`Method::is_exact`]).
pub fn may_cross(method: &Method, points: &Points) -> bool {
    let Some(discs) = method.discs() else { return false };
    let tilted = discs.shape == DiscShape::Oriented && points.normals.is_some();
    tilted || (has_gaussians(points) && method.order() == Order::Pixel)
}

fn has_gaussians(points: &Points) -> bool {
    let is_there = || points.gaussians.as_ref().is_some_and(|all| (0..all.len()).any(|i| all.is_one(i)));
    points.whole.as_ref().map_or_else(is_there, |whole| whole.splats.is_some())
}

/// Returns the passes of a frame whose facts were surveyed (see [`Renderer::survey`]), in the order of their first run.
/// `why` is the reason for the method, from [`choose`].
pub fn plan(device: &Device, frame: &Frame, facts: &Facts, wide_atomics: bool, why: &str) -> Vec<Step> {
    let mut plan = FramePlan { device, frame, facts, wide_atomics, why, steps: Vec::new() };
    plan.shadows();
    engine_of(&frame.method).explain(&mut plan);
    for group in pass_groups() {
        plan.rest_of(&group);
    }
    let [width, height] = frame.size;
    let outputs = brought(frame);
    if outputs.colors == Colors::Bytes {
        plan.add("image/encode", true, "8-bit colors over the background, those of a PNG".to_owned());
    }
    let (bytes, windows) = (outputs.pixel_bytes(), facts.windows);
    let copied = format!("{width} × {height} pixels of {bytes} bytes, copied to the host from {windows} window(s)");
    plan.add("image/read-back", true, copied);
    plan.eye_dome();
    plan.steps
}
