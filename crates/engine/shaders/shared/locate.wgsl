// Where a point lies on the screen: the one statement of the projection, in two-float arithmetic.
#import camera
#import twofloat

// Beyond any image, and with a square that stays finite.
const HUGE = 1e18;

// A vector in camera axes, each component a sum of two floats.
fn in_camera(v: array<vec2<f32>, 3>) -> array<vec2<f32>, 3> {
    return array<vec2<f32>, 3>(
        dot2(v, axis(view.right, view.right_lo)),
        dot2(v, axis(view.down, view.down_lo)),
        dot2(v, axis(view.forward, view.forward_lo)),
    );
}

fn axis(hi: vec4<f32>, lo: vec4<f32>) -> array<vec2<f32>, 3> {
    return array<vec2<f32>, 3>(vec2<f32>(hi.x, lo.x), vec2<f32>(hi.y, lo.y), vec2<f32>(hi.z, lo.z));
}

fn minus_eye(hi: vec3<f32>, lo: vec3<f32>) -> array<vec2<f32>, 3> {
    return array<vec2<f32>, 3>(
        add2(vec2<f32>(hi.x, lo.x), -vec2<f32>(view.eye_hi.x, view.eye_lo.x)),
        add2(vec2<f32>(hi.y, lo.y), -vec2<f32>(view.eye_hi.y, view.eye_lo.y)),
        add2(vec2<f32>(hi.z, lo.z), -vec2<f32>(view.eye_hi.z, view.eye_lo.z)),
    );
}

// A normal in camera axes.
fn turned(n: vec3<f32>) -> array<vec2<f32>, 3> {
    return in_camera(array<vec2<f32>, 3>(vec2<f32>(n.x, 0.0), vec2<f32>(n.y, 0.0), vec2<f32>(n.z, 0.0)));
}

fn rounded(v: array<vec2<f32>, 3>) -> vec3<f32> {
    return vec3<f32>(v[0].x, v[1].x, v[2].x);
}

// Pixel of a screen coordinate relative to the image's middle, the fraction within it, and what rounding took from
// that.
struct Screen {
    pixel: i32,
    fraction: f32,
    rest: f32,
}

fn on_screen(relative: vec2<f32>, size: u32, shift: f32) -> Screen {
    // An even image's middle is a border of pixels, an odd one's lies half a pixel in.
    let shifted = add2(relative, vec2<f32>(0.5 * f32(size % 2u) + shift, 0.0));
    let whole = clamp(floor(shifted.x), -16000.0, 16000.0);
    var within = add2(shifted, vec2<f32>(-whole, 0.0));
    var screen = Screen(i32(whole), within.x, 0.0);
    if within.x < 0.0 && whole > -16000.0 {
        within = add2(within, vec2<f32>(1.0, 0.0));
        screen.pixel -= 1;
        screen.fraction = within.x;
    }
    screen.pixel += i32(size / 2u);
    // Rounded up to the next pixel, it would lie in none.
    if screen.fraction == 1.0 {
        screen.fraction = 0.99999994;
    }
    screen.rest = (within.x - screen.fraction) + within.y;
    return screen;
}

// A point's center before the camera and on the screen.
struct Located {
    // Between near and far, and not so far out that arithmetic ends; NaN is not drawn.
    drawn: bool,
    // In camera axes.
    place: array<vec2<f32>, 3>,
    // Pixels from where the viewing axis meets the image.
    center: vec2<f32>,
    // Pixels over a world unit at its depth.
    scale: f32,
    column: Screen,
    row: Screen,
}

// hi + lo is the position minus the cloud's origin.
fn locate(hi: vec3<f32>, lo: vec3<f32>) -> Located {
    let place = in_camera(minus_eye(hi, lo));
    let depth = place[2].x;
    var scale = view.focal;
    if view.orthographic == 0u {
        scale = divide2(view.focal, place[2]);
    }
    let x = multiply2(place[0], scale);
    let y = multiply2(place[1], scale);
    let within = depth >= view.depth_range.x && depth <= view.depth_range.y;
    let drawn = within && abs(x.x) <= HUGE && abs(y.x) <= HUGE;
    let column = on_screen(x, view.size.x, view.shift.x);
    let row = on_screen(y, view.size.y, view.shift.y);
    return Located(drawn, place, vec2<f32>(x.x, y.x), scale.x, column, row);
}
