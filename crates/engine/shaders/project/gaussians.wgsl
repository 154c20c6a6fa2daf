// project/gaussians: Gaussian splats to their ellipses on the screen, colored for the view, with the rectangle of
// pixels that each covers. One workgroup per WG_SIZE * RUN points of a chunk. Points that are no Gaussians are left to
// project/splats. Reference: reference::gaussians.
#import body
#import splat
#import locate
#import projected
#import harmonics
#import decode
#import encode
#import optical_depth
#import dispatch

@group(0) @binding(1) var<storage, read> points_hi: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> points_lo: array<vec4<f32>>;
// Standard deviations, all 0 for a point that is none; w is 1 if its colors are linear, 0 if they are display values.
@group(0) @binding(3) var<storage, read> extents: array<vec4<f32>>;
// Unit quaternions, x y z w.
@group(0) @binding(4) var<storage, read> rotations: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> harmonics: array<f32>;

// 1: blending runs on display values.
override ENCODED: u32 = 0u;
// 1: project/splats writes the rectangles of points that are no Gaussians.
override MIXED: u32 = 0u;

// The axes of a Gaussian in camera axes, each as long as its standard deviation.
fn axes_of(extent: vec3<f32>, q: vec4<f32>) -> mat3x3<f32> {
    let two = q.xyz + q.xyz;
    let xx = q.x * two.x;
    let yy = q.y * two.y;
    let zz = q.z * two.z;
    let xy = q.x * two.y;
    let xz = q.x * two.z;
    let yz = q.y * two.z;
    let wx = q.w * two.x;
    let wy = q.w * two.y;
    let wz = q.w * two.z;
    return mat3x3<f32>(
        extent.x * rounded(turned(vec3<f32>(1.0 - (yy + zz), xy + wz, xz - wy))),
        extent.y * rounded(turned(vec3<f32>(xy - wz, 1.0 - (xx + zz), yz + wx))),
        extent.z * rounded(turned(vec3<f32>(xz + wy, yz - wx, 1.0 - (xx + yy)))),
    );
}

// A component of the three axes, less a slope times their depths.
fn row_of(axes: mat3x3<f32>, component: u32, slope: f32) -> vec3<f32> {
    return vec3<f32>(
        axes[0][component] - slope * axes[0].z,
        axes[1][component] - slope * axes[1].z,
        axes[2][component] - slope * axes[2].z,
    );
}

// Two rows a, b as R times an orthonormal frame: R = ((|a|, 0), (across, rest)), by Gram and Schmidt, which squares
// nothing that cancels. `added` is a variance along both axes of the screen, as of two further columns.
struct Factor {
    a: f32,
    across: f32,
    rest: f32,
    // The frame; without `added` alone.
    first: vec3<f32>,
    second: vec3<f32>,
}

fn factor_of(a: vec3<f32>, b: vec3<f32>, added: f32) -> Factor {
    let along = sqrt(dot3(a, a) + added);
    let first = a / along;
    let root = sqrt(added);
    let last = root / along;
    let across = dot3(first, b);
    let rest = b - across * first;
    let beyond = -across * last;
    let length = sqrt((dot3(rest, rest) + beyond * beyond) + added);
    return Factor(along, across, length, first, rest / length);
}

// L00, L10, L11 of the inverse.
fn inverse_of(f: Factor) -> vec3<f32> {
    return vec3<f32>(1.0 / f.a, -f.across / (f.a * f.rest), 1.0 / f.rest);
}

// Reach along one axis of the screen at depth 1, as (below, above) the center: slopes d with d^2 z^2 = c |a - d m|^2,
// planes through the eye that touch the ellipsoid of Mahalanobis distance sqrt(c).
fn extent_along(a: vec3<f32>, m: vec3<f32>, z: f32, c: f32) -> vec2<f32> {
    let lead = z * z - c * dot3(m, m);
    // The ellipsoid reaches the plane of the eye, or comes so close that roundings show.
    if !(lead > 0.05 * z * z) {
        return vec2<f32>(HUGE);
    }
    let shift = c * dot3(a, m);
    let root = sqrt(max(shift * shift + lead * (c * dot3(a, a)), 0.0));
    return max(vec2<f32>(root + shift, root - shift), vec2<f32>(0.0)) / lead;
}

// Slopes of the center as J takes them: clamped to 1.3 times those of the image's sides (Kerbl et al. 2023,
// forward.cu).
fn clamped_slopes(slope: vec2<f32>) -> vec2<f32> {
    let limit = 1.3 * (0.5 * vec2<f32>(view.size) / view.focal.x);
    return clamp(slope, -limit, limit);
}

// Distance of a center from the eye; along parallel rays its depth.
fn distance_of(position: vec3<f32>) -> f32 {
    return select(length3(position), position.z, view.orthographic != 0u);
}

struct Drawn {
    splat: Splat,
    tilt: Tilt,
    reach: vec4<f32>,
    opacity: f32,
    drawn: bool,
}

// K of the pixel's ray, and M3 in its frame over z, as shared/gaussian.wgsl has it.
struct AlongRay {
    k: vec3<f32>,
    frame: vec3<f32>,
}

fn along_ray(axes: mat3x3<f32>, slope: vec2<f32>, scale: f32, z: f32) -> AlongRay {
    let f = factor_of(row_of(axes, 0u, slope.x), row_of(axes, 1u, slope.y), 0.0);
    let m = vec3<f32>(axes[0].z, axes[1].z, axes[2].z);
    let third = dot3(m, cross3(f.first, f.second));
    let over = select(z, 1.0, view.orthographic != 0u);
    return AlongRay(inverse_of(f) / scale, vec3<f32>(dot3(m, f.first), dot3(m, f.second), third) / over);
}

// By the projection of the Gaussian, linear around its center.
fn draw_ewa(extent: vec3<f32>, q: vec4<f32>, point: Located, position: vec3<f32>, given: f32, base: Splat) -> Drawn {
    var drawn = Drawn(base, no_tilt(), vec4<f32>(0.0), given, true);
    let axes = axes_of(extent, q);
    var slope = vec2<f32>(0.0);
    if view.orthographic == 0u {
        slope = position.xy / position.z;
    }
    let frozen = clamped_slopes(slope);
    let a = point.scale * row_of(axes, 0u, frozen.x);
    let b = point.scale * row_of(axes, 1u, frozen.y);
    let f = factor_of(a, b, view.gaussian.z);
    if view.gaussian.w != 0.0 {
        // The root of det / det', each the square of a product of factors.
        let bare = factor_of(a, b, 0.0);
        let ratio = (bare.a / f.a) * (bare.rest / f.rest);
        drawn.opacity *= max(select(ratio, 0.0, !(ratio >= 0.0)), 0.005);
    }
    let c = 2.0 * logarithm(drawn.opacity / view.gaussian.x);
    let l = inverse_of(f) / sqrt(c);
    drawn.splat.radius = -l.z;
    drawn.tilt.normal = vec4<f32>(l.xy, position.z, 0.0);
    drawn.reach = vec2<f32>(sqrt(c) * f.a, sqrt(c) * sqrt(f.across * f.across + f.rest * f.rest)).xyxy;
    if SHAPE == SHAPE_GAUSSIAN {
        // Radl et al. 2024: flat ones are given a thickness.
        let thick = max(extent, vec3<f32>(1e-3 * max(extent.x, max(extent.y, extent.z))));
        let ray = along_ray(axes_of(thick, q), slope, point.scale, position.z);
        drawn.tilt = Tilt(vec4<f32>(l.xy, ray.k.xy), vec4<f32>(ray.k.z, ray.frame));
    }
    return drawn;
}

// By its largest value along the pixel's ray, up to rho^2 = c.
fn draw_by_ray(extent: vec3<f32>, q: vec4<f32>, point: Located, position: vec3<f32>, c: f32, given: f32, base: Splat) -> Drawn {
    var drawn = Drawn(base, no_tilt(), vec4<f32>(0.0), given, true);
    let axes = axes_of(extent, q);
    var slope = vec2<f32>(0.0);
    if view.orthographic == 0u {
        slope = position.xy / position.z;
    }
    let a = row_of(axes, 0u, slope.x);
    let b = row_of(axes, 1u, slope.y);
    let ray = along_ray(axes, slope, point.scale, position.z);
    drawn.splat.radius = -ray.k.z;
    drawn.tilt = Tilt(vec4<f32>(ray.k.xy, 1.0 / c, position.z), vec4<f32>(0.0, ray.frame));
    if view.orthographic != 0u {
        drawn.reach = (point.scale * sqrt(c) * vec2<f32>(length3(a), length3(b))).xyxy;
    } else {
        let m = vec3<f32>(axes[0].z, axes[1].z, axes[2].z);
        let x = extent_along(a, m, position.z, c);
        let y = extent_along(b, m, position.z, c);
        drawn.reach = view.focal.x * vec4<f32>(x.x, y.x, x.y, y.y);
    }
    return drawn;
}

// As an ellipsoid of constant density, through which a ray along the shortest axis meets the splat's opacity.
fn draw_ellipsoid(extent: vec3<f32>, q: vec4<f32>, point: Located, position: vec3<f32>, given: f32, base: Splat) -> Drawn {
    var drawn = draw_by_ray(extent, q, point, position, 1.0, given, base);
    drawn.splat.depth = add2(point.place[2], vec2<f32>(-view.eye_hi.w, 0.0)).x;
    let opacity = min(given, view.gaussian.y);
    let shortest = min(extent.x, min(extent.y, extent.z));
    let density = depth_of(opacity, 1.0 - opacity) / (2.0 * shortest);
    // Infinite and NaN are no densities either.
    if !(density < MOST_DEPTH) {
        drawn.tilt.rest.x = BODY_FLAT;
    } else if opacity >= 1.0 {
        drawn.tilt.rest.x = BODY_OPAQUE;
    } else {
        drawn.tilt.rest.x = BODY_DENSE;
        drawn.opacity = density;
    }
    return drawn;
}

// Opacity up to which a Gaussian is not drawn: where it is that of the least fragment, or less, nothing is.
fn least_opacity() -> f32 {
    return select(view.gaussian.x, 0.0, view.kernel == KERNEL_ELLIPSOID);
}

// Color from the eye, or along parallel rays.
fn seen_color(i: u32, hi: vec3<f32>, lo: vec3<f32>) -> vec3<f32> {
    var direction = view.forward.xyz;
    if view.orthographic == 0u {
        direction = unit3(rounded(minus_eye(hi, lo)));
    }
    let color = harmonic_color(i, direction);
    let linear = extents[i].w != 0.0;
    if ENCODED != 0u {
        if linear {
            return encode(color);
        }
        return color;
    }
    if linear {
        return color;
    }
    return decode(color);
}

// Projects a point; returns the columns and rows of its rectangle.
fn project(i: u32) -> vec2<u32> {
    let hi = points_hi[i];
    let lo = points_lo[i];
    let extent = extents[i].xyz;
    if all(extent == vec3<f32>(0.0)) {
        if MIXED == 0u {
            bounds[i] = vec2<u32>(0u);
        }
        return vec2<u32>(0u);
    }
    let opacity = min(lo.w * view.opacity_factor, 1.0);
    let point = locate(hi.xyz, lo.xyz);
    let position = rounded(point.place);
    var rect = vec4<u32>(0u);
    if point.drawn && opacity > least_opacity() {
        let pixel = bitcast<u32>(point.column.pixel & 0xffff | point.row.pixel << 16u);
        let depth = select(position.z, distance_of(position), view.order == ORDER_DISTANCE);
        let base = Splat(point.column.fraction, point.row.fraction, pixel, depth, -1.0);
        var drawn: Drawn;
        if view.kernel == KERNEL_RAY {
            let c = 2.0 * logarithm(opacity / view.gaussian.x);
            drawn = draw_by_ray(extent, rotations[i], point, position, c, opacity, base);
        } else if view.kernel == KERNEL_ELLIPSOID {
            drawn = draw_ellipsoid(extent, rotations[i], point, position, opacity, base);
        } else {
            drawn = draw_ewa(extent, rotations[i], point, position, opacity, base);
        }
        // A Gaussian that is edge-on, or so small or large that its factors are no numbers, covers nothing.
        let is_number = drawn.splat.radius < 0.0 && drawn.splat.radius > -3e38 && drawn.opacity > least_opacity();
        if is_number {
            // The exact test follows per pixel.
            let reach = drawn.reach + (0.01 + 1e-4 * drawn.reach);
            rect = rectangle_of(drawn.splat, reach, false);
        }
        if all(rect.xy < rect.zw) {
            put_splat(i, drawn.splat, drawn.tilt);
            colors[i] = vec4<f32>(seen_color(i, hi.xyz, lo.xyz), drawn.opacity);
        }
    }
    bounds[i] = rect.xy | rect.zw << vec2<u32>(16u);
    return rect.zw - rect.xy;
}

#walker
