// soft/count: how many events each pixel gets: a sphere's ray enters and leaves each of its shells. counts is zero
// before the first chunk, and so is spheres, which counts each sphere once if it has shells (COUNTED).
#import soft_raster
@group(0) @binding(9) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> spheres: array<atomic<u32>>;
override COUNTED: u32 = 0u;

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let chord = chord_of(splat, tilt, pixel, ray_of(pixel));
    if chord.edge <= 0.0 {
        return;
    }
    let p = window_index(pixel, view.window);
    let shells = shells_met(chord, shells_of(splat), near_depth(), solid_depth(p));
    if shells > 0u {
        atomicAdd(&counts[p], 2u * shells);
        if COUNTED != 0u {
            atomicAdd(&spheres[p], 1u);
        }
    }
}
#walker
