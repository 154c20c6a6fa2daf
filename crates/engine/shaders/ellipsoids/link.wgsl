// ellipsoids/link: hangs the events of each splat before its pixel's list, as linked-list/store does with fragments.
// Relies on ellipsoids/count visiting the same pixels.
#import raster
#import ellipsoid
@group(0) @binding(8) var<storage, read_write> heads: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> node_count: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> nodes: array<vec2<u32>>;
@group(0) @binding(11) var<storage, read_write> links: array<u32>;

fn hang(p: u32, node: u32, event: vec2<u32>) {
    // There are as many nodes as were counted; should a driver ever disagree with itself, nothing is written outside.
    if node < min(arrayLength(&nodes), arrayLength(&links)) {
        nodes[node] = event;
        links[node] = atomicExchange(&heads[p], node);
    }
}

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let p = window_index(pixel, view.window);
    if p < push.band_start || p >= push.band_end {
        return;
    }
    let met = met_by(splat, tilt, pixel);
    if met.events == 0u {
        return;
    }
    let node = atomicAdd(&node_count[0], met.events);
    hang(p, node, vec2<u32>(depth_key(met.entry), event_id(push.first + i, 0u)));
    if met.events == 2u {
        hang(p, node + 1u, vec2<u32>(depth_key(met.exit), event_id(push.first + i, 1u)));
    }
}
#walker
