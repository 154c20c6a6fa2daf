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

use super::discs::exact_coverage;
use crate::check::prelude::*;

pub(super) fn cases() -> Vec<Case> {
    joined([shapes(), ends(), lists(), ellipsoids()])
}

/// Each Gaussian by itself. Errors are shares of what is allowed in the pixel.
fn shapes() -> Vec<Case> {
    let methods = with_peel();
    joined([
        each(&methods, "gaussian-needles", shapes::needles).about("needles of extents 1 : 1e-6, 10 000 pixels long: opacity by the distance from their axis, over what is allowed"),
        each(&methods, "gaussian-needles-by-ray", shapes::by_ray).about("needles of extents 1 : 1e-4 along rays, over what is allowed"),
        each(&methods, "gaussian-plates", shapes::plates).about("plates of extents 1 : 1e-4 seen edge-on, by both kernels, over what is allowed"),
        each(&methods, "gaussian-flat", shapes::flat).about("an extent of 0, by both kernels, over what is allowed"),
        each(&methods, "gaussian-wide", shapes::wide).about("centers far outside the image: J goes no farther than 1.3 times its border"),
        each(&methods, "gaussian-orthographic", shapes::parallel).about("parallel rays, by both kernels, over what is allowed"),
        each(&methods, "gaussian-through-the-eye", shapes::through_the_eye).about("rays in splats that reach behind the eye: cut at near, over what is allowed"),
        each(&methods, "gaussian-units-1e-8", |stage, method| scales::in_units(stage, method, 1e-8)).about("a scene of the size 1e-7, by both kernels, over what is allowed"),
        each(&methods, "gaussian-units-1e6", |stage, method| scales::in_units(stage, method, 1e6)).about("a scene of the size 1e7, by both kernels, over what is allowed"),
        each(&methods, "gaussian-georeferenced", scales::far).about("splats of a centimeter at 5e6, by both kernels, over what is allowed"),
        each(&methods, "gaussian-dilation", scales::dilated).about("dilations of 900 and of 1e25 px², over what is allowed"),
        each(&methods, "gaussian-antialias", scales::subpixel).about("splats of 0.004 to 1 pixels with antialias, over what is allowed"),
    ])
}

/// Returns the cases about the extent of a Gaussian, and its opacity at the end.
fn ends() -> Vec<Case> {
    let methods = with_peel();
    let every = [methods.clone(), approximations()].concat();
    joined([
        each(&methods, "gaussian-least-opacity", ends::least_opacity)
            .about("opacity 2^-16 above and below alpha_min: three pixels of splats of 500, over what is allowed"),
        each(&methods, "gaussian-tails", ends::tails)
            .about("alpha_min of 2e-6: five standard deviations, over what is allowed"),
        each(&methods, "gaussian-most-opacity", ends::most_opacity).about(
            "opacities of 1 - 2^-24 under alpha_max 1 and 0.99: what shines through is not lost, over what is allowed",
        ),
        each(&every, "gaussian-behind", ends::behind)
            .about("centers behind the camera, at its eye, in front of near and behind far: nothing"),
    ])
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
    joined([
        each(&exact(), "gaussian-faint", faint::layers)
            .about("100 000 splats of opacity 1e-5 in a pixel: 1 - (1 - 1e-5)^100000"),
        each(&exact_coverage(), "gaussian-faint-coverage", faint::coverage)
            .about("A of 100 000 splats of opacity 1e-5: 1 - (1 - 1e-5)^100000"),
        each(&every, "gaussian-equal-depths", order::ties)
            .about("splats of equal depth and different colors and shapes, shuffled: no byte changes"),
        each(&hybrid(crossing), "gaussian-crossing", order::crossing)
            .about("splats that cross: their order by pixels changes within the image, over what is allowed"),
        each(&hybrid(methods.clone()), "gaussian-order", order::by_centers)
            .about("nearer by depth, farther by distance: each order against float64, over what is allowed"),
        each(&methods, "gaussian-and-discs", order::mixed)
            .about("discs among splats in one list, over what is allowed"),
        each(&methods, "gaussian-harmonics", colors::harmonics)
            .about("harmonics of degree 4 at 5e6: the direction from the eye, over what is allowed"),
        each(&methods, "gaussian-colors", colors::beyond)
            .about("display values above 1 are kept, those below 0 are 0, over what is allowed"),
    ])
}

/// Ellipsoids of constant density, of the methods that draw some.
fn ellipsoids() -> Vec<Case> {
    let methods = [Method::ABuffer(Discs::default()), Method::LinkedList(Discs::default())];
    joined([
        each(&methods, "ellipsoid-faint", ellipsoids::faint)
            .about("100 000 ellipsoids of opacity 1e-5 that overlap: 1 - (1 - 1e-5)^100000"),
        each(&methods, "ellipsoid-thin", ellipsoids::thin)
            .about("plates of 1e-8 at a depth of 10, whose ends are one depth: each has its opacity"),
        each(&methods, "ellipsoid-dense-within", ellipsoids::dense_within)
            .about("a plate 1e8 times as dense as the ball around it: the density behind it is the ball's"),
        each(&methods, "ellipsoid-around-the-eye", ellipsoids::around_the_eye)
            .about("the eye inside an ellipsoid: the part in front of near is not seen"),
        each(&methods, "ellipsoid-georeferenced", ellipsoids::georeferenced)
            .about("two ellipsoids of a centimeter at 5e6, half inside each other: three segments"),
    ])
}

/// A camera that looks at the origin from a distance, with a field of view of so many degrees.
fn before(distance: f64, degrees: f64) -> Camera {
    perspective(DVec3::Z * distance, DVec3::ZERO, degrees, 0.1 * distance, 10.0 * distance)
}
