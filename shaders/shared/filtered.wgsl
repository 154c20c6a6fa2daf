// A pixel of the image that the filters leave: where it is, its tile says. Premultiplied color; all 0 for background.
struct Filtered {
    color: vec4<f32>,
    depth: f32,
}

fn filtered_pixel(pixel: vec2<u32>, columns: u32, count: u32) -> Filtered {
    let tile = pixel.y / TILE * columns + pixel.x / TILE;
    let flags = tiles[tile].z;
    let depth_side = select(0u, 1u, (flags & DEPTH_SIDE) != 0u);
    let color_side = select(0u, 1u, (flags & COLOR_SIDE) != 0u);
    let within = pixel % TILE;
    let color = colors[pixel_place(tile, count, color_side, within.x, within.y)];
    let depth = depths[pixel_place(tile, count, depth_side, within.x, within.y)];
    return Filtered(select(vec4<f32>(0.0), color, color.w >= 0.0), depth);
}
