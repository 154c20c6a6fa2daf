// abuffer/resolve-ordered: blends lists whose splats were stored in the order of blending, front to back until nothing
// behind can be seen. One invocation per pixel of the band. Lists of more than RUN_LENGTH are composed run by run, as
// those are that must be sorted, so that both give the same bytes. A dispatch takes TAKEN splats; the next one goes on
// from the image. Reference: reference::abuffer::composite.
#import compose
#import stop
#import long_list
#import dispatch

@group(0) @binding(17) var<storage, read> offsets: array<u32>;
@group(0) @binding(18) var<storage, read> indices: array<u32>;
@group(0) @binding(19) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(20) var<storage, read_write> depths: array<f32>;
#push

override TAKEN: u32 = 1u;
// Splats between two tests for an early stop.
const LOOK = 16u;

#main item {
    let p = push.band_start + item;
    if p >= push.band_end {
        return;
    }
    let first = offsets[p] + push.segment * TAKEN;
    let end = min(first + TAKEN, offsets[p + 1u]);
    if first >= end {
        return;
    }
    let width = view.window.z - view.window.x;
    let pixel = view.window.xy + vec2<u32>(p % width, p / width);
    var total = Composed(vec4<f32>(0.0), NOTHING);
    if push.segment > 0u {
        let seen = depths[p] <= 3.4e38;
        total = Composed(image[p], select(NOTHING, 0u, seen));
    }
    let before = total.key;
    // A run is followed by another run, which may be opaque.
    let long = offsets[p + 1u] - offsets[p] > RUN_LENGTH;
    let max_opacity = select(push.max_opacity, 1.0, long);
    let start = first - push.first_fragment;
    let n = end - first;
    var run = Composed(vec4<f32>(0.0), NOTHING);
    var i = 0u;
    // There is a first one, so the condition may stand at the end: CPU drivers run every loop once more otherwise.
    loop {
        let index = indices[start + i];
        run = behind(run, index, fragment_color(index, pixel));
        i += 1u;
        let ends = i == n || i % RUN_LENGTH == 0u;
        let joined = Composed(total.rgba + (1.0 - total.rgba.a) * run.rgba, select(total.key, run.key, total.key == NOTHING));
        // Within the first run nothing lies in front, and the run is the sum.
        let alone = push.segment == 0u && i < RUN_LENGTH;
        let stops = (ends || (alone && i % LOOK == 0u)) && done(joined, max_opacity, push.max_color);
        if ends || stops {
            total = joined;
            run = Composed(vec4<f32>(0.0), NOTHING);
        }
        if i >= n || stops {
            break;
        }
    }
    image[p] = total.rgba;
    if before == NOTHING && total.key != NOTHING {
        depths[p] = depth_at(total.key);
    }
}
