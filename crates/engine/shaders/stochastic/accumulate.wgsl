// stochastic/accumulate: what is visible, with color and opacity, summed over the samples of a run's strata (Enderton
// et al. 2011, the additive pass against the multi-sampled depth buffer). One subgroup per tile. The first strata also
// give the exact A = 1 - prod(1 - alpha).
// Layout of `sums`: all pixels over the run's samples; with SPREAD = 1 then the same for each stratum alone.
// Reference: reference::stochastic::stratum.
#import splat
#import stochastic
#import region_fold
@group(0) @binding(20) var<storage, read> held_keys: array<vec4<u32>>;
@group(0) @binding(21) var<storage, read> held_indices: array<vec4<u32>>;
@group(0) @binding(22) var<storage, read_write> sums: array<vec4<f32>>;
@group(0) @binding(23) var<storage, read_write> exact: array<f32>;
@group(0) @binding(24) var<storage, read_write> depths: array<f32>;

// 1: each stratum by itself, too.
override SPREAD: u32 = 0u;
// 1: the exact A.
override EXACT: u32 = 0u;

struct Sums {
    // Sum of c alpha and of alpha over the samples where a fragment is visible, in strata.
    all: vec4<f32>,
    each: array<vec4<f32>, STRATA>,
    exact: f32,
}

var<private> held: SampleRanks;
var<private> sum: Sums;

// Samples of a stratum in which a fragment is visible: nothing nearer is held there.
fn visible_in(s: u32, fragment: Fragment) -> u32 {
    let before = vec4<u32>(fragment.depth_key) < held.keys[s];
    let level = vec4<u32>(fragment.depth_key) == held.keys[s];
    let visible = before | (level & (vec4<u32>(fragment.index) <= held.indices[s]));
    let one = select(vec4<u32>(0u), vec4<u32>(1u), visible);
    return one.x + one.y + one.z + one.w;
}

fn add(fragment: Fragment) {
    let color = vec4<f32>(fragment.color.rgb, 1.0) * fragment.color.a * 0.25;
    var samples = 0u;
#each stratum     let visible{stratum} = visible_in({stratum}u, fragment);
#each stratum     samples += visible{stratum};
#each stratum     if SPREAD != 0u { sum.each[{stratum}u] += color * f32(visible{stratum}); }
    sum.all += color * f32(samples);
    if EXACT != 0u {
        sum.exact += fragment.color.a * (1.0 - sum.exact);
    }
}

// Ranks that a stratum's samples hold; samples that are not taken show nothing.
fn taken(held: vec4<u32>, s: u32, otherwise: u32) -> vec4<u32> {
    let is_taken = vec4<u32>(4u * s, 4u * s + 1u, 4u * s + 2u, 4u * s + 3u) < vec4<u32>(push.left);
    return select(vec4<u32>(otherwise), held, is_taken);
}

fn load(pixel: vec2<u32>) {
    let p = window_index(min(pixel, view.window.zw - 1u), view.window);
#each stratum     held.keys[{stratum}u] = taken(held_keys[{stratum}u * push.pixels + p], {stratum}u, 0u);
#each stratum     held.indices[{stratum}u] = taken(held_indices[{stratum}u * push.pixels + p], {stratum}u, 0u);
    sum.all = vec4<f32>(0.0);
    sum.exact = 0.0;
#each stratum     sum.each[{stratum}u] = vec4<f32>(0.0);
    if is_later() {
        sum.all = sums[p];
        if EXACT != 0u { sum.exact = exact[p]; }
#each stratum         if SPREAD != 0u { sum.each[{stratum}u] = sums[({stratum}u + 1u) * push.pixels + p]; }
    }
}

fn store(pixel: vec2<u32>) {
    if any(pixel >= view.window.zw) {
        return;
    }
    let p = window_index(pixel, view.window);
    sums[p] = sum.all;
    if EXACT != 0u { exact[p] = sum.exact; }
#each stratum     if SPREAD != 0u { sums[({stratum}u + 1u) * push.pixels + p] = sum.each[{stratum}u]; }
    if !is_later() {
        depths[p] = min(nearest(), select(depths[p], bitcast<f32>(0x7f800000u), push.before == 0u));
    }
}

// The nearest depth that a sample holds; those that are not taken hold 0.
fn nearest() -> f32 {
    var least = vec4<u32>(NOTHING);
#each stratum     least = min(least, held.keys[{stratum}u] - 1u);
    let key = min(min(least.x, least.y), min(least.z, least.w)) + 1u;
    return select(key_depth(key), bitcast<f32>(0x7f800000u), key == NOTHING || key == 0u);
}

fn begin(pixel: vec2<u32>) {
    load(pixel);
}

fn visit(pixel: vec2<u32>, fragment: Fragment) {
    add(fragment);
}

fn finish(pixel: vec2<u32>) {
    store(pixel);
}
