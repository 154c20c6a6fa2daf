// hybrid/gather: the moments of each pixel's tail, as moments/gather finds those of all fragments.
// Reference: reference::moments::power_moments.
#import splat
#import region_fold
#import tail
#import moment_sums

@group(0) @binding(20) var<storage, read> lasts: array<vec2<u32>>;
@group(0) @binding(21) var<storage, read_write> known: array<vec2<f32>>;
#push

fn begin(pixel: vec2<u32>) {
    begin_moments(pixel);
    front_end = NO_RANK;
    if all(pixel < view.window.zw) {
        front_end = lasts[window_index(pixel, view.window)];
    }
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    if is_in_tail(f) {
        add_moments(f);
    }
}

fn finish(pixel: vec2<u32>) {
    leave_moments(pixel);
}
