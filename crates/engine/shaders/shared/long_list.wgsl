// Lists of more than RUN_LENGTH fragments are worked on in runs of that length by many invocations.

// One run of one long list.
struct ListRun {
    // The list's first fragment in the band's buffer, and its length.
    start: u32,
    length: u32,
    // Number of the run within the list.
    run: u32,
    pixel: u32,
}

// Indirect arguments of the passes over runs and over lists, each followed by its count; and of those that give a
// workgroup to each run.
struct LongWork {
    run_groups: array<u32, 3>,
    run_count: atomic<u32>,
    list_groups: array<u32, 3>,
    list_count: atomic<u32>,
    whole_groups: array<u32, 3>,
    unused: u32,
}

// A long list: its pixel, and its runs in the list of runs.
struct LongList {
    pixel: u32,
    first_run: u32,
    runs: u32,
}

// One run composed: premultiplied color and A, and in x the key of what it shows (shared/over.wgsl).
struct Partial {
    rgba: vec4<f32>,
    key: vec4<u32>,
}
