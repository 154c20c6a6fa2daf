// Bounds of the moment problem. Of a distribution of which b_0 = 1 to b_MOMENTS are known, the share before a place z
// and that at z are largest apart for the canonical one: DEGREE + 1 points, z among them. With the monic orthogonal
// polynomials p_k and their squares D_k = E[p_k²], K(x) = Σ p_k(x)² / D_k, the share at a point x is 1 / K(x), and the
// points but z are the roots x of F(x) = Σ p_k(x) p_k(z) / D_k (Szegő, Orthogonal Polynomials, 3.4). All of it in sums
// of two floats but for what only has to be near.
//
// The stage has in `moments` the b_k, and calls orthogonalise() first. What it does for each fragment has no loop: CPU
// drivers end all loops of an invocation after 65 535 iterations, of which those over splats take most.
const DEGREE = MOMENTS / 2u;
const ONE = vec2<f32>(1.0, 0.0);
// Less is rounding.
const LEAST_PIVOT = 1e-12;

var<private> moments: array<vec2<f32>, MOMENTS + 1u>;
// p_{k+1}(x) = (x - middles[k]) p_k(x) - ratios[k] p_{k-1}(x).
var<private> middles: array<vec2<f32>, 4>;
var<private> ratios: array<vec2<f32>, 5>;
// 1 / D_k.
var<private> inverses: array<vec2<f32>, 5>;

// The algorithm of Chebyshev: `now` holds E[p_k x^l].
fn orthogonalise() {
    // Of a place before the first: its factor is 0, and a local array holds anything before it is written.
    var before = moments;
    var now = moments;
    var pivot = ONE;
    middles[0] = moments[1];
    ratios[0] = vec2<f32>(0.0);
    inverses[0] = ONE;
    for (var k = 1u; k <= DEGREE; k++) {
        var next: array<vec2<f32>, MOMENTS + 1u>;
        for (var l = k; l <= MOMENTS - k; l++) {
            let lower = add2(multiply2(middles[k - 1u], now[l]), multiply2(ratios[k - 1u], before[l]));
            next[l] = add2(now[l + 1u], -lower);
        }
        var square = next[k];
        if square.x < LEAST_PIVOT {
            square = vec2<f32>(LEAST_PIVOT, 0.0);
        }
        ratios[k] = divide2(square, pivot);
        inverses[k] = divide2(ONE, square);
        if k < DEGREE {
            middles[k] = add2(divide2(next[k + 1u], square), -divide2(now[k], pivot));
        }
        before = now;
        now = next;
        pivot = square;
    }
}

// The orthogonal polynomials somewhere but for p_0 = 1, or what stands for them.
struct Values {
    p1: vec2<f32>,
    p2: vec2<f32>,
    p3: vec2<f32>,
    p4: vec2<f32>,
}

fn next_value(x: vec2<f32>, k: u32, last: vec2<f32>, before: vec2<f32>) -> vec2<f32> {
    return add2(multiply2(add2(x, -middles[k]), last), -multiply2(ratios[k], before));
}

fn values(x: vec2<f32>) -> Values {
    var v: Values;
    v.p1 = add2(x, -middles[0]);
    v.p2 = next_value(x, 1u, v.p1, ONE);
    if DEGREE > 2u {
        v.p3 = next_value(x, 2u, v.p2, v.p1);
    }
    if DEGREE > 3u {
        v.p4 = next_value(x, 3u, v.p3, v.p2);
    }
    return v;
}

// p_k / D_k.
fn weighted(v: Values) -> Values {
    var w: Values;
    w.p1 = multiply2(v.p1, inverses[1]);
    w.p2 = multiply2(v.p2, inverses[2]);
    if DEGREE > 2u {
        w.p3 = multiply2(v.p3, inverses[3]);
    }
    if DEGREE > 3u {
        w.p4 = multiply2(v.p4, inverses[4]);
    }
    return w;
}

// K: a sum of squares, in which nothing cancels.
fn kernel(v: Values) -> f32 {
    var sum = 1.0 + v.p1.x * v.p1.x * inverses[1].x + v.p2.x * v.p2.x * inverses[2].x;
    if DEGREE > 2u {
        sum += v.p3.x * v.p3.x * inverses[3].x;
    }
    if DEGREE > 3u {
        sum += v.p4.x * v.p4.x * inverses[4].x;
    }
    return sum;
}

// F at the place of v, with the weighted values w of z.
fn crossed(v: Values, w: Values) -> f32 {
    var sum = add2(ONE, add2(multiply2(v.p1, w.p1), multiply2(v.p2, w.p2)));
    if DEGREE > 2u {
        sum = add2(sum, multiply2(v.p3, w.p3));
    }
    if DEGREE > 3u {
        sum = add2(sum, multiply2(v.p4, w.p4));
    }
    return sum.x;
}

// F' at x.
fn slope(x: f32, v: Values, w: Values) -> f32 {
    let d2 = (x - middles[1].x) + v.p1.x;
    var sum = w.p1.x + w.p2.x * d2;
    if DEGREE > 2u {
        let d3 = ((x - middles[2].x) * d2 + v.p2.x) - ratios[2].x;
        sum += w.p3.x * d3;
        if DEGREE > 3u {
            sum += w.p4.x * (((x - middles[3].x) * d3 + v.p3.x) - ratios[3].x * d2);
        }
    }
    return sum;
}

// F(z + t) by powers of t: the constant, which is K(z), in x; the fourth apart.
struct Taylor {
    low: vec4<f32>,
    fourth: f32,
}

fn taylor(z: f32, v: Values, w: Values) -> Taylor {
    let m1 = z - middles[1].x;
    // Of p_k(z + t) without its constant: the highest power has the factor 1.
    let second = v.p1.x + m1;
    var low = vec4<f32>(kernel(v), w.p1.x + w.p2.x * second, w.p2.x, 0.0);
    var fourth = 0.0;
    if DEGREE > 2u {
        let m2 = z - middles[2].x;
        let third = vec2<f32>((v.p2.x + m2 * second) - ratios[2].x, second + m2);
        low += w.p3.x * vec4<f32>(0.0, third, 1.0);
        if DEGREE > 3u {
            let m3 = z - middles[3].x;
            let of_fourth = vec3<f32>((v.p3.x + m3 * third.x) - ratios[3].x * second, (third.x + m3 * third.y) - ratios[3].x, third.y + m3);
            low += w.p4.x * vec4<f32>(0.0, of_fourth);
            fourth = w.p4.x;
        }
    }
    return Taylor(low, fourth);
}

// One step of Laguerre toward a root of h0 u^n + h1 u^(n-1) + …, h0 = 1, all of whose roots are real: from outside it
// never passes the nearest, and has cubic speed. Of degree 3 h4 is not read.
fn laguerre(h: vec4<f32>, degree: u32, u: f32) -> f32 {
    var p = u + h.x;
    var d = 1.0;
    var half = 0.0;
    half = half * u + d; d = d * u + p; p = p * u + h.y;
    half = half * u + d; d = d * u + p; p = p * u + h.z;
    if degree == 4u {
        half = half * u + d; d = d * u + p; p = p * u + h.w;
    }
    let n = f32(degree);
    let root = sqrt(max(((n - 1.0) * (n - 1.0)) * (d * d) - (n * (n - 1.0)) * (p * (half + half)), 0.0));
    let below = select(d + root, d - root, d < 0.0);
    return select(u - n * p / below, u, below == 0.0);
}

// The smallest root, from where no root is smaller (Samuelson).
fn smallest(h: vec4<f32>, degree: u32) -> f32 {
    let n = f32(degree);
    let mean = -h.x / n;
    let spread = max((h.x * h.x - 2.0 * h.y) / n - mean * mean, 0.0);
    var u = mean - sqrt((n - 1.0) * spread);
    u = laguerre(h, degree, u);
    u = laguerre(h, degree, u);
    u = laguerre(h, degree, u);
    u = laguerre(h, degree, u);
    u = laguerre(h, degree, u);
    return laguerre(h, degree, u);
}

// One step of Newton in two floats toward the point t from z; at most half of its way.
fn polished(z: f32, w: Values, t: vec2<f32>) -> vec2<f32> {
    let x = add2(t, vec2<f32>(z, 0.0));
    let v = values(x);
    let most = 0.5 * abs(t.x);
    return add2(t, vec2<f32>(clamp(-crossed(v, w) / slope(x.x, v, w), -most, most), 0.0));
}

// The share of the point near t from z; none of one that is far away.
fn share_at(z: f32, w: Values, t: f32) -> f32 {
    if abs(t) > 1e4 {
        return 0.0;
    }
    var exact = polished(z, w, vec2<f32>(t, 0.0));
    exact = polished(z, w, exact);
    exact = polished(z, w, exact);
    return 1.0 / kernel(values(add2(exact, vec2<f32>(z, 0.0))));
}

// Share before z of three points. One lies on either side exactly where F has no t² or a negative one.
fn before_by_three(f: vec3<f32>, p1: f32, others: f32) -> f32 {
    if f.z >= 0.0 {
        return select(0.0, others, f.y > 0.0);
    }
    // The mean of the points is that of the distribution.
    let root = sqrt(f.y * f.y - 4.0 * f.x * f.z);
    return clamp(0.5 * others + (0.5 * others * f.y - p1 * f.z) / root, 0.0, others);
}

// The sign of the last of a sequence that is not 0, and how often it changed.
struct Signs {
    last: f32,
    changes: u32,
}

fn followed(signs: Signs, next: f32) -> Signs {
    let changes = next * signs.last < 0.0;
    return Signs(select(signs.last, -signs.last, changes), signs.changes + select(0u, 1u, changes));
}

// How many of the points lie before z: the roots of F(z + t) are real, so that the signs of F(z - t) tell (Descartes).
fn points_before(f: Taylor) -> u32 {
    let third = followed(followed(followed(Signs(1.0, 0u), -f.low.y), f.low.z), -f.low.w);
    return followed(third, f.fourth).changes;
}

// The root of degree 4 after the smallest one, of roots below 0.
fn next_smallest(h: vec4<f32>, u: f32) -> f32 {
    // The rest of the polynomial, divided from its constant on: so the smaller roots keep their digits.
    let constant = -h.w / u;
    let first = (constant - h.z) / u;
    var next = min(smallest(vec4<f32>((first - h.y) / u, first, constant, 0.0), 3u), -1e-6);
    next = min(laguerre(h, 4u, next), -1e-6);
    next = min(laguerre(h, 4u, next), -1e-6);
    return min(laguerre(h, 4u, next), -1e-6);
}

// Sum of the shares of `count` points with the smallest t of F(z + t), all of them below 0 where `side` is 1, of F(z -
// t) where it is -1.
fn outer_shares(z: f32, w: Values, f: Taylor, side: f32, count: u32) -> f32 {
    // By 1/t, which has as many values however far points are, over their root mean square.
    let g = vec4<f32>(side * f.low.y, f.low.z, side * f.low.w, f.fourth) / f.low.x;
    let size = sqrt(max(g.x * g.x - 2.0 * g.y, 1e-30));
    var h = g / size;
    h = vec4<f32>(h.x, h.yzw / size);
    h = vec4<f32>(h.xy, h.zw / size);
    h.w = h.w / size;
    let u = smallest(h, DEGREE);
    var sum = share_at(z, w, side / (size * u));
    if DEGREE == 4u && count == 2u {
        sum += share_at(z, w, side / (size * next_smallest(h, u)));
    }
    return sum;
}

// The share before z and that at z.
fn bounds_at(z: f32) -> vec2<f32> {
    let v = values(vec2<f32>(z, 0.0));
    let w = weighted(v);
    let f = taylor(z, v, w);
    let own = 1.0 / f.low.x;
    let others = 1.0 - own;
    if DEGREE == 2u {
        return vec2<f32>(before_by_three(f.low.xyz, v.p1.x, others), own);
    }
    let count = points_before(f);
    let behind = DEGREE - count;
    if count == 0u {
        return vec2<f32>(0.0, own);
    }
    if behind == 0u {
        return vec2<f32>(others, own);
    }
    // From the side on which there are fewer. One call, since it is long.
    let is_from_front = count <= behind;
    let shares = outer_shares(z, w, f, select(-1.0, 1.0, is_from_front), min(count, behind));
    return vec2<f32>(select(max(others - shares, 0.0), min(shares, others), is_from_front), own);
}
