// stochastic/visibility: the nearest fragment that covers each sample of a run's strata (Enderton et al. 2011, the pass
// that fills the multi-sampled depth buffer). One subgroup per tile; splats come in canonical order, so that of equally
// deep fragments the first one stays.
// Reference: reference::stochastic::stratum, the places that samples hold.
#import splat
#import stochastic
#import region_fold
@group(0) @binding(20) var<storage, read_write> held_keys: array<vec4<u32>>;
@group(0) @binding(21) var<storage, read_write> held_indices: array<vec4<u32>>;
// Of the points, from which random words follow.
@group(0) @binding(22) var<storage, read> ids: array<u32>;

var<private> held: SampleRanks;

fn hold(s: u32, mask: u32, fragment: Fragment) {
    let covered = (vec4<u32>(mask) & vec4<u32>(1u, 2u, 4u, 8u)) != vec4<u32>(0u);
    let nearer = covered & (vec4<u32>(fragment.depth_key) < held.keys[s]);
    held.keys[s] = select(held.keys[s], vec4<u32>(fragment.depth_key), nearer);
    held.indices[s] = select(held.indices[s], vec4<u32>(fragment.index), nearer);
}

fn load(pixel: vec2<u32>) {
#each stratum     held.keys[{stratum}u] = vec4<u32>(NOTHING);
#each stratum     held.indices[{stratum}u] = vec4<u32>(NOTHING);
    if is_later() && all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
#each stratum         held.keys[{stratum}u] = held_keys[{stratum}u * push.pixels + p];
#each stratum         held.indices[{stratum}u] = held_indices[{stratum}u * push.pixels + p];
    }
}

fn store(pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
#each stratum         held_keys[{stratum}u * push.pixels + p] = held.keys[{stratum}u];
#each stratum         held_indices[{stratum}u * push.pixels + p] = held.indices[{stratum}u];
    }
}

fn begin(pixel: vec2<u32>) {
    load(pixel);
}

fn visit(pixel: vec2<u32>, fragment: Fragment) {
    let id = ids[fragment.index];
#each pair     let words{pair} = words_of(pixel, id, vec2<u32>(push.key_low, push.key_high + {pair}u));
#each pair     hold(2u * {pair}u, mask_of(fragment.color.a, words{pair}.x), fragment);
#each pair     hold(2u * {pair}u + 1u, mask_of(fragment.color.a, words{pair}.y), fragment);
}

fn finish(pixel: vec2<u32>) {
    store(pixel);
}
