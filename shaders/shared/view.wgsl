// The camera and the part of the image in work. Camera axes: x right, y down, z forward.
// Positions on the screen are relative to the image's centre, where float32 is finest.
struct View {
    right: vec4<f32>,
    down: vec4<f32>,
    forward: vec4<f32>,
    // Eye minus the cloud's origin as a sum of two floats.
    eye_hi: vec4<f32>,
    eye_lo: vec4<f32>,
    // To the light (w = 0) or the light's place relative to the eye (w = 1), in camera axes.
    light: vec4<f32>,
    // Ambient, diffuse, specular, shininess.
    material: vec4<f32>,
    // The rectangle in work: first column, first row, one past the last column and row.
    window: vec4<u32>,
    // Columns and rows of the whole image.
    size: vec2<u32>,
    near: f32,
    far: f32,
    // Pixels over a world unit at depth 1 (perspective) or anywhere (orthographic).
    focal_px: f32,
    orthographic: u32,
    radius_factor: f32,
    max_radius_px: f32,
}

// Position of a pixel's centre relative to the image's centre; exact.
fn pixel_center(pixel: vec2<u32>, size: vec2<u32>) -> vec2<f32> {
    let middle = vec2<i32>(size / 2u);
    let odd = vec2<f32>(size % 2u) * 0.5;
    return vec2<f32>(vec2<i32>(pixel) - middle) + 0.5 - odd;
}

// The pixel that contains a position given relative to the image's centre, clamped to a ring around the image.
fn pixel_at(position: vec2<f32>, size: vec2<u32>) -> vec2<i32> {
    let middle = vec2<i32>(size / 2u);
    let odd = vec2<f32>(size % 2u) * 0.5;
    let limit = vec2<f32>(size);
    return vec2<i32>(clamp(floor(position + odd), -limit, limit)) + middle;
}

// Place of a pixel in the buffers of the rectangle in work.
fn window_index(pixel: vec2<u32>, window: vec4<u32>) -> u32 {
    return (pixel.y - window.y) * (window.z - window.x) + pixel.x - window.x;
}
