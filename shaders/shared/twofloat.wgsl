// Numbers as unevaluated sums of two floats, about 48 bits (Dekker 1971; Knuth, TAOCP 2, 4.2.2). They rely on every
// operation being rounded by itself: all arithmetic is decorated NoContraction (src/gpu/spirv.rs).
fn quick_sum(a: f32, b: f32) -> vec2<f32> {
    let s = a + b;
    return vec2<f32>(s, b - (s - a));
}

fn two_sum(a: f32, b: f32) -> vec2<f32> {
    let s = a + b;
    let bb = s - a;
    return vec2<f32>(s, (a - (s - bb)) + (b - bb));
}

fn two_product(a: f32, b: f32) -> vec2<f32> {
    // Halves of 12 bits, by masks: their products are exact, and no intermediate overflows.
    let a_hi = bitcast<f32>(bitcast<u32>(a) & 0xfffff000u);
    let b_hi = bitcast<f32>(bitcast<u32>(b) & 0xfffff000u);
    let a_lo = a - a_hi;
    let b_lo = b - b_hi;
    let p = a * b;
    return vec2<f32>(p, ((a_hi * b_hi - p) + a_hi * b_lo + a_lo * b_hi) + a_lo * b_lo);
}

fn add2(x: vec2<f32>, y: vec2<f32>) -> vec2<f32> {
    let s = two_sum(x.x, y.x);
    let t = two_sum(x.y, y.y);
    let u = quick_sum(s.x, s.y + t.x);
    return quick_sum(u.x, u.y + t.y);
}

fn multiply2(x: vec2<f32>, y: vec2<f32>) -> vec2<f32> {
    let p = two_product(x.x, y.x);
    return quick_sum(p.x, p.y + (x.x * y.y + x.y * y.x));
}

fn divide2(x: vec2<f32>, y: vec2<f32>) -> vec2<f32> {
    let q = x.x / y.x;
    let rest = add2(x, -multiply2(y, vec2<f32>(q, 0.0)));
    return quick_sum(q, rest.x / y.x);
}

fn dot2(a: array<vec2<f32>, 3>, b: array<vec2<f32>, 3>) -> vec2<f32> {
    return add2(add2(multiply2(a[0], b[0]), multiply2(a[1], b[1])), multiply2(a[2], b[2]));
}
