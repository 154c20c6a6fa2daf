// abuffer/median: the depth at which a long list first lets through half of the light or less. The runs are composed
// already: they say in which of them that is, whose fragments are looked at once more. One invocation per list.
// Reference: reference::abuffer::median.
#import compose
#import early_end
#import composed_lists
@group(0) @binding(21) var<storage, read> partials: array<Partial>;
@group(0) @binding(22) var<storage, read_write> depths: array<f32>;

// A of a run's part behind all that lies in front.
fn joined(front: f32, part: f32) -> f32 {
    return front + (1.0 - front) * part;
}

// The key of the fragment of a run at which A reaches a half, behind what lies in front; NOTHING if the list ends
// before.
fn key_within(run: ListRun, front: f32, pixel: vec2<u32>) -> u32 {
    let first = run.start + run.run * RUN_LENGTH;
    let last = run.start + min((run.run + 1u) * RUN_LENGTH, run.length);
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    for (var i = first; i < last; i++) {
        let fragment = fragments[i];
        sum = behind(sum, fragment.x, fragment_color(fragment.y, pixel));
        let a = joined(front, sum.rgba.a);
        if is_end(a) {
            break;
        }
        if a >= 0.5 {
            return shown_key(fragment.x, fragment.y);
        }
    }
    return NOTHING;
}

#main item {
    if item >= atomicLoad(&work.list_count) {
        return;
    }
    let list = lists[item];
    let width = view.window.z - view.window.x;
    let pixel = view.window.xy + vec2<u32>(list.pixel % width, list.pixel / width);
    var front = 0.0;
    var key = NOTHING;
    for (var k = list.first_run; k < list.first_run + list.runs; k++) {
        let next = joined(front, partials[k].rgba.a);
        if next >= 0.5 || is_end(next) {
            key = key_within(runs[k], front, pixel);
            break;
        }
        front = next;
    }
    depths[list.pixel] = composed_depth(key);
}
