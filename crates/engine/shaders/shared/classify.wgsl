// Shared by the two passes over the lengths of a band's lists. One invocation looks at CLASSIFY_RUN pixels.
#import classes
#import dispatch

@group(0) @binding(0) var<storage, read> offsets: array<u32>;
@group(0) @binding(1) var<storage, read_write> classes: array<atomic<u32>>;
#push

// First pixel of an invocation and one past its last.
fn run_of(invocation: u32) -> vec2<u32> {
    let first = push.band_start + invocation * CLASSIFY_RUN;
    return vec2<u32>(first, min(first + CLASSIFY_RUN, push.band_end));
}

fn class_at(p: u32) -> u32 {
    return class_of(offsets[p + 1u] - offsets[p]);
}

// How many pixels from the first on, in steps, are in each class; the last element counts those without fragments.
fn count_classes(first: u32, step: u32, end: u32) -> array<u32, CLASS_COUNT + 1u> {
    var found: array<u32, CLASS_COUNT + 1u>;
    for (var c = 0u; c <= CLASS_COUNT; c++) {
        found[c] = 0u;
    }
    for (var p = first; p < end; p += step) {
        found[class_at(p)] += 1u;
    }
    return found;
}
