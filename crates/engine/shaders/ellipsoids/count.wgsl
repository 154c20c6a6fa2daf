// ellipsoids/count: how many events each pixel gets, and what has some: an ellipsoid that its ray enters and leaves, or
// a surface. Both counts are zero before the first chunk.
#import raster
#import ellipsoid
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> bodies: array<atomic<u32>>;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let met = met_by(splat, tilt, pixel);
    if met.events > 0u {
        let p = window_index(pixel, view.window);
        atomicAdd(&counts[p], met.events);
        atomicAdd(&bodies[p], 1u);
    }
}
#walker
