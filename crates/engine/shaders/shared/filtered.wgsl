// A pixel of a listed tile as the filters leave it. Premultiplied color; all 0 for background.
struct Filtered {
    color: vec4<f32>,
    depth: f32,
}

fn filtered_pixel(entry: Entry, count: u32, x: u32, y: u32) -> Filtered {
    let depth_place = pixel_place(entry.x, count, (entry.y >> (4u + ENTRY_DEPTHS)) & 1u, x, y);
    let color_place = pixel_place(entry.x, count, (entry.y >> (4u + ENTRY_COLORS)) & 1u, x, y);
    // A tile of background alone is listed if antialiasing gave it colors.
    let any_depth = ((entry.y >> 4u) & 1u) != 0u;
    let depth = depths[select(2u * count * AREA, depth_place, any_depth)];
    let color = colors[color_place];
    return Filtered(select(vec4<f32>(0.0), color, color.w >= 0.0), depth);
}
