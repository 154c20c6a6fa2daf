// soft/store: puts the events of each sphere into slots of its pixel, as abuffer/store does with fragments: depth key
// of entry and exit, cut at near and at the solid points, and which they are.
// Relies on soft/count visiting the same pixels.
#import soft_raster
#import packed
@group(0) @binding(9) var<storage, read_write> cursors: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> fragments: array<vec2<u32>>;
@group(0) @binding(11) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(12) var<storage, read_write> records: array<vec4<u32>>;

// Entry and exit of one shell of a chord.
fn put(chord: Chord, shell: u32, shells: u32, far: f32, slot: u32, i: u32) {
    let near = near_depth();
    let half = chord.reach * half_chord(chord.edge, f32(shell) / f32(shells));
    let at = slot + 2u * shell;
    // Both passes run the same test on the same numbers; should a driver ever disagree with itself, nothing is written
    // outside.
    if at + 1u < arrayLength(&fragments) {
        fragments[at] = vec2<u32>(depth_key(clamp(chord.middle - half, near, far)), event_id(i, shell, 0u));
        fragments[at + 1u] = vec2<u32>(depth_key(clamp(chord.middle + half, near, far)), event_id(i, shell, 1u));
    }
}

fn visit(i: u32, splat: Splat, tilt: Tilt, pixel: vec2<u32>) {
    let p = window_index(pixel, view.window);
    if p < push.band_start || p >= push.band_end {
        return;
    }
    let chord = chord_of(splat, tilt, pixel, ray_of(pixel));
    if chord.edge <= 0.0 {
        return;
    }
    let far = solid_depth(p);
    let shells = shells_of(splat);
    let met = shells_met(chord, shells, near_depth(), far);
    if met == 0u {
        return;
    }
    let slot = atomicAdd(&cursors[p], 2u * met) - push.first_fragment;
    if PACKED != 0u {
        put_packed(chord, splat.radius, colors[i].rgb, far, slot);
        return;
    }
    put(chord, 0u, shells, far, slot, push.first + i);
    // Four at a time, for the sake of the iterations: one invocation may visit thousands of pixels.
    for (var shell = 1u; shell < met; shell += 4u) {
        for_shell(chord, shell, met, shells, far, slot, push.first + i);
        for_shell(chord, shell + 1u, met, shells, far, slot, push.first + i);
        for_shell(chord, shell + 2u, met, shells, far, slot, push.first + i);
        for_shell(chord, shell + 3u, met, shells, far, slot, push.first + i);
    }
}

// Entry and exit with what the paper stores of them. Lists have entries and exits alike, so that slots of entries are
// even.
fn put_packed(chord: Chord, radius: f32, color: vec3<f32>, far: f32, slot: u32) {
    let near = near_depth();
    let half = chord.reach * half_chord(chord.edge, 0.0);
    let entry = clamp(chord.middle - half, near, far);
    let exit = clamp(chord.middle + half, near, far);
    if slot + 1u < min(arrayLength(&fragments), arrayLength(&records)) {
        fragments[slot] = vec2<u32>(depth_key(entry), slot);
        fragments[slot + 1u] = vec2<u32>(depth_key(exit), slot + 1u);
        records[slot] = pack_record(chord, radius, color, entry + depth_origin());
        records[slot + 1u] = pack_record(chord, radius, color, -(exit + depth_origin()));
    }
}

fn for_shell(chord: Chord, shell: u32, met: u32, shells: u32, far: f32, slot: u32, i: u32) {
    if shell < met {
        put(chord, shell, shells, far, slot, i);
    }
}
#walker
