// Walker: one invocation per splat of a chunk walks its whole rectangle, at most view.small_area pixels.
#import dispatch

#main {
    view = camera;
    let i = invocation_index(workgroup, groups, local);
    if i >= push.count {
        return;
    }
    let rect = bounds[i];
    let low = bounds_min(rect);
    let high = bounds_max(rect);
    let extent = high - low;
    if extent.x * extent.y > view.small_area || !in_band(low, high) {
        return;
    }
    let splat = splat_of(i);
    let tilt = tilt_of(i);
    // One loop over both axes: invocations that run in step wait for the largest rectangle, not for the widest row of
    // each.
    var pixel = low;
    for (var k = extent.x * extent.y; k > 0u; k--) {
        visit(i, splat, tilt, pixel);
        pixel.x += 1u;
        if pixel.x == high.x {
            pixel = vec2<u32>(low.x, pixel.y + 1u);
        }
    }
}
