//! The boxes of `[[clip]]` over the picture: their edges, and a dot on each face, by which it can be dragged.

use egui::{Color32, CursorIcon, Pos2, Rect, Sense, Stroke, Ui, Vec2, vec2};
use glam::{DVec2, DVec3};

use super::controls::{AXES, clip_changes, short_number};
use super::model::Model;
use super::panel;
use pellucid_core::camera::Camera;
use pellucid_scene::{Clip, ClipShape};

/// Radius of a dot, in points.
const DOT: f32 = 5.5;

/// The side of the square that takes the pointer for a dot, in points.
const REACH: f32 = 20.0;

/// Faces that are seen so obliquely that their extent is shorter than this many pixels can't be dragged.
const LEAST_PX: f64 = 12.0;

/// Steps of Newton's method from a place of the pointer to one on a face's normal. Perspective needs more than one.
const STEPS: usize = 6;

/// The nearest depth at which edges are drawn, as a share of the scene's diagonal.
const NEAR: f64 = 1e-3;

/// Colors of what moves along x, y and z.
const COLORS: [Color32; 3] =
    [Color32::from_rgb(240, 95, 85), Color32::from_rgb(110, 205, 90), Color32::from_rgb(95, 150, 255)];

/// Draws the boxes, if they are asked for, and moves their faces.
pub fn show(ui: &mut Ui, model: &mut Model) {
    if !(model.shows.clips && model.shows.panel) {
        return;
    }
    let Some(view) = PictureView::of(ui, model) else { return };
    let clips = model.scene().clips.clone();
    for (at, clip) in clips.iter().enumerate() {
        if let ClipShape::Box { min, max } = clip.shape {
            edges(ui, &view, min, max);
            if let Some(shape) = faces(ui, model, &view, at, [min, max]).filter(|shape| *shape != clip.shape) {
                model.change(&clip_changes(at, &Clip { shape, ..clip.clone() }));
            }
        }
    }
}

/// The picture's camera, and where the picture is in the window.
struct PictureView {
    camera: Camera,
    size: [u32; 2],
    corner: Pos2,
    /// Pixels of a point.
    scale: f32,
    diagonal: f64,
    /// The sides of the points' box.
    extent: DVec3,
}

impl PictureView {
    fn of(ui: &Ui, model: &Model) -> Option<Self> {
        let picture = model.picture()?;
        let bounds = picture.subject.bounds;
        let (diagonal, extent) = (bounds.diagonal(), bounds.max - bounds.min);
        let (corner, scale) = (ui.max_rect().min, ui.ctx().pixels_per_point());
        let (camera, size) = (picture.camera, picture.size);
        (diagonal > 0.0).then_some(Self { camera, size, corner, scale, diagonal, extent })
    }

    fn near(&self) -> f64 {
        NEAR * self.diagonal
    }

    /// A coordinate along an axis, as short as the points' extent there allows.
    fn short(&self, x: f64, axis: usize) -> f64 {
        short_number(x, self.extent[axis])
    }

    /// Returns the position of a pixel of the picture in the window.
    fn at(&self, pixel: DVec2) -> Pos2 {
        self.corner + vec2(pixel.x as f32, pixel.y as f32) / self.scale
    }

    /// The pixel of the picture at a place of the window.
    fn pixel(&self, at: Pos2) -> DVec2 {
        let at = (at - self.corner) * self.scale;
        DVec2::new(at.x.into(), at.y.into())
    }

    /// Projects a point of the world to a pixel of the picture, if it is before the eye.
    fn project(&self, place: DVec3) -> Option<DVec2> {
        let (pixel, depth) = self.camera.project(place, self.size);
        (depth >= self.near()).then_some(pixel)
    }

    /// The part of a line of the world that is before the eye.
    fn line(&self, a: DVec3, b: DVec3) -> Option<[Pos2; 2]> {
        let near = self.near();
        let [from, to] = [a, b].map(|place| self.camera.to_view(place).z);
        if from.max(to) < near {
            return None;
        }
        // A little farther, lest rounding put it behind.
        let crossing = a.lerp(b, (1.001 * near - from) / (to - from));
        let (a, b) = (if from < near { crossing } else { a }, if to < near { crossing } else { b });
        Some([self.at(self.project(a)?), self.at(self.project(b)?)])
    }

    /// Returns the motion of a point's pixel when the point moves along an axis, in pixels per world unit.
    fn motion(&self, place: DVec3, axis: DVec3) -> Option<DVec2> {
        let step = 1e-5 * self.diagonal;
        Some((self.project(place + step * axis)? - self.project(place - step * axis)?) / (2.0 * step))
    }

    /// Returns the shift along an axis after which the point's pixel is as near to a given pixel as possible.
    fn shift(&self, place: DVec3, axis: DVec3, pixel: DVec2) -> f64 {
        let mut shift = 0.0;
        for _ in 0..STEPS {
            let here = place + shift * axis;
            let Some((at, motion)) = self.project(here).zip(self.motion(here, axis)) else { break };
            let step = (pixel - at).dot(motion) / motion.length_squared();
            if !step.is_finite() {
                break;
            }
            // Not through the eye, nor out of sight.
            shift += step.clamp(-0.5 * self.diagonal, 0.5 * self.diagonal);
        }
        shift
    }
}

/// The twelve edges of a box.
fn edges(ui: &Ui, view: &PictureView, min: DVec3, max: DVec3) {
    let corner = |bits: usize| {
        let pick = |axis: usize| if bits >> axis & 1 == 1 { max[axis] } else { min[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    for bits in 0..8usize {
        for axis in (0..3).filter(|axis| bits >> axis & 1 == 0) {
            if let Some(line) = view.line(corner(bits), corner(bits | 1 << axis)) {
                // Seen on any ground.
                ui.painter().line_segment(line, Stroke::new(3.0, Color32::from_black_alpha(190)));
                ui.painter().line_segment(line, Stroke::new(1.3, Color32::from_gray(235)));
            }
        }
    }
}

/// The dots of a box's faces; the box that the pointer makes of it.
fn faces(ui: &mut Ui, model: &mut Model, view: &PictureView, at: usize, ends: [DVec3; 2]) -> Option<ClipShape> {
    let mut moved = None;
    for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
        let center = face_center(ends, axis, side);
        let normal = DVec3::AXES[axis];
        let Some((pixel, motion)) = view.project(center).zip(view.motion(center, normal)) else { continue };
        if motion.length() * view.diagonal < LEAST_PX {
            continue;
        }
        if let Some(to) = dot(ui, model, view, (at, axis, side), pixel) {
            let shift = view.shift(center, normal, to);
            moved = Some(with_face(ends, axis, side, view.short(ends[side][axis] + shift, axis)));
        }
    }
    moved
}

/// The middle of a face: of the lower (0) or the upper (1) one across an axis.
fn face_center(ends: [DVec3; 2], axis: usize, side: usize) -> DVec3 {
    let mut center = 0.5 * (ends[0] + ends[1]);
    center[axis] = ends[side][axis];
    center
}

/// The box with a face elsewhere. It stops at the opposite one.
fn with_face(ends: [DVec3; 2], axis: usize, side: usize, to: f64) -> ClipShape {
    let [mut min, mut max] = ends;
    if side == 0 {
        min[axis] = to.min(max[axis]);
    } else {
        max[axis] = to.max(min[axis]);
    }
    ClipShape::Box { min, max }
}

/// A dot of a face; the pixel to which the pointer drags it.
fn dot(ui: &mut Ui, model: &mut Model, view: &PictureView, face: (usize, usize, usize), pixel: DVec2) -> Option<DVec2> {
    let (at, axis, side) = face;
    let (place, id) = (view.at(pixel), ui.id().with(("face", face)));
    let response = ui.interact(Rect::from_center_size(place, Vec2::splat(REACH)), id, Sense::click_and_drag());
    let name = format!("clip.{at}.{}{}", if side == 0 { '-' } else { '+' }, AXES[axis]);
    let response = panel::note(model, &name, response);
    let active = response.hovered() || response.dragged();
    ui.painter().circle(place, if active { DOT + 2.0 } else { DOT }, COLORS[axis], Stroke::new(1.5, Color32::WHITE));
    if active {
        ui.ctx().set_cursor_icon(if response.dragged() { CursorIcon::Grabbing } else { CursorIcon::Grab });
    }
    let (pressed, now) = ui.input(|input| (input.pointer.press_origin(), input.pointer.latest_pos()));
    if response.drag_started()
        && let Some(pressed) = pressed
    {
        // Held where it was taken, which need not be its middle.
        ui.data_mut(|data| data.insert_temp(id, place - pressed));
    }
    let held: Vec2 = ui.data(|data| data.get_temp(id)).unwrap_or_default();
    let dragged = response.dragged() || response.drag_stopped();
    now.filter(|_| dragged).map(|now| view.pixel(now + held))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_core::camera::Projection;

    fn view(projection: Projection) -> PictureView {
        let camera = Camera::look_at(DVec3::new(30.0, -80.0, 40.0), DVec3::ZERO, DVec3::Z, projection, 1.0, 200.0);
        let (corner, extent) = (Pos2::new(7.0, 3.0), DVec3::new(40.0, 30.0, 0.2));
        PictureView { camera: camera.unwrap(), size: [800, 600], corner, scale: 1.5, diagonal: 50.0, extent }
    }

    const PROJECTIONS: [Projection; 2] =
        [Projection::Perspective { fov_y: 0.7 }, Projection::Orthographic { height: 60.0 }];

    /// The pixel of a face elsewhere leads to where that face is, in perspective, too.
    #[test]
    fn a_face_goes_where_its_dot_is_dragged() {
        let ends = [DVec3::new(-10.0, -8.0, -3.0), DVec3::new(12.0, 9.0, 4.0)];
        for view in PROJECTIONS.map(view) {
            for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
                let center = face_center(ends, axis, side);
                for wanted in [-6.5, 0.0, 1.25, 7.0] {
                    let pixel = view.project(center + wanted * DVec3::AXES[axis]).unwrap();
                    let shift = view.shift(center, DVec3::AXES[axis], pixel);
                    assert!((shift - wanted).abs() < 1e-6, "{axis} {side}: {shift} for {wanted}");
                }
            }
            let back = view.pixel(view.at(DVec2::new(123.0, 456.0)));
            assert!((back - DVec2::new(123.0, 456.0)).length() < 1e-3, "{back}");
        }
    }

    #[test]
    fn a_face_stops_at_the_opposite_one() {
        let ends = [DVec3::ZERO, DVec3::ONE];
        let (min, max) = (DVec3::ZERO, DVec3::new(1.0, 1.0, 3.0));
        assert_eq!(with_face(ends, 2, 1, 3.0), ClipShape::Box { min, max });
        assert_eq!(with_face(ends, 0, 0, 7.0), ClipShape::Box { min: DVec3::X, max: DVec3::ONE });
        assert_eq!(with_face(ends, 0, 1, -7.0), ClipShape::Box { min: DVec3::ZERO, max: DVec3::new(0.0, 1.0, 1.0) });
    }

    #[test]
    fn a_face_is_placed_as_finely_as_its_axis_asks_for() {
        let view = view(PROJECTIONS[0]);
        assert_eq!([0, 1, 2].map(|axis| view.short(1.234_567, axis)), [1.23, 1.23, 1.2346]);
        let flat = PictureView { extent: DVec3::new(40.0, 30.0, 0.0), ..view };
        assert_eq!(flat.short(0.123_456_7, 2), 0.123_456_7);
    }

    #[test]
    fn edges_end_before_the_eye() {
        let view = view(PROJECTIONS[0]);
        let (eye, forward) = (view.camera.eye, view.camera.forward);
        let aside = 2.0 * view.camera.right;
        let place = |depth: f64| eye + depth * forward + aside;
        let whole = view.line(place(10.0), place(20.0)).unwrap();
        assert_eq!(whole.map(|end| end.x > view.at(DVec2::new(400.0, 300.0)).x), [true; 2]);
        let [far, near] = view.line(place(20.0), place(-5.0)).unwrap();
        let expected = view.at(view.project(place(1.001 * view.near())).unwrap());
        assert!(far == whole[1] && (near - expected).length() < 1e-2 * expected.x, "{near} {expected}");
        assert_eq!(view.line(place(-1.0), place(-2.0)), None);
    }
}
