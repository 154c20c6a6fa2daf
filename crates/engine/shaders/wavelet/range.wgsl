// wavelet/range: depths of the nearest and the farthest fragment of each pixel. Reference: reference::wavelet::places.
#import splat
#import region_fold
#import fade

#push

@group(0) @binding(20) var<storage, read_write> ranges: array<vec2<f32>>;

// Nearest and farthest of no fragment.
const NO_RANGE = vec2<f32>(3.4e38, 0.0);

var<private> range: vec2<f32>;

fn begin(pixel: vec2<u32>) {
    range = NO_RANGE;
    if is_later() && all(pixel < view.window.zw) {
        range = ranges[window_index(pixel, view.window)];
    }
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    if f.color.a > 0.0 {
        let depth = seen_depth(f);
        range = vec2<f32>(min(range.x, depth), max(range.y, depth));
    }
}

fn finish(pixel: vec2<u32>) {
    if all(pixel < view.window.zw) {
        ranges[window_index(pixel, view.window)] = range;
    }
}
