// linked-list/gather: writes each pixel's list into its range of the fragment buffer, where abuffer/store would have
// put it. One invocation per pixel of the band follows at most STEP links; the head then is where the next run goes on.
// Reference: reference::abuffer::lists, after sorting.
#import dispatch

@group(0) @binding(0) var<storage, read> offsets: array<u32>;
@group(0) @binding(1) var<storage, read_write> heads: array<u32>;
@group(0) @binding(2) var<storage, read> nodes: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read> links: array<u32>;
@group(0) @binding(4) var<storage, read_write> fragments: array<vec2<u32>>;
#push
override STEP: u32 = 1u;
// 1: each head becomes the number of nodes that its list had, or one more where not all were gathered: for debug
// builds.
override COUNTED: u32 = 0u;

#main item {
    let p = push.band_start + item;
    if p >= push.band_end {
        return;
    }
    let start = offsets[p] - push.first_fragment;
    let first = start + push.done;
    let end = min(offsets[p + 1u] - push.first_fragment, arrayLength(&fragments));
    // The end of a list is beyond every node.
    let count = min(arrayLength(&nodes), arrayLength(&links));
    if first >= end {
        if COUNTED != 0u && push.done == 0u {
            heads[p] = select(0u, 1u, heads[p] < count);
        }
        return;
    }
    let last = min(first + STEP, end);
    var node = heads[p];
    var slot = first;
    for (; slot < last && node < count; slot++) {
        fragments[slot] = nodes[node];
        node = links[node];
    }
    if last < end {
        heads[p] = node;
    } else if COUNTED != 0u {
        heads[p] = slot - start + select(0u, 1u, node < count);
    }
}
