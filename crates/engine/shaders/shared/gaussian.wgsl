// A Gaussian in a pixel. With d from the projected center to the pixel's center, in pixels, and a lower triangular L,
// |L d| = 1 is where the Gaussian ends: where its opacity falls to the least one of a fragment. The rest serves
// kernels and orders that follow the pixel's ray.
//
// Let the columns of M be the Gaussian's axes in camera axes (x right, y down, z forward), each as long as its standard
// deviation, c its center, and X, Y its slopes x/z, y/z. With the rows a = M1 - X M3, b = M2 - Y M3, e1 = a / |a|, e2
// the unit vector of b's part across e1, e3 = e1 x e2, and v = K d, K the lower triangular factor for which |K d|^2 is
// d's square in the metric of a a, a b, b b, the ray passes the center in
//     rho^2 = |v|^2 / (w^2 + t^2 |v|^2),   at the depth   z w / (w^2 + t^2 |v|^2),
//     w = 1 - v . (M3.e1, M3.e2) / z,      t = M3.e3 / z
// standard deviations: the distance of a line from the origin in Plücker coordinates (HTGS, Hahlbohm et al. 2025), with
// the frame turned so that nothing is inverted: flat Gaussians need no case of their own. Of parallel rays rho^2 =
// |v|^2, and the depth is z + v . (M3.e1, M3.e2).
//
// Where they stand: splat.radius -L11. Of SHAPE_GAUSSIAN_FLAT: tilt.normal L00, L10, z of the center.
// Of SHAPE_GAUSSIAN by KERNEL_EWA: tilt.normal L00, L10, K00, K10, rest K11, M3.e1 / z, M3.e2 / z, t.
// By KERNEL_RAY, of which L is K: normal L00, L10, the inverse of rho^2 at the end, z; rest unused, and as before.
// By KERNEL_ELLIPSOID as by KERNEL_RAY, but in place of the unused number one of BODY_.
fn cover_gaussian(splat: Splat, tilt: Tilt, d: vec2<f32>) -> Coverage {
    let u = vec2<f32>(tilt.normal.x * d.x, tilt.normal.y * d.x - splat.radius * d.y);
    let flat = dot(u, u);
    if SHAPE != SHAPE_GAUSSIAN {
        return Coverage(flat <= 1.0, splat.depth, flat);
    }
    let by_ray = view.kernel == KERNEL_RAY;
    let k = vec2<f32>(tilt.normal.z * d.x, tilt.normal.w * d.x + tilt.rest.x * d.y);
    let v = select(k, u, by_ray);
    let squared = dot(v, v);
    let along = v.x * tilt.rest.y + v.y * tilt.rest.z;
    let z = select(splat.depth, tilt.normal.w, by_ray);
    var at = z + along;
    var rho = squared;
    if view.orthographic == 0u {
        let w = 1.0 - along;
        let below = w * w + (tilt.rest.w * tilt.rest.w) * squared;
        at = z * w / below;
        rho = squared / below;
    }
    let within = at >= view.depth_range.x && at <= view.depth_range.y;
    let ends = select(flat, rho * tilt.normal.z, by_ray);
    return Coverage(ends <= 1.0 && (within || !by_ray), select(splat.depth, at, view.order == ORDER_PIXEL), ends);
}

// Opacity of a Gaussian's fragment: o exp(-rho^2 / 2), where it falls to `least` at the end.
fn gaussian_opacity(opacity: f32, ends: f32) -> f32 {
    return min(view.gaussian.y, opacity * exponential(-ends * logarithm(opacity / view.gaussian.x)));
}

// The depth that a splat's fragment shows, given that by which it is ordered.
fn shown_depth(splat: Splat, tilt: Tilt, depth: f32) -> f32 {
    if !is_gaussian(splat) || view.order != ORDER_DISTANCE {
        return depth;
    }
    return select(tilt.normal.z, tilt.normal.w, SHAPE == SHAPE_GAUSSIAN);
}
