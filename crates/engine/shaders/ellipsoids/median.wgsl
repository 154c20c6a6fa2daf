// ellipsoids/median: the depth at which each list first lets through half of the light or less. The runs are composed
// already: they say in which of them that is, whose events are looked at once more. One invocation per list.
// Reference: reference::gaussians::ellipsoid::median.
#import ellipsoid_events
#import composed_lists
@group(0) @binding(21) var<storage, read> sums: array<RunSums>;
@group(0) @binding(22) var<storage, read> partials: array<Partial>;
@group(0) @binding(23) var<storage, read_write> depths: array<f32>;

// The depth within a run at which A reaches a half, behind what lies in front; +inf should roundings leave less.
fn depth_within(run: ListRun, item: u32, front: vec4<f32>, pixel: vec2<u32>) -> f32 {
    let ray = ray_of(pixel);
    let start = run.start + run.run * RUN_LENGTH;
    let end = run.start + min((run.run + 1u) * RUN_LENGTH, run.length);
    let final_event = run.start + run.length - 1u;
    var sum = Composed(front, NOTHING);
    var walk = Walk(open_before(sums[item], run.run), event_at(fragments[start], pixel, ray));
    for (var i = start; i < end; i++) {
        let fragment = fragments[i];
        let step = step_on(&walk, fragment, fragments[min(i + 1u, final_event)], pixel, ray);
        let depth = key_depth(fragment.x) + depth_origin();
        sum = behind(sum, fragment.x, step.surface);
        if sum.rgba.a >= 0.5 {
            return depth;
        }
        // T exp(-x) is a half.
        let x = logarithm(2.0 * (1.0 - sum.rgba.a));
        sum = behind(sum, fragment.x, step.segment.color);
        if sum.rgba.a >= 0.5 {
            return depth + step.segment.length * min(x / step.segment.depth, 1.0);
        }
    }
    return composed_depth(NOTHING);
}

#main item {
    if item >= atomicLoad(&work.list_count) {
        return;
    }
    let list = lists[item];
    let width = view.window.z - view.window.x;
    let pixel = view.window.xy + vec2<u32>(list.pixel % width, list.pixel / width);
    var front = vec4<f32>(0.0);
    var depth = composed_depth(NOTHING);
    for (var k = list.first_run; k < list.first_run + list.runs; k++) {
        let next = front + (1.0 - front.a) * partials[k].rgba;
        if next.a >= 0.5 {
            depth = depth_within(runs[k], k, front, pixel);
            break;
        }
        front = next;
    }
    depths[list.pixel] = depth;
}
