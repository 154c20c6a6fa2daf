//! Approximations that know how light fades with depth: near singular moments, close depths, thousands of faint layers.

mod known;

use self::known::{Layer, bound, dots, known};
use super::prelude::*;
use pellucid_scene::{MomentCount, Moments, Tail, Wavelet};

/// Depths of the near and far plane of [`super::stage::pixels`].
const RANGE: [f32; 2] = [0.5, 1e7];

pub(super) fn cases() -> Vec<Case> {
    let by_moments = MomentCount::ALL.into_iter().flat_map(with_moments);
    let by_wavelets = (1..=5).map(with_rank);
    by_moments.chain(by_wavelets).chain(other_wavelets()).chain(MomentCount::ALL.map(behind_a_front)).collect()
}

/// The cases of a number of moments. Published code in float32 is right about a few discs with the published bias,
/// which was chosen for it. It is wrong where there are many, and where a bias below the roundings of float32 leaves
/// moments singular.
fn with_moments(moments: MomentCount) -> Vec<Case> {
    let settings = Moments { moments, ..Moments::default() };
    let sharp = Moments { bias: Some(LEAST_BIAS), ..settings };
    let unbiased = Moments { bias: Some(0.0), overestimation: 0.0, ..settings };
    let case = |name: &str, about, settings: Moments, layers: Vec<Layer>| {
        let name = format!("moments/{name}-{}", moments.get());
        one(&name, about, move |stage| against_float64(stage, Method::Moments(settings), &layers))
    };
    let at_one_depth = |name: &str, about, opacity: f32| {
        let name = format!("moments/{name}-{}", moments.get());
        one(&name, about, move |stage| at_one_depth(stage, Method::Moments(settings), opacity))
    };
    let few = format!("moments/few-{}", moments.get());
    vec![
        at_one_depth("one-depth", "10 000 opaque discs at one depth: the mean of their colors", 1.0),
        at_one_depth(
            "faint-one-depth",
            "10 000 discs of opacity 1e-4 at one depth: A times the mean of their colors",
            1e-4,
        ),
        case("faint-spread", "10 000 discs of opacity 1e-4 at 15 depths against float64", settings, faint_spread()),
        case(
            "equal-depths-behind",
            "60 discs at one depth and 30 at another, a bias of 1e-8, against float64",
            sharp,
            many(30, layers(&[7.0, 7.0, 900.0], 0.6)),
        ),
        case(
            "one-ulp",
            "two discs whose depths differ by an ulp and one behind, a bias of 1e-8, against float64",
            sharp,
            layers(&[7.0, 7f32.next_up(), 900.0], 0.4),
        ),
        case(
            "one-millionth",
            "two discs whose depths differ by a millionth and one behind, a bias of 1e-8, against float64",
            sharp,
            layers(&[7.0, 7.0 * (1.0 + 1e-6), 900.0], 0.4),
        ),
        case(
            "near-and-far",
            "a disc at near and one at far, a bias of 1e-8, against float64",
            sharp,
            layers(&RANGE, 0.4),
        ),
        case("opaque-one", "an opaque disc, of optical depth 10, among fainter ones: A is 1", settings, one_opaque()),
        one(
            &few,
            "one disc more than half as many as there are moments, two of them close, without bias: as composed",
            move |stage| few_discs(stage, unbiased),
        ),
    ]
}

fn behind_a_front(moments: MomentCount) -> Case {
    one(
        &format!("hybrid/tail-{}", moments.get()),
        "an exact disc in front of 10 000 of opacity 1e-4 at 15 depths by moments, against float64",
        move |stage| faint_tail(stage, moments),
    )
}

fn with_rank(rank: u32) -> Case {
    let method = Method::Wavelet(Wavelet { rank, ..Wavelet::default() });
    one(
        &format!("wavelet/faint-{rank}"),
        "10 000 discs of opacity 1e-4 at the edges of the cells of a rank: light as it is before each edge",
        move |stage| faint_edges(stage, method, rank),
    )
}

fn other_wavelets() -> Vec<Case> {
    let wavelet = Method::Wavelet(Wavelet::default());
    let finest = Method::Wavelet(Wavelet { rank: 5, ..Wavelet::default() });
    vec![
        one("wavelet/one-depth", "10 000 opaque discs at one depth: the mean of their colors", move |stage| {
            at_one_depth(stage, wavelet, 1.0)
        }),
        one("wavelet/one-ulp", "two discs whose depths differ by an ulp: as composed", move |stage| {
            one_ulp(stage, wavelet)
        }),
        one("wavelet/close", "64 discs within a thousandth of their depth by rank 5 against float64", move |stage| {
            against_float64(stage, finest, &layers(&close_depths(), 0.05))
        }),
    ]
}

/// Discs of some depths and one opacity, each of another color than the one before.
fn layers(depths: &[f32], opacity: f32) -> Vec<Layer> {
    let layer = |(i, depth): (usize, &f32)| Layer { depth: *depth, color: COLORS[i % 5], opacity, count: 1 };
    depths.iter().enumerate().map(layer).collect()
}

/// Returns the layers with `count` discs in each.
fn many(count: u32, layers: Vec<Layer>) -> Vec<Layer> {
    layers.into_iter().map(|layer| Layer { count, ..layer }).collect()
}

/// 15 depths, each three times the one before.
fn faint_spread() -> Vec<Layer> {
    many(667, layers(&std::array::from_fn::<f32, 15, _>(|i| 3f32.powi(i as i32)), 1e-4))
}

fn one_opaque() -> Vec<Layer> {
    let mut layers = layers(&[3.0, 40.0, 500.0, 6000.0], 0.02);
    layers[2].opacity = 1.0;
    layers
}

/// Depths from 900 to 900.9.
fn close_depths() -> [f32; 64] {
    std::array::from_fn(|i| 900.0 + 0.9 * (i as f32 / 63.0))
}

/// A pixel by naive float32.
fn naive_pixel(dots: &[Dot], method: &Method) -> [f32; 4] {
    match method {
        Method::Moments(settings) => naive::moments(dots, RANGE, settings),
        Method::Wavelet(Wavelet { rank, .. }) => naive::wavelet(dots, *rank),
        _ => [f32::NAN; 4],
    }
}

fn found(stage: &mut CaseRenderer, method: Method, dots: &[Dot], wanted: [f64; 4], bound: f64) -> CaseResult {
    stage.compare(dots, method, &naive_pixel(dots, &method), &wanted, bound)
}

/// Light before all of them is the same, so that it does not matter how much it is.
fn at_one_depth(stage: &mut CaseRenderer, method: Method, opacity: f32) -> CaseResult {
    let layers: Vec<Layer> = COLORS.map(|color| Layer { depth: 7.0, color, opacity, count: 2000 }).into();
    let dots = dots(&layers);
    let alpha = composed(&dots)[3];
    let mean = COLORS.iter().map(|color| color.as_dvec3()).sum::<DVec3>() / 5.0;
    found(stage, method, &dots, (alpha * mean).extend(alpha).to_array(), COMPENSATED)
}

fn against_float64(stage: &mut CaseRenderer, method: Method, layers: &[Layer]) -> CaseResult {
    found(stage, method, &dots(layers), known(layers, RANGE, &method), bound(layers, RANGE, &method))
}

/// The least bias of the scale of settings.
const LEAST_BIAS: f32 = 1e-8;

/// Checks half as many discs as moments and one more: their distribution is the only one that has these moments and a
/// point at the depth where light is asked for, so that the light before this depth is exact.
fn few_discs(stage: &mut CaseRenderer, settings: Moments) -> CaseResult {
    let depths = [7.0, 7.07, 900.0, 3e4, 1e6];
    let layers = layers(&depths[..=settings.moments.get() as usize / 2], 0.4);
    let (dots, method) = (dots(&layers), Method::Moments(settings));
    found(stage, method, &dots, composed(&dots), bound(&layers, RANGE, &method))
}

/// Checks discs at the edges of cells, where wavelets know the optical depth before each.
fn faint_edges(stage: &mut CaseRenderer, method: Method, rank: u32) -> CaseResult {
    let edges = 2u32 << rank;
    // To the far edge 2^16.
    let depth = |i: u32| 2f64.powf(16.0 * f64::from(i) / f64::from(edges - 1)) as f32;
    let layers = many(10_000 / edges, layers(&(0..edges).map(depth).collect::<Vec<_>>(), 1e-4));
    // Depths were rounded, so that they lie beside the edges.
    against_float64(stage, method, &layers)
}

/// The nearest lies at the first edge of a cell and the farthest at the last one, where wavelets are exact.
fn one_ulp(stage: &mut CaseRenderer, method: Method) -> CaseResult {
    let layers = layers(&[900.0, 900f32.next_up()], 0.5);
    let dots = dots(&layers);
    // Two products and a sum of two each, a quotient, and an exponential of 3 units.
    found(stage, method, &dots, composed(&dots), 20.0 * HALF_ULP)
}

/// Checks a fragment before a tail: it shows unchanged, and the tail takes the rest of the light.
fn faint_tail(stage: &mut CaseRenderer, moments: MomentCount) -> CaseResult {
    let (front, tail) = (Layer { depth: 0.75, color: COLORS[0], opacity: 0.5, count: 1 }, faint_spread());
    let alone = Method::Moments(Moments { moments, ..Moments::default() });
    let before = |behind: glam::DVec4| 0.5 * front.color.as_dvec3().extend(1.0) + 0.5 * behind;
    let method = Method::Hybrid(Hybrid { k: 1, tail: Tail::Moments, moments, ..Hybrid::default() });
    let wanted = before(known(&tail, RANGE, &alone).into()).to_array();
    let naive = before(glam::Vec4::from(naive_pixel(&dots(&tail), &alone)).as_dvec4());
    // Three roundings more: of a product, a sum, and the rest of the light.
    let bound = 0.5 * bound(&tail, RANGE, &alone) + 3.0 * HALF_ULP;
    stage.compare(&dots(&[&[front], &tail[..]].concat()), method, &naive.as_vec4().to_array(), &wanted, bound)
}
