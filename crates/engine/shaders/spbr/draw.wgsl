// spbr/draw: nearest point and sum of colors in one go. An atomic maximum returns what it replaces: a point that comes
// in gives its color and takes back that of the point before it, so that in the end the nearest one's alone is left, in
// whatever order they came.
#import spbr
#import shade
#import spbr_color
#walker
// Planes, if a round has more than one.
@group(0) @binding(7) var<storage, read_write> nearest: array<atomic<u64>>;
// Colors of all points, in four parts of PART_LENGTH elements as in shared/compose.wgsl.
@group(0) @binding(8) var<storage, read> point_colors_0: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> point_colors_1: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read> point_colors_2: array<vec4<f32>>;
@group(0) @binding(11) var<storage, read> point_colors_3: array<vec4<f32>>;
// For each pixel the nearest point of a round's single ensemble, sums of green and red, of number and blue in the
// halves of two more, and the complement of the nearest depth's key: all in one line of the cache.
@group(0) @binding(12) var<storage, read_write> pixels: array<atomic<u64>>;
// For each pixel the sums of squares of red, green, blue, and a spare one.
@group(0) @binding(13) var<storage, read_write> squares: array<atomic<u64>>;

// 1: squares are summed, too.
override SPREAD: u32 = 0u;
override PARTS: u32 = 1u;
override PART_LENGTH: u32 = 1u;

fn color_at(i: u32) -> vec3<f32> {
    if PARTS == 1u {
        return point_colors_0[i].xyz;
    }
    let k = i % PART_LENGTH;
    switch i / PART_LENGTH {
        case 0u: { return point_colors_0[k].xyz; }
        case 1u: { return point_colors_1[k].xyz; }
        case 2u: { return point_colors_2[k].xyz; }
        default: { return point_colors_3[k].xyz; }
    }
}

// Colors are not shaded here, or were before.
fn whole_color_of(point: u32) -> vec3<u32> {
    return whole_color(blended_color(color_at(point), vec3<f32>(0.0), vec3<f32>(0.0)));
}

fn square(value: u32) -> u64 {
    return u64(value) * u64(value);
}

fn visit(point: u32, plane: u32, depth: u32, pixel: u32) {
    let words = key_words(point, depth);
    let mine = (u64(words.y) << 32u) | u64(words.x);
    var before: u64;
    // As in shared/nearest_wide, reading comes first.
    if PLANES == 0u {
        if atomicLoad(&pixels[4u * pixel]) > mine {
            return;
        }
        before = atomicMax(&pixels[4u * pixel], mine);
    } else {
        let place = plane * push.pixels + pixel;
        if atomicLoad(&nearest[place]) > mine {
            return;
        }
        before = atomicMax(&nearest[place], mine);
    }
    if mine > before {
        let color = whole_color_of(push.list + point);
        // Only the value of this epoch counts.
        let high = u32(before >> 32u);
        let taken = before != 0lu && ((high ^ words.y) & ~(0xffffffffu >> push.epoch_bits)) == 0u;
        var old = vec3<u32>(0u);
        if taken {
            old = whole_color_of(~u32(before) & (0xffffffffu >> push.epoch_bits));
        }
        let red_green = ((u64(color.r) << 32u) | u64(color.g)) - ((u64(old.r) << 32u) | u64(old.g));
        let blue_one = (u64(color.b) << 32u) - (u64(old.b) << 32u) + u64(u32(!taken));
        atomicAdd(&pixels[4u * pixel + 1u], red_green);
        atomicAdd(&pixels[4u * pixel + 2u], blue_one);
        atomicMax(&pixels[4u * pixel + 3u], u64(~depth));
        if SPREAD != 0u {
            atomicAdd(&squares[4u * pixel], square(color.r) - square(old.r));
            atomicAdd(&squares[4u * pixel + 1u], square(color.g) - square(old.g));
            atomicAdd(&squares[4u * pixel + 2u], square(color.b) - square(old.b));
        }
    }
}
