// Exponentials, logarithms, powers, and what else drivers compute each in its own way: here by additions,
// multiplications, divisions and square roots alone, which give the same bits on every Vulkan driver with IEEE
// arithmetic. Polynomials of Cephes (Moshier 1989: expf, logf). All arithmetic is NoContraction
// (crates/gpu/src/spirv.rs).

// e^x within 1 unit in the last place (all of 10^8 arguments tried); 0 below -87, where it would be subnormal, e^88
// above 88.
fn exponential(x: f32) -> f32 {
    let limited = clamp(x, -87.0, 88.0);
    let n = floor(limited * 1.44269504 + 0.5);
    // ln 2 in two parts; n times the first is exact.
    let r = (limited - n * 0.693359375) + n * 2.1219444e-4;
    var p = 1.987569150e-4 * r + 1.3981999507e-3;
    p = p * r + 8.3334519073e-3;
    p = p * r + 4.1665795894e-2;
    p = p * r + 1.6666665459e-1;
    p = p * r + 5.0000001201e-1;
    let fraction = (p * (r * r) + r) + 1.0;
    return select(fraction * bitcast<f32>(u32(i32(n) + 127) << 23u), 0.0, x < -87.0);
}

// exp(-2 rho^2), the falloff of discs; rho in [0, 1].
fn gaussian(rho: f32) -> f32 {
    return exponential(-2.0 * rho * rho);
}

// ln x within 1 unit in the last place (a 37th of all floats tried, and all around 1); x a normal number above 0.
fn logarithm(x: f32) -> f32 {
    let bits = bitcast<u32>(x);
    let m = bitcast<f32>((bits & 0x007fffffu) | 0x3f000000u);
    // From sqrt(1/2) to sqrt(2), less 1.
    let low = m < 0.70710678;
    let f = select(m, m + m, low) - 1.0;
    let e = f32(i32(bits >> 23u) - select(126, 127, low));
    let z = f * f;
    var p = 7.0376836292e-2 * f - 1.1514610310e-1;
    p = p * f + 1.1676998740e-1;
    p = p * f - 1.2420140846e-1;
    p = p * f + 1.4249322787e-1;
    p = p * f - 1.6668057665e-1;
    p = p * f + 2.0000714765e-1;
    p = p * f - 2.4999993993e-1;
    p = p * f + 3.3333331174e-1;
    let rest = (p * f * z - e * 2.1219444e-4) - 0.5 * z;
    return (f + rest) + e * 0.693359375;
}

// x^y for x >= 0 and y > 0, within 1.5 |y ln x| + 2 units in the last place.
fn power(x: f32, y: f32) -> f32 {
    return select(exponential(y * logarithm(max(x, 1.2e-38))), 0.0, x <= 0.0);
}

// A sum of three has an order.
fn dot3(a: vec3<f32>, b: vec3<f32>) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// `cross` is an extended instruction, which no NoContraction reaches: Mesa 26.2 fuses its products and differences.
fn cross3(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

fn length3(v: vec3<f32>) -> f32 {
    return sqrt(dot3(v, v));
}

fn unit3(v: vec3<f32>) -> vec3<f32> {
    return v / length3(v);
}
