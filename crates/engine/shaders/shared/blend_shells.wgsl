// Blends the sorted events of one pixel by the concentric model: densities of open shells add up.
// Reference: reference::soft.
fn blend_list(list: List, begin: Place, n: u32, pixel: vec2<u32>) -> Composed {
    let ray = ray_of(pixel);
    var place = begin;
    var sums = no_sums();
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    var key = 0x80000000u;
    var first = vec2<f32>(0.0);
    for (var k = 0u; k < n; k++) {
        let event = taken(list, &place);
        let terms = terms_of(event, pixel, ray);
        let last = vec2<f32>(key_depth(event.x), terms.rest);
        sum = behind(sum, key, segment_color(sums, segment_depth(sums, first, last, ray)));
        sums = after_event(sums, terms, is_exit(event.y));
        first = last;
        key = event.x;
        if k % LOOK == LOOK - 1u && done(sum, 1.0, push.max_color) {
            break;
        }
    }
    return sum;
}
