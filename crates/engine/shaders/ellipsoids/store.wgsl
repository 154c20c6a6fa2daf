// ellipsoids/store: puts the events of each splat into slots of its pixel, as abuffer/store does with fragments: depth
// key, and which event it is. Relies on ellipsoids/count visiting the same pixels.
#import raster
#import ellipsoid
@group(0) @binding(8) var<storage, read_write> cursors: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> fragments: array<vec2<u32>>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let p = window_index(pixel, view.window);
    if p < push.band_start || p >= push.band_end {
        return;
    }
    let met = met_by(splat, tilt, pixel);
    if met.events == 0u {
        return;
    }
    let slot = atomicAdd(&cursors[p], met.events) - push.first_fragment;
    // Both passes run the same test on the same numbers; should a driver ever disagree with itself, nothing is written
    // outside.
    if slot < arrayLength(&fragments) && arrayLength(&fragments) - slot >= met.events {
        fragments[slot] = vec2<u32>(depth_key(met.entry), event_id(push.first + i, 0u));
        if met.events == 2u {
            fragments[slot + 1u] = vec2<u32>(depth_key(met.exit), event_id(push.first + i, 1u));
        }
    }
}
#walker
