// ellipsoids/samples: the samples of a deep EXR, of each run of a sorted list of events, two for each event: the
// surface that it is, and the piece of the ray that it begins. BODIES: one for each event: an ellipsoid as a whole
// where it is entered, or a surface. What is not there has the opacity NO_SAMPLE. One invocation per run.
// Reference: reference::gaussians::ellipsoid.
#import ellipsoid_events
#import sample
#import sorted_runs
@group(0) @binding(20) var<storage, read> sums: array<RunSums>;
@group(0) @binding(21) var<storage, read_write> sample_colors: array<vec4<f32>>;
// Where a sample begins and ends.
@group(0) @binding(22) var<storage, read_write> sample_depths: array<vec2<f32>>;
override BODIES: u32 = 0u;

#main item {
    if item >= atomicLoad(&work.run_count) {
        return;
    }
    let run = runs[item];
    let pixel = pixel_of_run(run);
    let ray = ray_of(pixel);
    let start = start_of_run(run);
    let end = end_of_run(run);
    if BODIES != 0u {
        for (var i = start; i < end; i++) {
            put_body(i, fragments[i], pixel, ray);
        }
        return;
    }
    let final_event = run.start + run.length - 1u;
    // A list of one run has no sums.
    var before = no_sums();
    if run.run > 0u {
        before = open_before(sums[item], run.run);
    }
    var walk = Walk(before, event_at(fragments[start], pixel, ray));
    for (var i = start; i < end; i++) {
        let is_surface = walk.event.surface;
        let next = fragments[min(i + 1u, final_event)];
        let step = step_on(&walk, fragments[i], next, pixel, ray);
        let depth = key_depth(fragments[i].x) + depth_origin();
        put(2u * i, step.surface, vec2<f32>(depth), is_surface);
        let back = max(key_depth(next.x) + depth_origin(), depth);
        put(2u * i + 1u, step.segment.color, vec2<f32>(depth, back), step.segment.color.a > 0.0);
    }
}

fn put(at: u32, color: vec4<f32>, depths: vec2<f32>, is_there: bool) {
    sample_colors[at] = sample_of(color, is_there);
    sample_depths[at] = depths;
}

fn put_body(at: u32, fragment: vec2<u32>, pixel: vec2<u32>, ray: vec4<f32>) {
    let event = event_at(fragment, pixel, ray);
    let depth = key_depth(fragment.x) + depth_origin();
    if event.surface {
        put(at, event.color, vec2<f32>(depth), true);
        return;
    }
    let i = event_splat(fragment.y);
    let tilt = tilt_at(i);
    let color = color_at(i);
    let chord = chord_of(splat_at(i), tilt, pixel);
    let exit = met_of(chord, tilt).exit;
    // The part in front of the near plane is cut off.
    let length = min(2.0 * chord.half, max((chord.middle - view.eye_lo.w) + chord.half, 0.0));
    let opacity = opacity_of(color.a * (length * ray.w));
    put(at, vec4<f32>(color.rgb, opacity), vec2<f32>(depth, max(exit + depth_origin(), depth)), !is_exit(fragment.y));
}
