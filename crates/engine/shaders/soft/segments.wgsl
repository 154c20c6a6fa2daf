// soft/segments: optical depths of the segments that the events of sorted long lists begin, base model. One workgroup
// per run, four segments per invocation. Every sphere whose entry lies before the run's end and near enough to reach it
// is integrated over every segment: beside its chord that is nothing, so no list of open spheres is needed, however
// many there are. A dispatch looks at TAKEN events of each list from push.first on; later ones add to what those before
// found.
#push
#import soft_terms
#import segment
#import sorted_runs
@group(0) @binding(20) var<storage, read_write> segments: array<f32>;
@group(0) @binding(21) var<storage, read> records: array<vec4<u32>>;
override TAKEN: u32 = 1u;

const HELD = RUN_LENGTH / WG_SIZE;

// The events of the run's list that are looked at, and the spheres that begin at 64 of them.
var<workgroup> range: vec2<u32>;
var<workgroup> spheres: array<vec4<f32>, WG_SIZE>;

// Index of the first event of a list at or behind a depth.
fn first_behind(run: ListRun, depth: f32) -> u32 {
    let key = depth_key(depth);
    var low = 0u;
    var high = run.length;
    while low < high {
        let middle = (low + high) / 2u;
        if fragments[run.start + middle].x < key {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

fn range_of(run: ListRun) -> vec2<u32> {
    let start = run.run * RUN_LENGTH;
    let nearest = key_depth(fragments[run.start + start].x);
    // No chord is longer than the largest sphere's diameter, as depth along the axis or not; give or take rounding.
    let reach = 2.0 * push.max_radius;
    let low = max(first_behind(run, nearest - reach - 1e-5 * (abs(nearest) + reach)), push.first);
    let high = min(min(start + RUN_LENGTH, run.length), push.first + TAKEN);
    return vec2<u32>(low, max(low, high));
}

// The sphere that begins at an event: edge, middle, reach and absorption; no edge for an exit.
fn sphere_at(event: u32, pixel: vec2<u32>, ray: vec4<f32>) -> vec4<f32> {
    let id = fragments[event].y;
    if is_exit(id) {
        return vec4<f32>(0.0);
    }
    return opened(id, pixel, ray).sphere;
}

#main {
    let item = workgroup_index(workgroup, groups);
    let count = atomicLoad(&work.run_count);
    let present = item < count;
    let run = runs[min(item, count - 1u)];
    if local == 0u {
        range = select(vec2<u32>(0u), range_of(run), present);
    }
    let events = workgroupUniformLoad(&range);
    let pixel = pixel_of_run(run);
    let ray = ray_of(pixel);
    let start = run.run * RUN_LENGTH;

    var first = vec4<f32>(0.0);
    var last = vec4<f32>(0.0);
    for (var h = 0u; h < HELD; h++) {
        let k = min(start + local + h * WG_SIZE, run.length - 1u);
        first[h] = event_depth(fragments[run.start + k]);
        last[h] = event_depth(fragments[run.start + min(k + 1u, run.length - 1u)]);
    }
    // Compensated: thousands of spheres may be open.
    var sum = vec4<f32>(0.0);
    var excess = vec4<f32>(0.0);
    var units = vec4<u32>(0u);
    for (var chunk = events.x; chunk < events.y; chunk += WG_SIZE) {
        if chunk + local < events.y {
            spheres[local] = sphere_at(run.start + chunk + local, pixel, ray);
        }
        workgroupBarrier();
        for (var j = 0u; j < min(WG_SIZE, events.y - chunk); j++) {
            let open = spheres[j];
            if open.x <= 0.0 {
                continue;
            }
            // Written out: iterations are few.
            let found = vec4<f32>(
                segment_of(open, vec2<f32>(first.x, 0.0), last.x, false),
                segment_of(open, vec2<f32>(first.y, 0.0), last.y, false),
                segment_of(open, vec2<f32>(first.z, 0.0), last.z, false),
                segment_of(open, vec2<f32>(first.w, 0.0), last.w, false),
            );
            if PACKED != 0u {
                units = min(units + vec4<u32>(min(found, vec4<f32>(31.0)) * 67108864.0 + 0.5), vec4<u32>(MOST_UNITS));
                continue;
            }
            let wanted = found - excess;
            let total = sum + wanted;
            excess = (total - sum) - wanted;
            sum = total;
        }
        workgroupBarrier();
    }
    for (var h = 0u; h < HELD; h++) {
        let k = start + local + h * WG_SIZE;
        if present && k < min(start + RUN_LENGTH, run.length) {
            let at = run.start + k;
            // Packed ones are whole numbers until soft/blend-runs reads them.
            if PACKED != 0u {
                let before = select(bitcast<u32>(segments[at]), 0u, push.first == 0u);
                segments[at] = bitcast<f32>(plus_units(before, units[h]));
            } else {
                segments[at] = select(segments[at], 0.0, push.first == 0u) + sum[h];
            }
        }
    }
}
