// wavelet/gather: what each pixel's fragments add to the mean optical depths of its cells. Reference:
// reference::wavelet::Absorption.
#import splat
#import region_fold
#import fade
#import cell

@group(0) @binding(20) var<storage, read> ranges: array<vec2<f32>>;
// Sums for each cell, and by how much they are too large.
@group(0) @binding(21) var<storage, read_write> cells: array<vec2<f32>>;

var<private> range: Range;
// The pixel's first cell.
var<private> first: u32;

fn begin(pixel: vec2<u32>) {
    if any(pixel >= view.window.zw) {
        return;
    }
    let p = window_index(pixel, view.window);
    range = range_of(ranges[p]);
    first = p * CELLS;
    if !is_later() {
        for (var k = 0u; k < CELLS; k++) {
            cells[first + k] = vec2<f32>(0.0);
        }
    }
}

// As shared/sums.
fn add(cell: u32, term: f32) {
    let sum = cells[first + cell];
    let wanted = term - sum.y;
    let total = sum.x + wanted;
    cells[first + cell] = vec2<f32>(total, (total - sum.x) - wanted);
}

fn visit(pixel: vec2<u32>, f: Fragment) {
    if f.color.a > 0.0 && all(pixel < view.window.zw) {
        let place = place_in(range, f);
        let cell = min(u32(place), CELLS - 1u);
        let depth = optical_depth(f.color.a);
        let behind = depth * (place - f32(cell));
        add(cell, depth - behind);
        if behind > 0.0 && cell + 1u < CELLS {
            add(cell + 1u, behind);
        }
    }
}

fn finish(pixel: vec2<u32>) {
}
