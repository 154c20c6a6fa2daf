// Blends the sorted events of one pixel by the base model: the spheres that are open stand in an array, and each
// segment integrates all of them.
// Reference: reference::soft.
#import segment

fn blend_list(list: List, begin: Place, n: u32, pixel: vec2<u32>) -> Composed {
    // Edge, middle, reach and absorption; color times weight and weight. Half of the events are entries.
    var open: array<vec4<f32>, CAPACITY / 2u>;
    var terms: array<vec4<f32>, CAPACITY / 2u>;
    var ids: array<u32, CAPACITY / 2u>;
    let ray = ray_of(pixel);
    var place = begin;
    var sums = no_sums();
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    var count = 0u;
    var key = 0x80000000u;
    var first = vec2<f32>(0.0);
    for (var k = 0u; k < n; k++) {
        let event = taken(list, &place);
        let i = event_splat(event.y);
        let last = event_depth(event);
        var depth = 0.0;
        var units = 0u;
        var leaving = 0u;
        let exit = is_exit(event.y);
        for (var j = 0u; j < count; j++) {
            let found = segment_of(open[j], first, last, exit && ids[j] == i);
            if PACKED == 0u {
                depth += found;
            } else {
                units = plus_units(units, units_of(found));
            }
            leaving = select(leaving, j, ids[j] == i);
        }
        if PACKED != 0u {
            depth = f32(units) * DEPTH_UNIT;
        }
        sum = behind(sum, key, segment_color(sums, depth));
        first = vec2<f32>(last, 0.0);
        if exit {
            first.y = rest_of(open[leaving].y, open[leaving].z * half_chord(open[leaving].x, 0.0), true, last);
            sums = after_event(sums, Terms(terms[leaving], 0.0, 0.0), true);
            count -= 1u;
            open[leaving] = open[count];
            terms[leaving] = terms[count];
            ids[leaving] = ids[count];
        } else if count < CAPACITY / 2u {
            let entered = opened(event.y, pixel, ray);
            first.y = rest_of(entered.sphere.y, entered.sphere.z * half_chord(entered.sphere.x, 0.0), false, last);
            open[count] = entered.sphere;
            terms[count] = entered.terms;
            ids[count] = i;
            sums = after_event(sums, Terms(entered.terms, 0.0, 0.0), false);
            count += 1u;
        }
        key = event.x;
        if k % LOOK == LOOK - 1u && done(sum, 1.0, push.max_color) {
            break;
        }
    }
    return sum;
}
