// Sums the moments of a pixel's fragments.
#import twofloat
#import fade
#import moment

// Beyond far.
const NO_PLACE = 2.0;

#each moment var<private> moment{moment}: vec2<f32>;
var<private> nearest: f32;

// Of no fragment, or where the pixel has a place, of those of earlier runs.
fn begin_moments(pixel: vec2<u32>) {
#each moment     moment{moment} = vec2<f32>(0.0);
    nearest = NO_PLACE;
    if is_later() && all(pixel < view.window.zw) {
        let first = window_index(pixel, view.window) * STRIDE;
#each moment         moment{moment} = known[first + {moment}u];
        nearest = known[first + MOMENTS + 1u].x;
    }
}

// With a fragment that has some opacity.
fn add_moments(f: Fragment) {
    let place = place_of(f);
    nearest = min(nearest, place);
    var term = vec2<f32>(optical_depth(f.color.a), 0.0);
#each moment     moment{moment} = add2(moment{moment}, term); term = multiply2(term, vec2<f32>(place, 0.0));
}

fn leave_moments(pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        let first = window_index(pixel, view.window) * STRIDE;
#each moment         known[first + {moment}u] = moment{moment};
        known[first + MOMENTS + 1u] = vec2<f32>(nearest, 0.0);
    }
}
