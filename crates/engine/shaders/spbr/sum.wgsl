// spbr/sum: the same slots again; the color of each point that is the nearest of its ensemble to the sums of its pixel.
#import spbr
#import shade
#import spbr_color
#walker
// Index and depth as spbr/nearest left them: complements of a key's words.
@group(0) @binding(7) var<storage, read> nearest: array<vec2<u32>>;
@group(0) @binding(8) var<storage, read> point_colors: array<vec4<f32>>;
// Eight words for each pixel: two spare ones; sums of green, red, number, blue; complement of the nearest depth's key.
@group(0) @binding(9) var<storage, read_write> pixels: array<atomic<u32>>;
// For each pixel the sums of squares of red, green, blue, 64 bits each, and a spare one.
@group(0) @binding(10) var<storage, read_write> squares: array<atomic<u32>>;

// 1: squares are summed, too.
override SPREAD: u32 = 0u;

fn color_of(point: u32) -> vec3<f32> {
    let color = point_colors[point].xyz;
    if SHADING == SHADING_NONE {
        return blended_color(color, vec3<f32>(0.0), vec3<f32>(0.0));
    }
    let position = rounded(in_camera(minus_eye(points_hi[point].xyz, points_lo[point].xyz)));
    return blended_color(color, position, rounded(turned(normals[point].xyz)));
}

fn add_square(place: u32, value: u32) {
    let low = value & 0xffffu;
    let high = value >> 16u;
    let cross = low * high;
    // (high 2^16 + low)^2, in two words.
    let first = low * low;
    let added = first + (cross << 17u);
    let upper = high * high + (cross >> 15u) + u32(added < first);
    let before = atomicAdd(&squares[place], added);
    atomicAdd(&squares[place + 1u], upper + u32(before + added < before));
}

fn visit(point: u32, plane: u32, depth: u32, pixel: u32) {
    if all(nearest[plane * push.pixels + pixel] == ~key_words(point, depth)) {
        let color = whole_color(color_of(point));
        atomicAdd(&pixels[8u * pixel + 2u], color.g);
        atomicAdd(&pixels[8u * pixel + 3u], color.r);
        atomicAdd(&pixels[8u * pixel + 4u], 1u);
        atomicAdd(&pixels[8u * pixel + 5u], color.b);
        atomicMax(&pixels[8u * pixel + 6u], ~depth);
        if SPREAD != 0u {
            add_square(8u * pixel, color.r);
            add_square(8u * pixel + 2u, color.g);
            add_square(8u * pixel + 4u, color.b);
        }
    }
}
