//! Gaussian splats: shapes at their limits, where they begin and end, their order and their colors.

mod alone;
mod colors;
mod ellipsoids;
mod ends;
mod faint;
mod order;
mod scales;
mod shapes;
pub(super) mod splats;
mod together;

use glam::DVec3;

use super::discs::exact_coverage;
use super::lists::{approximations, exact, with_peel};
use super::verdict::Trouble;
use super::{Case, Finding, each};
use pellucid_engine::camera::{Camera, Projection};
use pellucid_engine::scene::{Discs, Hybrid, Method};

type CaseResult = Result<Finding, Trouble>;

pub(super) fn cases() -> Vec<Case> {
    let mut all = shapes();
    all.extend(ends());
    all.extend(lists());
    all.extend(ellipsoids());
    all
}

/// Each Gaussian by itself. Errors are shares of what is allowed in the pixel.
fn shapes() -> Vec<Case> {
    let methods = with_peel();
    let all = |name: &str, about, run| each(&methods, name, about, run);
    [
        all(
            "gaussian-needles",
            "needles of extents 1 : 1e-6, 10 000 pixels long: opacity by the distance from their axis, over what is allowed",
            shapes::needles,
        ),
        all("gaussian-needles-by-ray", "needles of extents 1 : 1e-4 along rays, over what is allowed", shapes::by_ray),
        all(
            "gaussian-plates",
            "plates of extents 1 : 1e-4 seen edge-on, by both kernels, over what is allowed",
            shapes::plates,
        ),
        all("gaussian-flat", "an extent of 0, by both kernels, over what is allowed", shapes::flat),
        all("gaussian-wide", "centers far outside the image: J goes no farther than 1.3 times its border", shapes::wide),
        all("gaussian-orthographic", "parallel rays, by both kernels, over what is allowed", shapes::parallel),
        all(
            "gaussian-through-the-eye",
            "rays in splats that reach behind the eye: cut at near, over what is allowed",
            shapes::through_the_eye,
        ),
        all("gaussian-units-1e-8", "a scene of the size 1e-7, by both kernels, over what is allowed", scales::tiny),
        all("gaussian-units-1e6", "a scene of the size 1e7, by both kernels, over what is allowed", scales::large),
        all("gaussian-georeferenced", "splats of a centimeter at 5e6, by both kernels, over what is allowed", scales::far),
        all("gaussian-dilation", "dilations of 900 and of 1e25 px², over what is allowed", scales::dilated),
        all("gaussian-antialias", "splats of 0.004 to 1 pixels with antialias, over what is allowed", scales::subpixel),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Returns the cases about the extent of a Gaussian, and its opacity at the end.
fn ends() -> Vec<Case> {
    let methods = with_peel();
    let every = [methods.clone(), approximations()].concat();
    [
        each(
            &methods,
            "gaussian-least-opacity",
            "opacity 2^-16 above and below alpha_min: three pixels of splats of 500, over what is allowed",
            ends::least_opacity,
        ),
        each(
            &methods,
            "gaussian-tails",
            "alpha_min of 2e-6: five standard deviations, over what is allowed",
            ends::tails,
        ),
        each(
            &methods,
            "gaussian-most-opacity",
            "opacities of 1 - 2^-24 under alpha_max 1 and 0.99: what shines through is not lost, over what is allowed",
            ends::most_opacity,
        ),
        each(
            &every,
            "gaussian-behind",
            "centers behind the camera, at its eye, in front of near and behind far: nothing",
            ends::behind,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Several Gaussians in a pixel.
fn lists() -> Vec<Case> {
    let methods = with_peel();
    let every = [methods.clone(), approximations()].concat();
    let crossing: Vec<Method> = methods.iter().copied().filter(|method| method.is_exact(true)).collect();
    let hybrid = |mut methods: Vec<Method>| {
        methods.push(Method::Hybrid(Hybrid::default()));
        methods
    };
    [
        each(
            &exact(),
            "gaussian-faint",
            "100 000 splats of opacity 1e-5 in a pixel: 1 - (1 - 1e-5)^100000",
            faint::layers,
        ),
        each(
            &exact_coverage(),
            "gaussian-faint-coverage",
            "A of 100 000 splats of opacity 1e-5: 1 - (1 - 1e-5)^100000",
            faint::coverage,
        ),
        each(
            &every,
            "gaussian-equal-depths",
            "splats of equal depth and different colors and shapes, shuffled: no byte changes",
            order::ties,
        ),
        each(
            &hybrid(crossing),
            "gaussian-crossing",
            "splats that cross: their order by pixels changes within the image, over what is allowed",
            order::crossing,
        ),
        each(
            &hybrid(methods.clone()),
            "gaussian-order",
            "nearer by depth, farther by distance: each order against float64, over what is allowed",
            order::by_centers,
        ),
        each(&methods, "gaussian-and-discs", "discs among splats in one list, over what is allowed", order::mixed),
        each(
            &methods,
            "gaussian-harmonics",
            "harmonics of degree 4 at 5e6: the direction from the eye, over what is allowed",
            colors::harmonics,
        ),
        each(
            &methods,
            "gaussian-colors",
            "display values above 1 are kept, those below 0 are 0, over what is allowed",
            colors::beyond,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Ellipsoids of constant density, of the methods that draw some.
fn ellipsoids() -> Vec<Case> {
    let methods = [Method::ABuffer(Discs::default()), Method::LinkedList(Discs::default())];
    [
        each(
            &methods,
            "ellipsoid-faint",
            "100 000 ellipsoids of opacity 1e-5 that overlap: 1 - (1 - 1e-5)^100000",
            ellipsoids::faint,
        ),
        each(
            &methods,
            "ellipsoid-thin",
            "plates of 1e-8 at a depth of 10, whose ends are one depth: each has its opacity",
            ellipsoids::thin,
        ),
        each(
            &methods,
            "ellipsoid-dense-within",
            "a plate 1e8 times as dense as the ball around it: the density behind it is the ball's",
            ellipsoids::dense_within,
        ),
        each(
            &methods,
            "ellipsoid-around-the-eye",
            "the eye inside an ellipsoid: the part in front of near is not seen",
            ellipsoids::around_the_eye,
        ),
        each(
            &methods,
            "ellipsoid-georeferenced",
            "two ellipsoids of a centimeter at 5e6, half inside each other: three segments",
            ellipsoids::georeferenced,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// A camera that looks at the origin from a distance, with a field of view of so many degrees.
fn before(distance: f64, degrees: f64) -> Camera {
    let projection = Projection::Perspective { fov_y: degrees.to_radians() };
    super::stage::looking(DVec3::Z * distance, DVec3::ZERO, projection, 0.1 * distance, 10.0 * distance)
}
