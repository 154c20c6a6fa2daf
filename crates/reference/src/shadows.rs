//! Shadow textures (Dobrev, Rosenthal, Linsen 2010, Section 6): for each point the share of some lights that reach it.
//!
//! A light is one camera or several (the faces of a cube around it) with square images. The lights come as an argument:
//! how an area is sampled is no part of the equations.

mod holes;
mod ranges;

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

pub use holes::{covered, holes};
pub use ranges::share_ranges;

use super::View;
use super::coverage::footprint;
use super::image_space::{Layer, layer, nearest, splat};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::cloud::Bounds;
use pellucid_core::points::Points;
use pellucid_scene::Light;

/// Widest angle of a light with a single image; a wider one has six.
const WIDEST: f64 = 120.0;
/// Least |n_z|: the offset of a surface seen edge-on is at most ten times that of one seen from the front.
const LEAST_COS: f64 = 0.1;

/// How a light's image is made and compared with points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Map {
    /// Columns and rows.
    pub resolution: u32,
    /// Iterations of the filter of background (Section 3.2), before those of occluded pixels.
    pub fill: u32,
    /// Iterations of the filter of occluded pixels (Section 3.3).
    pub occlusion: u32,
    /// d̃ in world units.
    pub distance: f64,
}

/// The cameras of one light.
pub type Frames = Vec<Camera>;

/// A direction that is not along `axis`.
fn across(axis: DVec3) -> DVec3 {
    let a = axis.abs();
    if a.x <= a.y && a.x <= a.z {
        DVec3::X
    } else if a.y <= a.z {
        DVec3::Y
    } else {
        DVec3::Z
    }
}

/// Returns the frames of a light around some bounds, empty for a headlight: an orthographic square that holds the box
/// along a direction; a perspective one from a position toward the center of the box; the faces of a cube from a
/// position in the box, or so near that the box needs more than 120°. One pixel is left free on each side.
pub fn frames(light: &Light, bounds: &Bounds, resolution: u32) -> Frames {
    let free = f64::from(resolution) / (f64::from(resolution) - 2.0).max(1.0);
    match *light {
        Light::Headlight => Vec::new(),
        Light::Direction(travels) => vec![along(travels.normalize(), bounds, free)],
        Light::Position(position) => toward(position, bounds, free).map_or_else(|| cube(position, bounds), |c| vec![c]),
    }
}

fn along(forward: DVec3, bounds: &Bounds, free: f64) -> Camera {
    let right = forward.cross(across(forward)).normalize();
    let up = right.cross(forward);
    let reach = bounds.diagonal().max(f64::MIN_POSITIVE);
    let flat = |p: DVec3| DVec2::new(p.dot(right), p.dot(up));
    let corners = bounds.corners().map(flat);
    let low = corners.into_iter().fold(DVec2::INFINITY, DVec2::min);
    let high = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max);
    let middle = 0.5 * (low + high);
    let depth = bounds.center().dot(forward) - reach;
    let eye = middle.x * right + middle.y * up + depth * forward;
    let height = (high - low).max_element().max(f64::MIN_POSITIVE) * free;
    let (projection, shift) = (Projection::Orthographic { height }, DVec2::ZERO);
    Camera { eye, right, up, forward, projection, near: 0.0, far: 2.0 * reach, shift }
}

fn toward(position: DVec3, bounds: &Bounds, free: f64) -> Option<Camera> {
    let forward = (bounds.center() - position).try_normalize()?;
    let far = (bounds.center() - position).length() + bounds.diagonal();
    let square = Projection::Perspective { fov_y: FRAC_PI_2 };
    let camera = Camera::look_at(position, bounds.center(), across(forward), square, 0.0, far)?;
    let views = bounds.corners().map(|corner| camera.to_view(corner));
    let is_inside = position.cmpge(bounds.min).all() && position.cmple(bounds.max).all();
    if is_inside || views.iter().any(|view| view.z <= 0.0) {
        return None;
    }
    let slope = views.iter().map(|view| (view.x.abs().max(view.y.abs())) / view.z).fold(0.0, f64::max);
    let fov_y = 2.0 * (slope * free).atan();
    (2.0 * slope.atan() <= WIDEST.to_radians())
        .then_some(Camera { projection: Projection::Perspective { fov_y }, ..camera })
}

fn cube(position: DVec3, bounds: &Bounds) -> Frames {
    let far = (bounds.center() - position).length() + bounds.diagonal();
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let face = |forward: DVec3| {
        let right = forward.cross(across(forward)).normalize();
        let projection = Projection::Perspective { fov_y: FRAC_PI_2 };
        Camera {
            eye: position,
            right,
            up: right.cross(forward),
            forward,
            projection,
            near: 0.0,
            far,
            shift: DVec2::ZERO,
        }
    };
    axes.map(face).to_vec()
}

/// Lights over the disc of an area light, one for each place in the unit disc: `radius` degrees around a direction,
/// world units across the line from a position to the center of the bounds.
pub fn area(light: &Light, radius: f64, bounds: &Bounds, places: &[DVec2]) -> Vec<Light> {
    let moved = |axis: DVec3, reach: f64, place: DVec2| {
        let right = axis.cross(across(axis)).normalize();
        reach * (place.x * right + place.y * right.cross(axis))
    };
    places
        .iter()
        .map(|&place| match *light {
            Light::Headlight => Light::Headlight,
            Light::Direction(travels) => {
                let axis = travels.normalize();
                Light::Direction(axis + moved(axis, radius.to_radians().tan(), place))
            }
            Light::Position(position) => {
                let axis = (bounds.center() - position).normalize_or(DVec3::Z);
                Light::Position(position + moved(axis, radius, place))
            }
        })
        .collect()
}

/// A light's image before the filters: the nearest point of all, whichever way it faces.
fn unfiltered(camera: &Camera, resolution: u32, points: &Points) -> Layer {
    let view = View::new(camera, [resolution; 2]);
    let found = nearest(view, points, false, &vec![f64::NEG_INFINITY; view.pixels()]);
    let colors = vec![DVec3::ZERO; points.len()];
    layer(view.size, &found, &colors, |_| 1.0)
}

/// A light's image after the filters.
fn filtered(nearest: Layer, map: Map) -> Layer {
    let filled = (0..map.fill).fold(nearest, |layer, _| layer.filled());
    (0..map.occlusion).fold(filled, |layer, _| layer.occluded_replaced(map.distance))
}

/// Returns the reference depth of each pixel of a light's image: that of the nearest point after the filters.
pub fn reference_depths(camera: &Camera, map: Map, points: &Points) -> Vec<f64> {
    filtered(unfiltered(camera, map.resolution, points), map).depth
}

/// The distance, in world units, of each point in a camera's image from the border of the lit layer. A point is lit if
/// it is at least 0, that is, if depth ≤ reference + d̃ / max(|n_z|, 0.1), n_z along the camera's axis; + d̃ without a
/// normal. `None` outside of the image.
fn clearances(camera: &Camera, map: Map, points: &Points) -> Vec<Option<f64>> {
    let view = View::new(camera, [map.resolution; 2]);
    let depths = reference_depths(camera, map, points);
    let clearance = |index: usize| {
        let covered = footprint(view, &splat(points, index));
        let pixel = covered.first()?;
        let normal = points.own_normal(index).and_then(|normal| normal.as_dvec3().try_normalize());
        let cos = normal.map_or(1.0, |n| n.dot(camera.forward).abs().max(LEAST_COS));
        let reference = depths[view.index(pixel.x, pixel.y)];
        Some(reference + map.distance / cos - pixel.z)
    };
    (0..points.len()).map(clearance).collect()
}

/// Returns the points that one light reaches. Images of a cube may overlap; a point belongs to the one where it is
/// farthest along the axis. Points in no image are lit.
pub fn lit(light: &[Camera], map: Map, points: &Points) -> Vec<bool> {
    let mut lit = vec![true; points.len()];
    let mut along = vec![f64::NEG_INFINITY; points.len()];
    for camera in light {
        let clearances = clearances(camera, map, points);
        for (index, clearance) in clearances.into_iter().enumerate() {
            let z = camera.to_view(points.positions[index]).z;
            if let Some(clearance) = clearance.filter(|_| z > along[index]) {
                along[index] = z;
                lit[index] = clearance >= 0.0;
            }
        }
    }
    lit
}

/// m of each point: the share of the lights that reach it, 1 without lights.
pub fn shares(lights: &[Frames], map: Map, points: &Points) -> Vec<f64> {
    if lights.is_empty() {
        return vec![1.0; points.len()];
    }
    let mut sums = vec![0.0; points.len()];
    for light in lights {
        let lit = lit(light, map, points);
        sums.iter_mut().zip(lit).for_each(|(sum, lit)| *sum += f64::from(u8::from(lit)));
    }
    sums.into_iter().map(|sum| sum / lights.len() as f64).collect()
}
