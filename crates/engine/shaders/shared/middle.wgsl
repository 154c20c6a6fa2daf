// Where the viewing axis meets the image, in pixels: exact, since shifts are multiples of 1/128. The stage has `view`.
fn middle_of_image() -> vec2<f32> {
    return 0.5 * vec2<f32>(view.size) + view.shift;
}
