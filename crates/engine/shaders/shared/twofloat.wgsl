// Numbers as unevaluated sums of two floats, about 48 bits (Dekker 1971; Knuth, TAOCP 2, 4.2.2). They rely on every
// operation being rounded by itself: all arithmetic is decorated NoContraction (crates/gpu/src/spirv.rs).
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

// Compensated: the errors of the products and sums are added in one float (Ogita, Rump, Oishi 2005).
fn dot2(a: array<vec2<f32>, 3>, b: array<vec2<f32>, 3>) -> vec2<f32> {
    let p = two_product(a[0].x, b[0].x);
    let q = two_product(a[1].x, b[1].x);
    let r = two_product(a[2].x, b[2].x);
    let s = two_sum(p.x, q.x);
    let t = two_sum(s.x, r.x);
    let crossed = (a[0].x * b[0].y + a[0].y * b[0].x) + (a[1].x * b[1].y + a[1].y * b[1].x) + (a[2].x * b[2].y + a[2].y * b[2].x);
    return quick_sum(t.x, ((p.y + q.y) + r.y) + (s.y + t.y) + crossed);
}
