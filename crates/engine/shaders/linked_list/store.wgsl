// linked-list/store: puts each fragment into a node of its own and hangs the node before its pixel's list (YHGT10). One
// counter hands out the nodes; heads and the counter are cleared before each band. Nodes of one list lie anywhere.
// Relies on abuffer/count visiting the same pixels.
#import raster
@group(0) @binding(8) var<storage, read_write> heads: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> node_count: array<atomic<u32>>;
// A node: depth key and index of the splat, and the node behind it.
@group(0) @binding(10) var<storage, read_write> nodes: array<vec2<u32>>;
@group(0) @binding(11) var<storage, read_write> links: array<u32>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let p = window_index(pixel, view.window);
    if p < push.band_start || p >= push.band_end {
        return;
    }
    let coverage = cover(splat, tilt, pixel);
    if !coverage.hit {
        return;
    }
    let node = atomicAdd(&node_count[0], 1u);
    // There are as many nodes as were counted; should a driver ever disagree with itself, nothing is written outside.
    if node < min(arrayLength(&nodes), arrayLength(&links)) {
        nodes[node] = vec2<u32>(depth_key(coverage.depth), push.first + i);
        links[node] = atomicExchange(&heads[p], node);
    }
}
#walker
