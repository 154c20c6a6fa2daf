// moments/gather: the moments of each pixel's optical depth over places (Münstermann et al. 2018).
// Reference: reference::moments::power_moments.
#import splat
#import region_fold
#import moment_sums

@group(0) @binding(20) var<storage, read_write> known: array<vec2<f32>>;
#push

fn begin(pixel: vec2<u32>) {
    begin_moments(pixel);
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    // Nothing changes nothing, not even how a sum is spread over its two floats.
    if f.color.a > 0.0 {
        add_moments(f);
    }
}

fn finish(pixel: vec2<u32>) {
    leave_moments(pixel);
}
