// Declarations that all stages of `wavelet` share. The depths of a pixel, from the nearest to the farthest, are cut
// into CELLS - 1 cells of equal ratios, and the last edge begins one more. Haar wavelets of all levels down to that of
// cells know the mean of a function over each cell, no more and no less. So stages keep the means: of the optical depth
// before a place, a fragment of depth a adds a to all cells behind its own, and to its own what is behind it there.
// That is two sums for each fragment, in which nothing cancels.
#push

// Depths of the nearest and the farthest fragment of a pixel, and the logarithm of their ratio.
struct Range {
    nearest: f32,
    farthest: f32,
    span: f32,
}

fn range_of(depths: vec2<f32>) -> Range {
    let farthest = max(depths.x, depths.y);
    return Range(depths.x, farthest, log_ratio(depths.x, farthest));
}

// Where a fragment lies, in cells.
fn place_in(range: Range, f: Fragment) -> f32 {
    let way = log_ratio(range.nearest, clamp(seen_depth(f), range.nearest, range.farthest));
    return f32(CELLS - 1u) * select(0.0, min(way / range.span, 1.0), range.span > 0.0);
}
