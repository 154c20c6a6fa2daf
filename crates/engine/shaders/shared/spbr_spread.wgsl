// Goes through slots as spbr_slots does, where the invocations of a workgroup share the pixels of its squares. Each
// step adds up the areas of WG_SIZE squares, and the n-th pixel of all of them goes to an invocation that finds its
// square among the sums. The invocations of a GPU would wait for the one with the largest square. Those in doubt are
// few, and walked alone.
#import spbr_squares

const SECOND = WG_SIZE;

// Of a step's squares: sums of areas up to and with each, twice, since invocations read one and write the other.
var<workgroup> ends: array<u32, 2u * WG_SIZE>;
// Point, plane, depth key and first pixel.
var<workgroup> squares_of: array<vec4<u32>, WG_SIZE>;
var<workgroup> columns_of: array<u32, WG_SIZE>;

// Sums up areas, and shows all invocations what the others have written. WG_SIZE is a power of four, so that the last
// sums are in the first half.
fn add_up(local: u32, area: u32) {
    ends[local] = area;
    workgroupBarrier();
    var half = 0u;
    for (var distance = 1u; distance < WG_SIZE; distance *= 2u) {
        var sum = ends[half + local];
        if local >= distance {
            sum += ends[half + local - distance];
        }
        half = SECOND - half;
        ends[half + local] = sum;
        workgroupBarrier();
    }
}

// The square of the n-th of a step's pixels.
fn square_at(n: u32) -> u32 {
    var square = 0u;
    for (var step = WG_SIZE / 2u; step > 0u; step /= 2u) {
        square += select(0u, step, ends[square + step - 1u] <= n);
    }
    return square;
}

fn show_squares(local: u32) {
    let width = view.window.z - view.window.x;
    let total = ends[WG_SIZE - 1u];
    for (var n = local; n < total; n += WG_SIZE) {
        let square = square_at(n);
        let within = n - select(0u, ends[max(square, 1u) - 1u], square > 0u);
        let columns = columns_of[square];
        let row = quotient(within, columns);
        let found = squares_of[square];
        visit(found.x, found.y, found.z, found.w + row * width + within - row * columns);
    }
}

#main {
    view = camera;
    let start = workgroup_index(workgroup, groups) * WG_SIZE * RUN + local;
    var visible = 0u;
    var unsure = 0u;
    for (var k = 0u; k < RUN; k++) {
        let n = start + k * WG_SIZE;
        var area = 0u;
        if n < push.count {
            let slot = slot_of(n);
            let hit = quick_hit(slot);
            if hit.seen {
                visible += 1u;
                let size = vec2<u32>(hit.high - hit.low);
                if size.x * size.y > SMALL_SQUARE {
                    list_square(slot, hit);
                } else {
                    area = size.x * size.y;
                    let first = window_index(vec2<u32>(hit.low), view.window);
                    squares_of[local] = vec4<u32>(slot.point, slot.plane, hit.key, first);
                    columns_of[local] = size.x;
                }
            }
            unsure |= u32(hit.unsure) << k;
        }
        add_up(local, area);
        show_squares(local);
        // The next step writes what this one reads.
        workgroupBarrier();
    }
    count_visible(visible + show_unsure(start, unsure));
}
