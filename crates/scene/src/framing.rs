//! The camera of a scene: as given, and where nothing is given so that the whole scene fits into the image.

use glam::{DVec2, DVec3};

use super::broadest_side::broadest_side;
use super::error::Error;
use super::framed::{FILL, Framed, Spheres};
use super::nothing_left::no_points;
use super::outermost::Runs;
use super::range::MAX_COORDINATE;
use super::scene::Scene;
use super::sensor;
use super::settings::CameraSettings;
use super::surroundings;
use super::view::Vertical;
use pellucid_core::camera::{Camera, Projection, StatedCamera, reach};
use pellucid_core::cloud::{Bounds, UpAxis};
use pellucid_core::points::Points;

/// Vertical field of view if the scene doesn't say, in degrees.
pub const DEFAULT_FOV_Y: f64 = 45.0;

/// The least distance of an automatic eye to the scene, as a share of the scene's diagonal.
const CLEARANCE: f64 = 0.1;

/// Returns the scene's camera, and warnings about it.
///
/// Without `eye` the camera looks from `scene.camera.view` (by default from the front's right and above, or a quarter
/// farther around where the scene is clearly broader), from the distance at which every framed point (`camera.frame`),
/// as a sphere of its own radius, fits into the image with a margin of 5%. A given view overrides `eye` and `target`,
/// and `up` then only defines the vertical axis; the clouds' vertical (the argument `up`) only counts without it. A
/// scene whose points were all seen by one sensor is looked at from there, and one whose points surround its middle,
/// as those of a room do, from within, unless anything is said of eye, target or view. Default depths: far =
/// 1.001·(z_max + r_max), near = max(0.999·(z_min − r_max), far·10⁻⁵), z over the corners of the bounds: those of the
/// framed points, or, with an `eye`, of all.
///
/// # Errors
/// No points, coordinates too large for a camera, or an `up` that points along the view.
pub fn camera(scene: &Scene, points: &Points, up: UpAxis) -> Result<(Camera, Vec<String>), Error> {
    let (camera, warnings) = stated_camera(scene, points, up)?;
    Ok((camera.camera(), warnings))
}

/// Returns the camera of [`camera`] with the numbers of `[camera]` that give it again, and warnings about it. These
/// numbers keep the vertical of the scene as well.
///
/// # Errors
/// Returns the errors of [`camera`].
pub fn stated_camera(scene: &Scene, points: &Points, up: UpAxis) -> Result<(StatedCamera, Vec<String>), Error> {
    camera_of(scene, &automatic(scene, points, up), points, up)
}

/// Returns the scene's settings of the camera, with what the points ask for where nothing is said.
pub(super) fn automatic(scene: &Scene, points: &Points, up: UpAxis) -> CameraSettings {
    let vertical = scene.camera.vertical(up);
    let Some((framed, bounds)) = Framed::of(scene, points) else { return scene.camera };
    let from_sensor = sensor::seen_from(&scene.camera, &framed, &bounds, scene.image.size);
    let inside = from_sensor.or_else(|| surroundings::inside(&scene.camera, &framed, vertical));
    inside.or_else(|| broadest_side(&scene.camera, &framed, &bounds, vertical)).unwrap_or(scene.camera)
}

/// Returns the camera of these settings in a scene, from outside if they don't say from where.
pub(super) fn camera_of(
    scene: &Scene,
    settings: &CameraSettings,
    points: &Points,
    up: UpAxis,
) -> Result<(StatedCamera, Vec<String>), Error> {
    let subject = subject(scene, points)?;
    let Subject { radius, .. } = subject;
    // A camera that stands where it was told to sees strays, too.
    let bounds = if is_automatic(settings) { subject.bounds } else { subject.all };
    let vertical = settings.vertical(up);
    let settings = &with_height(settings, &subject, scene.image.size, vertical);
    let pose = Pose::new(settings, &subject, projection(settings), scene.image.size, vertical);
    let Some(camera) = placed(settings, &pose, &bounds, radius) else {
        let forward = (pose.target - pose.eye).normalize_or_zero();
        let problem = format!("{} is parallel to the view {forward}; remove it or choose another direction", pose.up);
        return Err(Error::Conflict { place: super::Place::Option("camera.up".into()), problem });
    };
    let (near, far) = (camera.near, camera.far);
    if !is_usable(&camera) || is_beyond(&bounds) {
        return Err(Error::Extent { min: bounds.min, max: bounds.max });
    }
    let mut warnings = Vec::new();
    if settings.view.is_given() && (settings.eye.is_some() || settings.target.is_some()) {
        warnings.push("the requested view replaces `eye` and `target` of [camera]".to_owned());
    }
    if !sees_anything(&camera, points, scene.image.size) {
        warnings.push(format!(
            "the camera sees nothing: none of the {} points lies in the image between near {near} and far {far}; remove \
             [camera] to show the whole scene",
            points.len()
        ));
    }
    Ok((camera, warnings))
}

/// Returns the camera of settings that give its eye, target and up, and no view: the one that [`camera`] finds in a
/// scene of these `bounds` and this largest `radius`, without a look at its points. `None` if something of it is
/// missing, if points decide its height, if `up` points along the view, or if coordinates are too large.
pub fn camera_at(settings: &CameraSettings, bounds: &Bounds, radius: f64) -> Option<Camera> {
    stated_camera_at(settings, bounds, radius).map(|camera| camera.camera())
}

/// Returns the camera of [`camera_at`] with the numbers of `[camera]` that give it again.
pub fn stated_camera_at(settings: &CameraSettings, bounds: &Bounds, radius: f64) -> Option<StatedCamera> {
    if settings.ortho && settings.height.is_none() {
        return None;
    }
    let (eye, target, up) = (settings.eye?, settings.target?, settings.up?);
    placed(settings, &Pose { eye, target, up }, bounds, radius).filter(|camera| is_usable(camera))
}

/// Returns `true` if coordinates and depths are such that a picture can be made.
pub(super) fn is_usable(&Camera { eye, near, far, .. }: &Camera) -> bool {
    eye.is_finite() && far.is_finite() && near > 0.0 && near < far
}

/// Returns `true` if settings leave it to the points where the camera stands.
fn is_automatic(settings: &CameraSettings) -> bool {
    settings.eye.is_none() || settings.view.is_given()
}

/// Returns `true` for a box that is too far away for a camera.
fn is_beyond(Bounds { min, max }: &Bounds) -> bool {
    min.abs().max(max.abs()).max_element() > MAX_COORDINATE
}

/// Returns the part of a scene to frame.
pub(super) fn subject<'a>(scene: &Scene, points: &'a Points) -> Result<Subject<'a>, Error> {
    let (Some((framed, bounds)), Some(all)) = (Framed::of(scene, points), points.bounds()) else {
        return Err(no_points(scene, points, &[]));
    };
    if is_beyond(&bounds) {
        return Err(Error::Extent { min: bounds.min, max: bounds.max });
    }
    Ok(Subject { framed, bounds, all, radius: points.largest_radius() })
}

/// Returns the scene's lens.
pub(super) fn projection(settings: &CameraSettings) -> Projection {
    match settings.height {
        Some(height) => Projection::Orthographic { height },
        None => Projection::Perspective { fov_y: settings.fov_y.unwrap_or(DEFAULT_FOV_Y).to_radians() },
    }
}

/// The camera of a pose; `None` if its `up` points along the view.
fn placed(settings: &CameraSettings, pose: &Pose, bounds: &Bounds, radius: f64) -> Option<StatedCamera> {
    let camera = StatedCamera::look_at(pose.eye, pose.target, pose.up, projection(settings), 1.0, 2.0)?;
    // Along the camera's own direction, whose last bit may be another one: a key frame knows no other.
    let (near, far) = depths([settings.near, settings.far], pose.eye, camera.forward, bounds, radius);
    Some(camera.with_depths(near, far))
}

/// Returns settings in which `ortho` has become the `height` that shows the whole subject from the direction of view.
pub(super) fn with_height(
    settings: &CameraSettings,
    subject: &Subject<'_>,
    size: [u32; 2],
    vertical: Vertical,
) -> CameraSettings {
    if !settings.ortho || settings.height.is_some() {
        return *settings;
    }
    let (forward, image_up, center) = direction(settings, subject, vertical);
    let [right, up] = image_axes(forward, image_up);
    let spheres = Spheres { framed: subject.framed, center, axes: [right, up, forward] };
    let extent = spheres.extent(&Runs::of(&spheres), DVec2::ZERO);
    CameraSettings { height: Some(height_of(&extent, is_centered(settings), size, subject)), ..*settings }
}

/// Returns `true` if a picture isn't shifted, so that both sides are alike.
pub(super) fn is_centered(settings: &CameraSettings) -> bool {
    !settings.view.is_given() && (settings.eye.is_some() || settings.target.is_some())
}

/// Returns world units over the height of an orthographic image that shows an extent with the margin of all automatic
/// cameras.
pub(super) fn height_of(extent: &ViewExtent, centered: bool, [width, height]: [u32; 2], subject: &Subject<'_>) -> f64 {
    let size = if centered { 2.0 * extent.upper.max(-extent.lower) } else { extent.upper - extent.lower };
    let needed = size.y.max(size.x * f64::from(height) / f64::from(width)) / FILL;
    // Seen along a line of points, or of one point, any height works.
    [needed, subject.bounds.diagonal()].into_iter().find(|length| *length > 0.0).unwrap_or(1.0)
}

/// The direction of view, what points to the image's top, and the point in the middle of the picture.
fn direction(settings: &CameraSettings, subject: &Subject<'_>, vertical: Vertical) -> (DVec3, DVec3, DVec3) {
    let center = subject.bounds.center();
    let (forward, image_up) = settings.view.axes(vertical);
    if settings.view.is_given() {
        return (forward, image_up, center);
    }
    let target = settings.target.unwrap_or(center);
    let forward = match settings.eye {
        // An eye in the middle of the scene has no direction to it.
        Some(eye) => (target - eye).try_normalize().unwrap_or(forward),
        None => forward,
    };
    (forward, settings.up.unwrap_or_else(|| upright(forward, vertical)), settings.eye.unwrap_or(target))
}

/// Unit vectors to the image's right and top.
fn image_axes(forward: DVec3, up: DVec3) -> [DVec3; 2] {
    let right = forward.cross(up).normalize_or(DVec3::X);
    [right, right.cross(forward)]
}

/// The points to frame.
pub(super) struct Subject<'a> {
    pub framed: Framed<'a>,
    /// The box of these points.
    pub bounds: Bounds,
    /// The box of all points.
    pub all: Bounds,
    /// The largest one.
    pub radius: f64,
}

/// Eye, target and what points to the image's top, not yet at a right angle to the view.
struct Pose {
    eye: DVec3,
    target: DVec3,
    up: DVec3,
}

impl Pose {
    fn new(
        settings: &CameraSettings,
        subject: &Subject<'_>,
        projection: Projection,
        size: [u32; 2],
        vertical: Vertical,
    ) -> Self {
        let (forward, up, _) = direction(settings, subject, vertical);
        let own = !settings.view.is_given();
        let target = settings.target.filter(|_| own);
        let given = settings.eye.filter(|_| own);
        let eye = given.unwrap_or_else(|| framed(subject, projection, size, forward, up, target));
        let center = subject.bounds.center();
        // A given eye without a target looks at the middle of the scene, if it does not stand there.
        let target = target.or_else(|| given.and_then(|eye| (center - eye).try_normalize()).map(|_| center));
        let target = target.unwrap_or_else(|| eye + forward * reach(eye, (center - eye).dot(forward)));
        let [right, top] = image_axes(forward, up);
        let up = settings.up.filter(|_| own).unwrap_or_else(|| level_up(vertical, [right, top, forward]));
        Self { eye, target, up }
    }
}

/// Returns the `up` that gives these axes of an image to the right, to the top and along the view, and from which the
/// vertical of the scene is found again; the axis to the top if there is none.
pub(super) fn level_up(vertical: Vertical, [right, top, forward]: [DVec3; 3]) -> DVec3 {
    let axis = vertical.up();
    let aside = axis.dot(right);
    let up = if axis.dot(top) <= STRAIGHT {
        // A part along the view turns nothing.
        top + 2.0 * axis.dot(forward).signum() * forward
    } else if aside.abs() <= LEVEL {
        axis
    } else {
        axis - right * aside
    };
    if Vertical::nearest(up) == Some(vertical) { up } else { top }
}

/// Sine of the angle between the view and the vertical below which the image's top would follow rounding rather than
/// the scene: a thousandth of a radian.
const STRAIGHT: f64 = 1e-3;

/// Sine of the angle by which rounding may tilt a level camera.
const LEVEL: f64 = 1e-12;

/// The vertical, or, where that is along the view, the axis that a map has at its top.
fn upright(forward: DVec3, vertical: Vertical) -> DVec3 {
    if forward.cross(vertical.up()).length() < STRAIGHT { -vertical.front() } else { vertical.up() }
}

/// The eye from which the subject fits; the image's center shows `target` if one is given.
fn framed(
    subject: &Subject<'_>,
    projection: Projection,
    size: [u32; 2],
    forward: DVec3,
    up: DVec3,
    target: Option<DVec3>,
) -> DVec3 {
    let center = target.unwrap_or_else(|| subject.bounds.center());
    let [right, up] = image_axes(forward, up);
    let tangents = tangents(projection, size);
    let spheres = Spheres { framed: subject.framed, center, axes: [right, up, forward] };
    let runs = Runs::of(&spheres);
    let extent = spheres.extent(&runs, tangents);
    let clear = clearance(subject, center, extent.nearest);
    let (distance, shift) = match (projection, target) {
        (Projection::Perspective { .. }, Some(_)) => (extent.centered_distance(tangents).max(clear), DVec2::ZERO),
        (Projection::Perspective { .. }, None) => {
            let distance = extent.distance(tangents).max(clear);
            let (first, last) = extent.shifts(tangents, distance);
            // The axis that decided the distance has one shift; rounding may turn its interval around.
            (distance, spheres.middle(&runs, distance, 0.5 * (first + last)).max(first).min(last))
        }
        (Projection::Orthographic { .. }, Some(_)) => (clear, DVec2::ZERO),
        (Projection::Orthographic { .. }, None) => (clear, 0.5 * (extent.upper + extent.lower)),
    };
    center + right * shift.x + up * shift.y - forward * distance
}

/// Returns slopes of the planes between which everything must lie; 0 for an orthographic projection.
pub(super) fn tangents(projection: Projection, size: [u32; 2]) -> DVec2 {
    match projection {
        Projection::Perspective { fov_y } => {
            let vertical = FILL * (0.5 * fov_y).tan();
            DVec2::new(vertical * f64::from(size[0]) / f64::from(size[1]), vertical)
        }
        Projection::Orthographic { .. } => DVec2::ZERO,
    }
}

/// Returns the least distance of an eye to the center; `nearest` is the least depth of any part, counted from there.
///
/// A subject of zero width fits at any distance, but should be well in front of the eye; and a point closer than its
/// rounding error would coincide with the eye.
pub(super) fn clearance(subject: &Subject<'_>, center: DVec3, nearest: f64) -> f64 {
    let fallback = match subject.bounds.diagonal() + subject.radius {
        // For a single point without a size any distance works.
        size if size > 0.0 => size,
        _ => 1.0,
    };
    (CLEARANCE * fallback - nearest).max(1e-6 * center.abs().max_element())
}

impl Spheres<'_> {
    fn extent(&self, runs: &Runs<'_>, tangents: DVec2) -> ViewExtent {
        // 1/cos of the planes' angles.
        let reach = (DVec2::ONE + tangents * tangents).map(f64::sqrt);
        let with = |extent: ViewExtent, (offset, depth, radius): (DVec2, f64, f64)| ViewExtent {
            upper: extent.upper.max(offset - tangents * depth + reach * radius),
            lower: extent.lower.min(offset + tangents * depth - reach * radius),
            nearest: extent.nearest.min(depth - radius),
        };
        let known = runs.outermost(ViewExtent::NOTHING, with, ViewExtent::union, ViewExtent::reaches);
        self.with_groups(known, with, |extent, more| {
            let beyond = (more.upper - extent.upper).max(extent.lower - more.lower).max_element();
            beyond.max(extent.nearest - more.nearest)
        })
    }

    /// The shift of an eye at this distance that puts the outermost discs equally far from the image's center, along
    /// both axes.
    ///
    /// Newton's method: the outermost pair, of slopes (a − shift)/z and (b − shift)/w, is even at shift = (a/z +
    /// b/w)/(1/z + 1/w); then another pair may be the outermost one. It converges in two or three rounds; if two pairs
    /// alternate, the result is slightly off the middle.
    fn middle(&self, runs: &Runs<'_>, distance: f64, mut shift: DVec2) -> DVec2 {
        const ROUNDS: usize = 8;
        for _ in 0..ROUNDS {
            // Slope, and 1/z of the disc that has it: the greatest and the least of each axis.
            let nothing = [(f64::NEG_INFINITY, 0.0); 4];
            let with = |[x, y, left, down]: [(f64, f64); 4], (offset, depth, radius): (DVec2, f64, f64)| {
                let (inverse, offset) = (1.0 / (depth + distance), offset - shift);
                let outer = |offset: f64| ((offset + radius) * inverse, inverse);
                let [x, y] = [later(x, outer(offset.x)), later(y, outer(offset.y))];
                [x, y, later(left, outer(-offset.x)), later(down, outer(-offset.y))]
            };
            let both = |a: [(f64, f64); 4], b: [(f64, f64); 4]| std::array::from_fn(|i| later(a[i], b[i]));
            let slopes = |state: [(f64, f64); 4]| state.map(|(slope, _)| slope);
            let reaches = |state: &[(f64, f64); 4], known: &[(f64, f64); 4]| {
                state.iter().zip(known).any(|(state, known)| state.0 >= known.0)
            };
            let outermost = runs.outermost(nothing, with, both, reaches);
            let outermost = self.with_groups(outermost, with, |known, more| {
                let farther = slopes(more).into_iter().zip(slopes(known)).map(|(more, known)| more - known);
                // Slopes, not lengths.
                farther.fold(0.0, f64::max) * distance
            });
            let (most, least) = outermost.split_at(2);
            let step = |axis: usize| (most[axis].0 - least[axis].0) / (most[axis].1 + least[axis].1);
            let step = DVec2::new(step(0), step(1));
            shift += step;
            // A ten-thousandth of the image.
            if step.abs().max_element() <= 1e-4 * distance {
                break;
            }
        }
        shift
    }
}

/// The pair with the greater first element.
fn later(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b.0 > a.0 { b } else { a }
}

/// The extent of spheres toward the four planes through the eye, whose slopes are `tangents`.
///
/// Along one image axis a sphere lies below the upper plane if offset − shift + r/cos ≤ tangent·(depth + distance),
/// and so above the lower one. With upper = max(offset − tangent·depth + r/cos) and lower = min(offset + tangent·depth
/// − r/cos) all fit with a shift between upper − tangent·distance and lower + tangent·distance; such a shift exists if
/// upper − lower ≤ 2·tangent·distance.
#[derive(Clone, Copy)]
pub(super) struct ViewExtent {
    pub upper: DVec2,
    pub lower: DVec2,
    /// Least depth that any sphere reaches.
    pub nearest: f64,
}

impl ViewExtent {
    /// Extent of no spheres.
    pub const NOTHING: Self = Self { upper: DVec2::NEG_INFINITY, lower: DVec2::INFINITY, nearest: f64::INFINITY };

    /// Returns the extent of the spheres of both.
    pub fn union(self, other: Self) -> Self {
        Self {
            upper: self.upper.max(other.upper),
            lower: self.lower.min(other.lower),
            nearest: self.nearest.min(other.nearest),
        }
    }

    /// Returns `true` if anything of it is as far out as that of another extent.
    fn reaches(&self, other: &Self) -> bool {
        self.upper.cmpge(other.upper).any() || self.lower.cmple(other.lower).any() || self.nearest <= other.nearest
    }

    /// Returns the smallest distance from which all fits with some shift of the eye.
    pub fn distance(&self, tangents: DVec2) -> f64 {
        ((self.upper - self.lower) / (2.0 * tangents)).max_element()
    }

    /// Returns the smallest distance without a shift.
    pub fn centered_distance(&self, tangents: DVec2) -> f64 {
        (self.upper.max(-self.lower) / tangents).max_element()
    }

    /// Returns the least and the greatest shift with which all fits.
    pub fn shifts(&self, tangents: DVec2, distance: f64) -> (DVec2, DVec2) {
        (self.upper - tangents * distance, self.lower + tangents * distance)
    }
}

/// Returns near and far: the given ones, else a range that contains the bounds' corners extended by the largest
/// radius.
pub(super) fn depths(
    [near, far]: [Option<f64>; 2],
    eye: DVec3,
    forward: DVec3,
    bounds: &Bounds,
    radius: f64,
) -> (f64, f64) {
    let z = bounds.corners().map(|corner| (corner - eye).dot(forward));
    let z_min = z.into_iter().fold(f64::INFINITY, f64::min);
    let z_max = z.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let far = far.unwrap_or_else(|| {
        let far = 1.001 * (z_max + radius);
        // Everything lies behind the camera or before `near`: any range works, as the image is empty.
        let far = if far > 0.0 { far } else { 1.0 };
        near.map_or(far, |near| far.max(1.001 * near))
    });
    let near = near.unwrap_or_else(|| {
        let near = (0.999 * (z_min - radius)).max(far * 1e-5);
        if near < far { near } else { far * 1e-5 }
    });
    (near, far)
}

/// Returns `true` if any point's disc reaches into the image between near and far.
fn sees_anything(camera: &Camera, points: &Points, size: [u32; 2]) -> bool {
    let image = DVec2::new(f64::from(size[0]), f64::from(size[1]));
    // Of points that only stand for others those may show.
    points.whole.is_some()
        || points.positions.iter().zip(&points.radii).any(|(position, radius)| {
            let (pixel, z) = camera.project(*position, size);
            let radius_px = f64::from(*radius) * camera.pixels_per_unit(z, size[1]);
            z >= camera.near && z <= camera.far && (pixel - pixel.clamp(DVec2::ZERO, image)).length() <= radius_px
        })
}
