// moments/gather: the moments of each pixel's optical depth over places (Münstermann et al. 2018).
// Reference: reference::moments::power_moments.
#import splat
#import twofloat
#import region_fold
#import fade
#import moment

@group(0) @binding(20) var<storage, read_write> known: array<vec2<f32>>;

// Beyond far.
const NO_PLACE = 2.0;

#each moment var<private> moment{moment}: vec2<f32>;
var<private> nearest: f32;

fn begin(pixel: vec2<u32>) {
#each moment     moment{moment} = vec2<f32>(0.0);
    nearest = NO_PLACE;
    if LATER != 0u && all(pixel < view.window.zw) {
        let first = window_index(pixel, view.window) * STRIDE;
#each moment         moment{moment} = known[first + {moment}u];
        nearest = known[first + MOMENTS + 1u].x;
    }
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    // Nothing changes nothing, not even how a sum is spread over its two floats.
    if f.color.a > 0.0 {
        let place = place_of(f);
        nearest = min(nearest, place);
        var term = vec2<f32>(optical_depth(f.color.a), 0.0);
#each moment         moment{moment} = add2(moment{moment}, term); term = multiply2(term, vec2<f32>(place, 0.0));
    }
}

fn finish(pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        let first = window_index(pixel, view.window) * STRIDE;
#each moment         known[first + {moment}u] = moment{moment};
        known[first + MOMENTS + 1u] = vec2<f32>(nearest, 0.0);
    }
}
