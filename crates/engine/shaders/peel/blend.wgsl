// peel/blend: puts the fragments that a walk found behind what was peeled from each pixel, and makes the pixel ready
// for the next walk. One invocation per pixel. The arithmetic and its order are abuffer's: both call `behind` for
// fragment after fragment. Reference: reference::peel::render.
#import compose
#import early_end
#import dispatch
#import peel_work

// A slot as peel/nearest leaves it, or nearest-depth and nearest-id.
struct Nearest {
    id: u32,
    key: u32,
}

// SLOTS of each pixel, from near to far.
@group(0) @binding(17) var<storage, read_write> nearest: array<Nearest>;
@group(0) @binding(18) var<storage, read_write> last: array<vec2<u32>>;
@group(0) @binding(19) var<storage, read_write> work: PeelWork;
// Layers of each pixel; a single word that stays untouched unless COUNTED.
@group(0) @binding(20) var<storage, read_write> layers: array<u32>;
@group(0) @binding(21) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(22) var<storage, read_write> depths: array<f32>;
#push
override COUNTED: u32 = 0u;
override SLOTS: u32 = 1u;

const INFINITY_BITS = 0x7f800000u;

#main p {
    if p >= push.count {
        return;
    }
    let first = SLOTS * p;
    if nearest[first].key == NOTHING {
        return;
    }
    let width = view.window.z - view.window.x;
    let pixel = view.window.xy + vec2<u32>(p % width, p / width);
    let depth = depths[p];
    var front = Composed(image[p], select(depth_key(depth), NOTHING, bitcast<u32>(depth) == INFINITY_BITS));
    // A pixel is done if nothing is left, at the end of a list of Gaussians, and behind A = 1, where nothing changes a
    // bit: as if its last fragment were the farthest.
    var farthest = vec2<u32>(NOTHING);
    var blended = 0u;
    for (; blended < push.layers; blended++) {
        let found = nearest[first + blended];
        if found.key == NOTHING {
            farthest = vec2<u32>(NOTHING);
            break;
        }
        let sum = behind(front, shown_key(found.key, found.id), fragment_color(found.id, pixel));
        if is_end(sum.rgba.a) {
            farthest = vec2<u32>(NOTHING);
            break;
        }
        front = sum;
        farthest = vec2<u32>(found.key, found.id);
        if sum.rgba.a == 1.0 {
            farthest = vec2<u32>(NOTHING);
            blended++;
            break;
        }
    }
    for (var slot = first; slot < first + SLOTS; slot++) {
        nearest[slot] = Nearest(NOTHING, NOTHING);
    }
    last[p] = farthest;
    if blended == 0u {
        return;
    }
    image[p] = front.rgba;
    depths[p] = composed_depth(front.key);
    if COUNTED == 1u {
        layers[p] += blended;
    }
    if atomicLoad(&work.found) < blended {
        atomicMax(&work.found, blended);
    }
}
