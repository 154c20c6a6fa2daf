//! Bounds of what float32 makes of Gaussians, against float32 itself: the arithmetic that shaders are expected to have,
//! on the host.

use pellucid_reference::gaussians::{Possible, possible};

use super::*;

/// A camera that looks from the side, so that its axes have no round numbers.
fn aslant(projection: Projection) -> Camera {
    Camera::look_at(DVec3::new(0.3, -0.2, 0.1), DVec3::new(1.0, 0.7, -5.0), DVec3::Y, projection, 0.5, 100.0).unwrap()
}

/// Values that shaders know of a splat: axes in camera coordinates, slopes of the center, scale, and place on the
/// screen.
struct Known {
    columns: [[f32; 3]; 3],
    slope: [f32; 2],
    scale: f32,
    z: f32,
    whole: [f64; 2],
    fraction: [f32; 2],
    opacity: f32,
}

impl Known {
    fn new(camera: &Camera, splat: Splatted, least: f32) -> Self {
        let [x, y, z, w] = splat.2.to_array();
        let rotation = [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
            [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
            [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
        ];
        let axes = [camera.right, camera.up, camera.forward].map(|axis| axis.as_vec3().to_array());
        let least = least * splat.1.max_element();
        let column = |k: usize| {
            let r = rotation[k];
            axes.map(|a| (a[0] * r[0] + a[1] * r[1] + a[2] * r[2]) * splat.1[k].max(least))
        };
        let (place, depth) = camera.project(splat.0, SIZE);
        let view = camera.to_view(splat.0);
        let slope = match camera.projection {
            Projection::Perspective { .. } => [(view.x / depth) as f32, (view.y / depth) as f32],
            Projection::Orthographic { .. } => [0.0; 2],
        };
        let scale = camera.pixels_per_unit(depth, SIZE[1]) as f32;
        let whole = place.floor();
        let fraction = (place - whole).as_vec2().to_array();
        Self {
            columns: [0, 1, 2].map(column),
            slope,
            scale,
            z: depth as f32,
            whole: whole.to_array(),
            fraction,
            opacity: splat.3,
        }
    }

    fn offset(&self, x: u32, y: u32) -> [f32; 2] {
        let whole = [f64::from(x) - self.whole[0], f64::from(y) - self.whole[1]];
        [whole[0] as f32 + (0.5 - self.fraction[0]), whole[1] as f32 + (0.5 - self.fraction[1])]
    }

    /// ρ² of the kernel `ewa`: an orthogonal basis of the rows, whose last two columns are the dilation's.
    fn ewa(&self, (dilation, half_field): (f32, f32), [x, y]: [f32; 2]) -> f32 {
        let most = 1.3 * half_field;
        let slope = self.slope.map(|slope| slope.clamp(-most, most));
        let row = |i: usize| self.columns.map(|m| self.scale * (m[i] - slope[i] * m[2]));
        let (a, b) = (row(0), row(1).map(|v| -v));
        let length = (dot(a, a) + dilation).sqrt();
        let first = a.map(|v| v / length);
        let share = dot(first, b);
        let beyond = -share * (dilation.sqrt() / length);
        let rest = [0, 1, 2].map(|i| b[i] - share * first[i]);
        let across = ((dot(rest, rest) + beyond * beyond) + dilation).sqrt();
        let v = [(1.0 / length) * x, (-share / (length * across)) * x + (1.0 / across) * y];
        v[0] * v[0] + v[1] * v[1]
    }

    /// ρ² and depth along the ray, by an orthogonal basis of the rows.
    fn ray(&self, perspective: bool, [x, y]: [f32; 2]) -> (f32, f32) {
        let row = |i: usize, slope: f32| self.columns.map(|m| m[i] - slope * m[2]);
        let (a, b) = (row(0, self.slope[0]), row(1, self.slope[1]));
        let r = self.columns.map(|m| m[2]);
        let length = dot(a, a).sqrt();
        let first = a.map(|v| v / length);
        let share = dot(b, first);
        let rest = [0, 1, 2].map(|i| b[i] - share * first[i]);
        let across = dot(rest, rest).sqrt();
        let second = rest.map(|v| v / across);
        let normal = [
            first[1] * second[2] - first[2] * second[1],
            first[2] * second[0] - first[0] * second[2],
            first[0] * second[1] - first[1] * second[0],
        ];
        // The nearest point Y = (u, v) of the plane: length u = x/scale, share u + across v = −y/scale.
        let u = x * (1.0 / (self.scale * length));
        let v = -y * (1.0 / (self.scale * across)) - x * (share / (self.scale * length * across));
        let (along, out) = (dot(r, first) * u + dot(r, second) * v, dot(r, normal));
        let squares = u * u + v * v;
        if !perspective {
            return (squares, self.z + along);
        }
        let (w, t) = (1.0 - along / self.z, out / self.z);
        let shared = w * w + t * t * squares;
        (squares / shared, self.z * w / shared)
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[track_caller]
fn find(all: &[Possible], x: u32, y: u32) -> Option<Possible> {
    all.iter().find(|p| (p.x, p.y) == (x, y)).copied()
}

/// Asserts that fragments, in float32 or exact, are possible, and that what is sure is there.
fn assert_possible(all: &[Possible], x: u32, y: u32, alpha: f64, key: f64, is_there: bool, what: &str) {
    match find(all, x, y) {
        Some(p) if is_there => {
            assert!(p.alpha.covers(alpha, 0.0), "{what} ({x}, {y}): α {alpha} is not in {:?}", p.alpha);
            assert!(p.key.covers(key, 0.0), "{what} ({x}, {y}): key {key} is not in {:?}", p.key);
        }
        Some(p) => assert!(!p.sure, "{what} ({x}, {y}): sure, but {alpha} at {key}"),
        None => assert!(!is_there, "{what} ({x}, {y}): impossible, but {alpha} at {key}"),
    }
}

fn check(kernel: Kernel, projection: Projection, thinnest: f64) -> (usize, Vec<f64>, Vec<f64>) {
    let camera = aslant(projection);
    let perspective = matches!(projection, Projection::Perspective { .. });
    let settings = GaussianSettings { kernel, ..GaussianSettings::default() };
    let half_field = (4.5 / camera.focal_px(SIZE[1])) as f32;
    let [least, most] = [settings.alpha_min, settings.alpha_max];
    let to_world = |p: DVec3| camera.eye + p.x * camera.right + p.y * camera.up - p.z * camera.forward;
    let (mut open, mut alphas, mut keys) = (0, Vec::new(), Vec::new());
    for (step, splat) in varied(400, thinnest).into_iter().enumerate() {
        let splat = Splatted(to_world(splat.0), splat.1, splat.2, splat.3);
        let what = format!("{kernel:?} {step}");
        let gaussian = one(splat);
        let all = possible(View::new(&camera, SIZE), &gaussian, &settings, Order::Pixel, 0..SIZE[1]);
        let exact = footprint(View::new(&camera, SIZE), &gaussian, &settings, Order::Pixel);
        let own = Known::new(&camera, splat, 0.0);
        let along =
            if kernel == Kernel::Ray { Known::new(&camera, splat, 0.0) } else { Known::new(&camera, splat, 1e-3) };
        for (y, x) in (0..9).flat_map(|y| (0..9).map(move |x| (y, x))) {
            let hit = exact.iter().find(|hit| (hit.x, hit.y) == (x, y));
            let (alpha, key) = hit.map_or((0.0, 0.0), |hit| (hit.alpha, hit.key));
            assert_possible(&all, x, y, alpha, key, hit.is_some(), &what);
            let offset = own.offset(x, y);
            let (by_ray, depth) = along.ray(perspective, offset);
            let rho2 = if kernel == Kernel::Ray { by_ray } else { own.ewa((settings.dilation, half_field), offset) };
            let alpha = (own.opacity * (-0.5 * rho2).exp()).min(most);
            let visible = kernel == Kernel::Ewa || (depth >= camera.near as f32 && depth <= camera.far as f32);
            assert_possible(&all, x, y, alpha.into(), depth.into(), alpha >= least && visible, &what);
        }
        open += all.iter().filter(|p| !p.sure).count();
        alphas.extend(all.iter().map(|p| p.alpha.high - p.alpha.low));
        keys.extend(all.iter().map(|p| (p.key.high - p.key.low) / p.key.high.abs()));
    }
    alphas.sort_by(f64::total_cmp);
    keys.sort_by(f64::total_cmp);
    (open, alphas, keys)
}

#[test]
fn float32_results_are_possible_and_most_are_known_to_four_digits() {
    for projection in [Projection::Perspective { fov_y: 1.4 }, Projection::Orthographic { height: 9.0 }] {
        for kernel in [Kernel::Ewa, Kernel::Ray] {
            let (open, alphas, keys) = check(kernel, projection, 0.1);
            let part = |all: &[f64], share: f64| all[(share * all.len() as f64) as usize];
            println!(
                "{kernel:?} {projection:?}: {} open {open}, α {:.1e} {:.1e} {:.1e}, key {:.1e} {:.1e} {:.1e}",
                alphas.len(),
                part(&alphas, 0.5),
                part(&alphas, 0.99),
                alphas[alphas.len() - 1],
                part(&keys, 0.5),
                part(&keys, 0.99),
                keys[keys.len() - 1],
            );
            assert!(alphas.len() > 1000 && open < alphas.len() / 200);
            assert!(part(&alphas, 0.99) < 1e-3 && part(&keys, 0.9) < 1e-3);
        }
    }
}

#[test]
fn needles_and_flat_splats_are_possible_too() {
    for projection in [Projection::Perspective { fov_y: 1.4 }, Projection::Orthographic { height: 9.0 }] {
        for kernel in [Kernel::Ewa, Kernel::Ray] {
            let (_, alphas, _) = check(kernel, projection, 1e-4);
            println!("{kernel:?} {projection:?}: {}, α {:.1e}", alphas.len(), alphas[alphas.len() / 2]);
        }
    }
}

#[test]
fn coverage_is_open_where_roundings_decide_it() {
    // α beside the middle is e^−½/2.
    let border = 0.5 * (-0.5f64).exp();
    let found = |alpha_min: f64| {
        let settings = GaussianSettings { alpha_min: alpha_min as f32, ..bare(Kernel::Ewa) };
        let splat = one(ball(-5.0 * DVec3::Z, 1.0, 0.5));
        let all = possible(View::new(&orthographic(), SIZE), &splat, &settings, Order::Center, 4..5);
        assert!(all.iter().all(|p| p.y == 4));
        find(&all, 5, 4).map(|p| p.sure)
    };
    assert_eq!([border - 1e-4, border, border + 1e-4].map(found), [Some(true), Some(false), None]);
}

#[test]
fn antialiased_opacity_is_within() {
    let settings = GaussianSettings { antialias: true, ..GaussianSettings::default() };
    let camera = aslant(Projection::Perspective { fov_y: 1.4 });
    let mut widths = Vec::new();
    for splat in varied(300, 0.1) {
        let gaussian = one(splat);
        let all = possible(View::new(&camera, SIZE), &gaussian, &settings, Order::Distance, 0..9);
        for hit in footprint(View::new(&camera, SIZE), &gaussian, &settings, Order::Distance) {
            assert_possible(&all, hit.x, hit.y, hit.alpha, hit.key, true, "exact");
        }
        widths.extend(all.iter().map(|p| p.alpha.high - p.alpha.low));
    }
    widths.sort_by(f64::total_cmp);
    assert!(widths.len() > 500 && widths[widths.len() * 9 / 10] < 1e-3, "{widths:?}");
}
