// What the strata of stochastic transparency leave in a pixel: X = w C_p, and Y = w A_p or, without alpha correction, w;
// w is the share of a stratum's samples that were asked for.
struct MomentsPush {
    // Columns and pixels of the window.
    width: u32,
    count: u32,
    // This stratum, from 1 on.
    stratum: u32,
    // Its samples that count.
    samples: u32,
    // Sum of w over the strata up to this one, over their number.
    weight: f32,
    corrected: u32,
    // Of held depths.
    base: u32,
    shift: u32,
}
