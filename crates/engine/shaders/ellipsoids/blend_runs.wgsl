// ellipsoids/blend-runs: composes the events of each run of a sorted list, and the segments that they begin, with the sums over what is open
// that the runs before have left. One invocation per run.
// Reference: reference::gaussians::ellipsoid.
#import ellipsoid_events
#import long_list
#import run_sums
#import dispatch

@group(0) @binding(17) var<storage, read_write> work: LongWork;
@group(0) @binding(18) var<storage, read> runs: array<ListRun>;
@group(0) @binding(19) var<storage, read> fragments: array<vec2<u32>>;
@group(0) @binding(20) var<storage, read> sums: array<RunSums>;
@group(0) @binding(21) var<storage, read_write> partials: array<Partial>;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let item = invocation_index(workgroup, groups, local);
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let width = view.window.z - view.window.x;
    let pixel = view.window.xy + vec2<u32>(run.pixel % width, run.pixel / width);
    let ray = ray_of(pixel);
    var open = no_sums();
    if run.run > 0u {
        let before = sums[item];
        open = Sums(before.high, before.low, before.rest.xy, before.rest.z);
    }
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    let start = run.start + run.run * RUN_LENGTH;
    let end = run.start + min((run.run + 1u) * RUN_LENGTH, run.length);
    let final_event = run.start + run.length - 1u;
    var event = event_at(fragments[start], pixel, ray);
    for (var i = start; i < end; i++) {
        let fragment = fragments[i];
        if event.surface {
            sum = behind(sum, fragment.x, event.color);
        } else {
            open = after_event(open, terms_of(event), is_exit(fragment.y));
        }
        // Behind the last event nothing is open.
        let next = event_at(fragments[min(i + 1u, final_event)], pixel, ray);
        sum = behind(sum, fragment.x, between(open, event.depth, next.depth, ray));
        event = next;
    }
    let key = select(depth_key(key_depth(sum.key) + depth_origin()), NOTHING, sum.key == NOTHING);
    partials[item] = Partial(sum.rgba, vec4<u32>(key, 0u, 0u, 0u));
}
