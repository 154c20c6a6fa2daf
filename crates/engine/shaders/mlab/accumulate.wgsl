// mlab/accumulate: multi-layer alpha blending (Salvi, Vaidyanathan 2014). Fragments come in the order of the files. The
// nearest are kept in a few slots by insertion, and what falls out of them is merged into one last layer: before it, or
// behind it if it is farther than the nearest fragment of that layer. Reference: reference::mlab.
#import splat
#import tile_state
#import region_fold

// State that a run leaves to the next: the depth key of the last layer, then key and color of each slot.
@group(0) @binding(23) var<storage, read_write> slots: array<vec4<u32>>;
#push

struct Slot {
    key: u32,
    color: vec4<f32>,
}

struct Slots {
    // Key of the nearest fragment of the last layer, whose premultiplied color and A are the sum of the state.
    last: u32,
#each slot     slot{slot}: Slot,
}

var<private> state: State;
var<private> nearest: Slots;

// The second if `second`.
fn either(a: Slot, b: Slot, second: bool) -> Slot {
    return Slot(select(a.key, b.key, second), select(a.color, b.color, second));
}

// No fragment is nearer than key 0: what is there stays.
fn empty_slot(i: u32) -> Slot {
    return Slot(select(NOTHING, 0u, i < push.unused), vec4<f32>(0.0));
}

fn empty_slots() -> Slots {
    var s: Slots;
    s.last = NOTHING;
#each slot     s.slot{slot} = empty_slot({slot}u);
    return s;
}

fn kept_slots(p: u32) -> Slots {
    let first = p * (1u + 2u * SLOTS);
    var s: Slots;
    s.last = slots[first].x;
#each slot     s.slot{slot} = Slot(slots[first + 1u + 2u * {slot}u].x, bitcast<vec4<f32>>(slots[first + 2u + 2u * {slot}u]));
    return s;
}

fn keep_slots(p: u32, s: Slots) {
    let first = p * (1u + 2u * SLOTS);
    slots[first] = vec4<u32>(s.last, 0u, 0u, 0u);
#each slot     slots[first + 1u + 2u * {slot}u] = vec4<u32>(s.slot{slot}.key, 0u, 0u, 0u);
#each slot     slots[first + 2u + 2u * {slot}u] = bitcast<vec4<u32>>(s.slot{slot}.color);
}

fn begin(pixel: vec2<u32>) {
    state = empty_state();
    nearest = empty_slots();
    if is_later() && all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
        state = kept_state(p);
        nearest = kept_slots(p);
    }
}

// The last layer with a fragment before it or behind it: C + α (c - C), or C + (1 - A) α c. Both are small changes of a
// sum, so that a hundred thousand of them are.
fn merged(layer: Sum, color: vec4<f32>, before: bool) -> Sum {
    let present = vec4<f32>(color.rgb, 1.0);
    let in_front = (present - layer.total) + layer.excess;
    let through = (1.0 - layer.total.a) + layer.excess.a;
    return plus(layer, color.a * select(through * present, in_front, before));
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    var s = nearest;
    // Splats without opacity, and those that miss the pixel, yield no fragment.
    let found = Slot(select(NOTHING, f.depth_key, f.color.a > 0.0), f.color);
    // Slots are in order: from the first one that is not nearer on, each takes what was in the one before.
    var carried = found;
    var moved = false;
#each slot     let here{slot} = s.slot{slot};
#each slot     let moves{slot} = found.key <= here{slot}.key;
#each slot     s.slot{slot} = either(here{slot}, either(found, carried, moved), moves{slot}); moved = moves{slot}; carried = here{slot};
    carried = either(found, carried, moved);
    state.sum = merged(state.sum, carried.color, carried.key <= s.last);
    s.last = min(s.last, carried.key);
    state.coverage = covered(state.coverage, f.color.a);
    state = nearer(state, f);
    nearest = s;
}

fn finish(pixel: vec2<u32>) {
    if any(pixel >= view.window.zw) {
        return;
    }
    let s = nearest;
    let p = window_index(pixel, view.window);
    if is_one_of_several() {
        keep_slots(p, s);
    }
    var front = vec4<f32>(0.0);
#each slot     front += (1.0 - front.a) * s.slot{slot}.color.a * vec4<f32>(s.slot{slot}.color.rgb, 1.0);
    leave(p, state, vec4<f32>((front + (1.0 - front.a) * state.sum.total).rgb, state.coverage.x));
}
