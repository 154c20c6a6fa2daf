// hybrid/accumulate for oriented discs, whose order differs from pixel to pixel: the nearest fragments are kept in a
// few slots by insertion, and what falls out of them is the tail. Where k is larger than the number of slots, further
// rounds keep the nearest of those behind the last one of the round before, and only the last round has a tail.
// Fragments that are too faint for the slots go to the tail at once (HTGS, Hahlbohm et al. 2025).
// Reference: reference::approximate::hybrid.
#import splat
#import tile_state
#import rank
#import region_fold

// Rank of the last fragment that earlier rounds composed.
@group(0) @binding(23) var<storage, read_write> lasts: array<vec2<u32>>;
// State that a run leaves to the next: that rank, and rank and color of each slot.
@group(0) @binding(24) var<storage, read_write> slots: array<vec4<u32>>;
#push

// 1: earlier rounds left a front in the image.
override BEHIND: u32 = 0u;
// 1: the round that has a tail.
override TAIL: u32 = 0u;

struct Slot {
    rank: Rank,
    color: vec4<f32>,
}

// The nearest fragments of this round, in order.
struct Slots {
    last: Rank,
#each slot     slot{slot}: Slot,
}

var<private> state: State;
var<private> nearest: Slots;

// The second if `second`.
fn either(a: Slot, b: Slot, second: bool) -> Slot {
    return Slot(select(a.rank, b.rank, second), select(a.color, b.color, second));
}

fn empty_slots() -> Slots {
    var s: Slots;
    s.last = Rank(0u, 0u);
#each slot     s.slot{slot} = Slot(NO_RANK, vec4<f32>(0.0));
    return s;
}

fn kept_slots(p: u32) -> Slots {
    let first = p * (1u + 2u * SLOTS);
    var s: Slots;
    s.last = slots[first].xy;
#each slot     s.slot{slot} = Slot(slots[first + 1u + 2u * {slot}u].xy, bitcast<vec4<f32>>(slots[first + 2u + 2u * {slot}u]));
    return s;
}

fn keep_slots(p: u32, s: Slots) {
    let first = p * (1u + 2u * SLOTS);
    slots[first] = vec4<u32>(s.last, 0u, 0u);
#each slot     slots[first + 1u + 2u * {slot}u] = vec4<u32>(s.slot{slot}.rank, 0u, 0u);
#each slot     slots[first + 2u + 2u * {slot}u] = bitcast<vec4<u32>>(s.slot{slot}.color);
}

fn begin(pixel: vec2<u32>) {
    state = empty_state();
    nearest = empty_slots();
    if all(pixel < view.window.zw) {
        let p = window_index(pixel, view.window);
        if is_later() {
            state = kept_state(p);
            nearest = kept_slots(p);
        } else if BEHIND != 0u {
            state = behind_front(p);
            nearest.last = lasts[p];
        }
    }
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    var s = nearest;
    let rank = rank_of(f);
    let faint = f.color.a < push.core_alpha_min;
    // The first round has no last fragment.
    let taken = f.hit && !faint && (BEHIND == 0u || before(s.last, rank));
    // Slots are in order: from the first one behind the fragment on, each takes what was in the one before.
    let found = Slot(select(NO_RANK, rank, taken), vec4<f32>(f.color.rgb, select(0.0, f.color.a, taken)));
    var carried = found;
    var moved = false;
#each slot     let here{slot} = s.slot{slot};
#each slot     let moves{slot} = before(found.rank, here{slot}.rank);
#each slot     s.slot{slot} = either(here{slot}, either(found, carried, moved), moves{slot}); moved = moves{slot}; carried = here{slot};
    carried = either(found, carried, moved);
    if TAIL != 0u {
        // One that is too faint moved nothing; one that misses the pixel has no opacity.
        let left = select(carried.color, f.color, faint);
        state.sum = plus(state.sum, left.a * vec4<f32>(left.rgb, 1.0));
        state.coverage = covered(state.coverage, left.a);
    }
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
    var front = state.front;
    var last = s.last;
#each slot     front += (1.0 - front.a) * s.slot{slot}.color.a * vec4<f32>(s.slot{slot}.color.rgb, 1.0);
#each slot     last = s.slot{slot}.rank;
    if TAIL == 0u {
        lasts[p] = last;
    }
    let tail = state.coverage.x * vec4<f32>(mean(state.sum), 1.0);
    leave(p, state, front + (1.0 - front.a) * tail);
}
