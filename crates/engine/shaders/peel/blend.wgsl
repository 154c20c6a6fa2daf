// peel/blend: puts the layer's fragment behind what was peeled from each pixel, and makes the pixel ready for the next
// layer. One invocation per pixel. The arithmetic and its order are abuffer's: both call `behind` for fragment after
// fragment. Reference: reference::peel::render.
#import compose
#import early_end
#import dispatch
#import peel_work

// As opaque/nearest leaves it, or nearest-depth and nearest-id.
struct Nearest {
    id: u32,
    key: u32,
}

@group(0) @binding(17) var<storage, read_write> nearest: array<Nearest>;
@group(0) @binding(18) var<storage, read_write> last: array<vec2<u32>>;
@group(0) @binding(19) var<storage, read_write> work: PeelWork;
// Layers of each pixel; a single word that stays untouched unless COUNTED.
@group(0) @binding(20) var<storage, read_write> layers: array<u32>;
@group(0) @binding(21) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(22) var<storage, read_write> depths: array<f32>;
#push
override COUNTED: u32 = 0u;

const INFINITY_BITS = 0x7f800000u;

#main p {
    if p >= push.count {
        return;
    }
    let found = nearest[p];
    if found.key == NOTHING {
        return;
    }
    let width = view.window.z - view.window.x;
    let pixel = view.window.xy + vec2<u32>(p % width, p / width);
    let depth = depths[p];
    let front = Composed(image[p], select(depth_key(depth), NOTHING, bitcast<u32>(depth) == INFINITY_BITS));
    let sum = behind(front, shown_key(found.key, found.id), fragment_color(found.id, pixel));
    nearest[p] = Nearest(NOTHING, NOTHING);
    if is_end(sum.rgba.a) {
        // Done, as below, and not a layer.
        last[p] = vec2<u32>(NOTHING);
        return;
    }
    image[p] = sum.rgba;
    depths[p] = composed_depth(sum.key);
    // Behind A = 1 nothing changes a bit: the pixel is done, as if its last fragment were the farthest.
    last[p] = select(vec2<u32>(found.key, found.id), vec2<u32>(NOTHING), sum.rgba.a == 1.0);
    if COUNTED == 1u {
        layers[p] += 1u;
    }
    atomicStore(&work.found, 1u);
}
