// image-space/smooth: the mean of what is not background in the 3 × 3 around a pixel, with weights of 16 in the middle,
// 2 beside it and 1 in the corners. Depths stay. One workgroup per listed tile. Reference:
// reference::image_space::Layer::smoothed.
#import filter

// A row of three, weighted 1, 2, 1, with its middle and the sum of the weights.
struct Row {
    sum: vec4<f32>,
    middle: vec4<f32>,
    weight: f32,
}

fn row_at(entry: Entry, x: i32, y: i32) -> Row {
    let left = color_at(entry, x - 1, y);
    let middle = color_at(entry, x, y);
    let right = color_at(entry, x + 1, y);
    let used = select(vec3<f32>(0.0), vec3<f32>(1.0), vec3<f32>(left.w, middle.w, right.w) >= vec3<f32>(0.0));
    let sum = used.x * left + 2.0 * used.y * middle + used.z * right;
    return Row(sum, middle, used.x + 2.0 * used.y + used.z);
}

fn filter_tile(entry: Entry, column: u32, first_row: u32, local: u32) {
    let x = i32(column);
    var above = row_at(entry, x, i32(first_row) - 1);
    var here = row_at(entry, x, i32(first_row));
    for (var i = 0u; i < STRIP; i++) {
        let row = first_row + i;
        let below = row_at(entry, x, i32(row) + 1);
        // The rows by 1, 2, 1 again: 4 in the middle, and what is missing there.
        let sum = above.sum + 2.0 * here.sum + below.sum + 12.0 * here.middle;
        let weight = above.weight + 2.0 * here.weight + below.weight + 12.0;
        let color = select(here.middle, sum / weight, here.middle.w >= 0.0);
        colors[write_place(entry, ENTRY_COLORS, column, row)] = color;
        above = here;
        here = below;
    }
    if local == 0u {
        tiles[entry.x].z ^= COLOR_SIDE;
    }
}
