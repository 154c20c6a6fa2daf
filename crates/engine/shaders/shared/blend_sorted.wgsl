// Blends a sorted list of one class front to back.

// Fragments between two tests for an early stop, of lists longer than these, which the tests would not make faster.
const LOOK = 16u;
const WHOLE = 64u;

fn blend_sorted(list: List, start: Place, n: u32, pixel: vec2<u32>) -> Composed {
    var place = start;
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    for (var i = 0u; i < n; i++) {
        let fragment = taken(list, &place);
        let next = behind(sum, shown_key(fragment.x, fragment.y), fragment_color(fragment.y, pixel));
        if is_end(next.rgba.a) {
            break;
        }
        sum = next;
        if n > WHOLE && i % LOOK == LOOK - 1u && done(sum, push.max_opacity, push.max_color) {
            break;
        }
    }
    return sum;
}
