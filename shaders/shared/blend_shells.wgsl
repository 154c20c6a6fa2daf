// Blends the sorted events of one pixel by the concentric model: densities of open shells add up.
// Reference: reference::soft.
fn blend_list(list: ptr<function, array<vec2<u32>, 2u * CAPACITY>>, start: u32, n: u32, pixel: vec2<u32>) -> Composed {
    let ray = ray_of(pixel);
    var sums = no_sums();
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    var key = 0x80000000u;
    for (var k = 0u; k < n; k++) {
        let event = (*list)[start + k];
        let depth = segment_depth(sums, key_depth(key), key_depth(event.x), ray);
        sum = behind(sum, key, segment_color(sums, depth));
        sums = after_event(sums, terms_of(event.y, pixel, ray), is_exit(event.y));
        key = event.x;
        if k % LOOK == LOOK - 1u && done(sum, 1.0, push.most_color) {
            break;
        }
    }
    return sum;
}
