// abuffer/end: composes a long list once more, up to its early end (shared/early_end.wgsl), if it has one. The runs are
// composed already: they say in which of them that is, whose fragments are looked at once more. One invocation per
// list. Reference: reference::abuffer::before_end.
#import compose
#import early_end
#import composed_lists
@group(0) @binding(21) var<storage, read> partials: array<Partial>;
@group(0) @binding(22) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(23) var<storage, read_write> depths: array<f32>;

// The fragments of a run in front of the end, composed by themselves; `front` is what lies before the run.
fn part_before_end(run: ListRun, front: Composed, pixel: vec2<u32>) -> Composed {
    let first = run.start + run.run * RUN_LENGTH;
    let last = run.start + min((run.run + 1u) * RUN_LENGTH, run.length);
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    for (var i = first; i < last; i++) {
        let fragment = fragments[i];
        let next = behind(sum, shown_key(fragment.x, fragment.y), fragment_color(fragment.y, pixel));
        if is_end(run_behind(front, next).rgba.a) {
            break;
        }
        sum = next;
    }
    return sum;
}

#main item {
    if item >= atomicLoad(&work.list_count) {
        return;
    }
    let list = lists[item];
    let width = view.window.z - view.window.x;
    let pixel = view.window.xy + vec2<u32>(list.pixel % width, list.pixel / width);
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    for (var k = list.first_run; k < list.first_run + list.runs; k++) {
        let next = run_behind(sum, Composed(partials[k].rgba, partials[k].key.x));
        if is_end(next.rgba.a) {
            sum = run_behind(sum, part_before_end(runs[k], sum, pixel));
            image[list.pixel] = sum.rgba;
            depths[list.pixel] = list_depth(sum);
            break;
        }
        sum = next;
    }
}
