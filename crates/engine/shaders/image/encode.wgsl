// image/encode: pixels over a background as bytes, those of the PNG, in some rows of a picture, and the cover of each
// pixel if it is asked for. One invocation per pixel of the picture. A coarser image is enlarged by bilinear
// interpolation: the centers of both coincide, and a row of the picture is `scale` rows of the image.
// Reference: output::to_byte.
#import dispatch

#push

@group(0) @binding(0) var<storage, read> image: array<vec4<f32>>;
// The least value of each byte; nothing reaches that of 256.
@group(0) @binding(1) var<storage, read> steps: array<f32>;
@group(0) @binding(2) var<storage, read_write> bytes: array<u32>;

fn composed(column: u32, row: u32) -> vec3<f32> {
    let pixel = image[row * push.image_width + column];
    let background = vec3<f32>(push.background_r, push.background_g, push.background_b);
    return pixel.rgb + (1.0 - pixel.a) * background;
}

// Of a pixel center of the picture, in pixels of the image from the center of its first one.
fn place(at: u32, size: u32, image_size: u32) -> f32 {
    let centered = (f32(at) + 0.5 - 0.5 * f32(size)) * push.scale;
    return clamp(centered + 0.5 * f32(image_size) - 0.5, 0.0, f32(image_size - 1u));
}

fn between(a: vec3<f32>, b: vec3<f32>, t: f32) -> vec3<f32> {
    return a * (1.0 - t) + b * t;
}

fn enlarged(column: u32, row: u32) -> vec3<f32> {
    let x = place(column, push.width, push.image_width);
    let y = place(row, push.height, push.image_height);
    let left = u32(x);
    let above = u32(y);
    let right = min(left + 1u, push.image_width - 1u);
    let below = min(above + 1u, push.image_height - 1u);
    let along = x - f32(left);
    let down = y - f32(above);
    let upper = between(composed(left, above), composed(right, above), along);
    let lower = between(composed(left, below), composed(right, below), along);
    return between(upper, lower, down);
}

// The number of steps below a value; NaN is 0.
fn byte_of(value: f32) -> u32 {
    let x = min(select(0.0, value, value > 0.0), 1.0);
    var guess = x;
    if push.encoded == 0u {
        // Within 0.3 of a byte, and cheaper than a power.
        let half = sqrt(x);
        let quarter = sqrt(half);
        let curve = 0.662002687 * half + 0.684122060 * quarter - 0.323583601 * sqrt(quarter) - 0.0225411470 * x;
        guess = select(curve, 12.92 * x, x <= 0.0031308);
    }
    // A guess may be off by one. The table has the last word.
    var byte = u32(clamp(255.0 * guess + 0.5, 0.0, 255.0));
    while byte > 0u && x < steps[byte] {
        byte -= 1u;
    }
    while byte < 255u && x >= steps[byte + 1u] {
        byte += 1u;
    }
    return byte;
}

// How much of a pixel is covered, 0 (nothing) to 3 (all that can be seen): core::image::Cover.
fn cover(alpha: f32) -> u32 {
    if alpha > push.opaque {
        return 3u;
    }
    if alpha >= push.faint {
        return 2u;
    }
    // By its bits, since devices may take the smallest numbers for 0; NaN and negative numbers are nothing.
    return select(0u, 1u, bitcast<u32>(alpha) - 1u < 0x7f800000u);
}

#main p {
    if p >= push.count {
        return;
    }
    let column = p % push.width;
    let row = push.first_row + p / push.width;
    var color: vec3<f32>;
    if push.image_width == push.width && push.image_height == push.height {
        color = composed(column, row);
    } else {
        color = enlarged(column, row);
    }
    let r = byte_of(color.r);
    let g = byte_of(color.g);
    let b = byte_of(color.b);
    let first = select(r, b, push.blue_first == 1u);
    let third = select(b, r, push.blue_first == 1u);
    var last = 255u;
    if push.covers == 1u {
        last = cover(image[row * push.image_width + column].a);
    }
    bytes[p] = first | (g << 8u) | (third << 16u) | (last << 24u);
}
