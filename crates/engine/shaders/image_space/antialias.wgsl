// image-space/antialias: where depths have an edge, color and alpha are blended with the mean of the four neighbors.
// Depths stay; background beside an edge gets some alpha. One workgroup per listed tile. Reference:
// reference::image_space::Layer::antialiased.
#import filter

fn known_depth(entry: Entry, x: i32, y: i32) -> f32 {
    let depth = depth_at(entry, x, y);
    return select(depth, p.far, is_background(depth));
}

// Nothing instead of background.
fn known_color(color: vec4<f32>) -> vec4<f32> {
    return select(vec4<f32>(0.0), color, color.w >= 0.0);
}

fn filter_tile(entry: Entry, column: u32, first_row: u32, local: u32) {
    let x = i32(column);
    let y = i32(first_row);
    var depth_above = known_depth(entry, x, y - 1);
    var depth_here = known_depth(entry, x, y);
    var color_above = color_at(entry, x, y - 1);
    var color_here = color_at(entry, x, y);
    for (var i = 0; i < i32(STRIP); i++) {
        let depth_below = known_depth(entry, x, y + i + 1);
        let color_below = color_at(entry, x, y + i + 1);
        let beside = known_depth(entry, x - 1, y + i) + known_depth(entry, x + 1, y + i);
        let edge = abs(4.0 * depth_here - (depth_above + depth_below + beside));
        let share = select(min(1.0, edge / (4.0 * p.distance)), 0.0, edge == 0.0);
        let left = known_color(color_at(entry, x - 1, y + i));
        let right = known_color(color_at(entry, x + 1, y + i));
        let around = known_color(color_above) + known_color(color_below) + left + right;
        let mixed = (1.0 - 0.5 * share) * known_color(color_here) + (0.125 * share) * around;
        // Background that nothing lies beside stays background.
        let changed = share >= p.threshold && (color_here.w >= 0.0 || around.w > 0.0);
        colors[write_place(entry, ENTRY_COLORS, column, first_row + u32(i))] = select(color_here, mixed, changed);
        depth_above = depth_here;
        depth_here = depth_below;
        color_above = color_here;
        color_here = color_below;
    }
    if local == 0u {
        tiles[entry.x].z ^= COLOR_SIDE;
    }
}
