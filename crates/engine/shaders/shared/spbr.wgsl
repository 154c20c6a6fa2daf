// Shared by the passes of stochastic point-based rendering: bindings, where a slot's point shows and how large, and
// the key by which the nearest of an ensemble is found. A pass defines visit(place of a point, its plane, depth key,
// pixel of the window); a walker (spbr_slots, spbr_large) calls it for each pixel that a drawn point covers.
#import elementary
#import locate
#import splat
#import dispatch
#import random

struct Counters {
    // Points that were drawn, 64 bits.
    visible_low: atomic<u32>,
    visible_high: atomic<u32>,
    // Large squares of a dispatch.
    large: atomic<u32>,
    spare: u32,
}

// Positions minus the cloud's origin as sums of two floats; in the fourth of the second the opacity.
@group(0) @binding(1) var<storage, read> points_hi: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> points_lo: array<vec4<f32>>;
// A single one if there are none.
@group(0) @binding(3) var<storage, read> normals: array<vec4<f32>>;
// From which random words follow.
@group(0) @binding(4) var<storage, read> ids: array<u32>;
@group(0) @binding(5) var<storage, read_write> counters: array<Counters>;
// Two vectors for each square of more than SMALL_SQUARE pixels: place, plane and depth key of its point; columns and
// rows.
@group(0) @binding(6) var<storage, read_write> large: array<vec4<u32>>;
#push

// 0: every point asks for the whole pixel; 1: its opacity says how much of it.
override WEIGHTED: u32 = 0u;
// 0: every point is drawn, since each asks for a pixel.
override THINNED: u32 = 1u;
// 1: less of it where the normal is slanted.
override SLANTED: u32 = 0u;
// 1: a later pass, whose ensembles take blocks of points from rows (src/prepare/ensembles.rs).
override AGAIN: u32 = 0u;
// 0: a round has a single ensemble.
override PLANES: u32 = 1u;
// 0: no point is wider than a pixel.
override SQUARES: u32 = 1u;

// Error that float32 leaves on the screen, as in shared/points.wgsl.
const ERROR = 12.0 / 16777216.0;
// Far beyond any image.
const WIDEST = 1e6;

// A slot of the round.
struct Slot {
    // Place of its point among what is bound.
    point: u32,
    // Its ensemble among those of the round.
    plane: u32,
}

// a / b for a quotient below 2^22. CPUs divide whole numbers one by one.
fn quotient(a: u32, b: u32) -> u32 {
    let about = u32(f32(a) / f32(b));
    let rest = i32(a - about * b);
    return select(select(about, about + 1u, rest >= i32(b)), about - 1u, rest < 0);
}

// First slot of an ensemble of the round.
fn first_slot(plane: u32) -> u32 {
    return plane * push.whole + quotient(push.carry + plane * push.rest, push.ensembles);
}

fn slot_of(n: u32) -> Slot {
    let plane = plane_of(push.first + n);
    if AGAIN == 0u {
        return Slot(push.base + n, plane);
    }
    return Slot(point_again(push.first + n - first_slot(plane), push.hand + plane), plane);
}

// The n-th point of the h-th ensemble of a later pass.
fn point_again(n: u32, hand: u32) -> u32 {
    let row = n >> push.block_bits;
    let word = scrambled(push.pass_word + row * 0x9E3779B9u) >> 10u;
    var column = hand + word - quotient(word, push.columns) * push.columns;
    column -= select(0u, push.columns, column >= push.columns);
    let block = (row * push.columns + column) << push.block_bits;
    let along = push.start + block + (n & ((1u << push.block_bits) - 1u));
    return push.base + along - select(0u, push.around, along >= push.around);
}

// lowbias32 of C. Wellons.
fn scrambled(word: u32) -> u32 {
    var x = (word ^ (word >> 16u)) * 0x7feb352du;
    x = (x ^ (x >> 15u)) * 0x846ca68bu;
    return x ^ (x >> 16u);
}

// The ensemble of a slot, among those of the round.
fn plane_of(slot: u32) -> u32 {
    if PLANES == 0u {
        return 0u;
    }
    // The last ensemble that begins at or before the slot: right apart from rounding, which two comparisons mend.
    let size = f32(push.whole) + f32(push.rest) / f32(push.ensembles);
    let about = (f32(slot) + 1.0 - f32(push.carry + 1u) / f32(push.ensembles)) / size;
    var plane = min(u32(max(about, 0.0)), push.planes - 1u);
    if first_slot(plane) > slot {
        plane -= 1u;
    }
    if plane + 1u < push.planes && first_slot(plane + 1u) <= slot {
        plane += 1u;
    }
    return plane;
}

struct Hit {
    // On at least one pixel of the rectangle in work.
    seen: bool,
    // Too near to a pixel's border for float32; seen says nothing then.
    unsure: bool,
    key: u32,
    // Columns and rows, half-open, within the rectangle in work.
    low: vec2<i32>,
    high: vec2<i32>,
}

// ln(1 - x), also for small x (Kahan).
fn log_rest(x: f32) -> f32 {
    let rest = 1.0 - x;
    let moved = rest - 1.0;
    return select(logarithm(rest) * (-x / moved), -x, moved == 0.0);
}

// Pixels that a point asks for at its depth, `from_eye` being its place relative to the eye in the world's axes.
fn area_of(point: u32, from_eye: vec3<f32>, depth: f32) -> f32 {
    var area = 1.0;
    if view.orthographic == 0u {
        let zoom = push.depth / depth;
        area = zoom * zoom;
    }
    if WEIGHTED != 0u {
        let opacity = min(points_lo[point].w * view.opacity_factor, 1.0);
        // An opaque point asks for more than there is.
        let part = select(-log_rest(opacity) / push.unit, 1.0, opacity >= 1.0);
        area *= select(min(part, 1.0), 1.0, push.unit == 0.0 && opacity > 0.0);
    }
    if SLANTED != 0u {
        let normal = normals[point].xyz;
        let to_eye = select(from_eye, view.forward.xyz, view.orthographic != 0u);
        let across = abs(dot3(normal, to_eye));
        let length = sqrt(dot3(normal, normal) * dot3(to_eye, to_eye));
        area *= select(1.0, min(across / length, 1.0), length > 0.0);
    }
    return area;
}

// True if a point that asks for less than a pixel gets it in an ensemble: Tanaka et al. leave out points at random.
fn is_drawn(slot: Slot, area: f32) -> bool {
    if THINNED == 0u {
        return true;
    }
    let counter = vec2<u32>(ids[slot.point], push.ensemble + slot.plane);
    let word = threefry2x32(counter, vec2<u32>(push.key_x, push.key_y)).x;
    return area >= 1.0 || word < u32(area * 4294967296.0);
}

// Half the side of the square that a point covers: at least half a pixel.
fn half_side(area: f32) -> f32 {
    if SQUARES == 0u {
        return 0.5;
    }
    return clamp(0.5 * sqrt(area), 0.5, WIDEST);
}

// Where a slot's point shows, without doubt.
fn exact_hit(slot: Slot) -> Hit {
    let point = locate(points_hi[slot.point].xyz, points_lo[slot.point].xyz);
    let depth = point.place[2].x;
    let from_eye = rounded(minus_eye(points_hi[slot.point].xyz, points_lo[slot.point].xyz));
    let area = area_of(slot.point, from_eye, depth);
    let half = half_side(area);
    let center = vec2<f32>(f32(point.column.pixel), f32(point.row.pixel));
    let fraction = vec2<f32>(point.column.fraction, point.row.fraction);
    // The pixels whose centers lie in (center - half, center + half]: for half a pixel the one that holds the center.
    let low = max(center + floor(fraction + (0.5 - half)), vec2<f32>(view.window.xy));
    let high = min(center + floor(fraction + (0.5 + half)), vec2<f32>(view.window.zw));
    let seen = point.drawn && all(low < high) && is_drawn(slot, area);
    return Hit(seen, false, depth_key(depth), vec2<i32>(low), vec2<i32>(high));
}

// The same in less time for most points: only the depth takes two-float arithmetic, as in locate.
fn quick_hit(slot: Slot) -> Hit {
    let from_eye = minus_eye(points_hi[slot.point].xyz, points_lo[slot.point].xyz);
    let depth = dot2(from_eye, axis(view.forward, view.forward_lo)).x;
    let place = rounded(from_eye);
    let scale = view.focal.x / select(1.0, depth, view.orthographic == 0u);
    // Pixels from the image's middle.
    let odd = 0.5 * vec2<f32>(view.size % 2u) + view.shift;
    let at = vec2<f32>(dot3(place, view.right.xyz), dot3(place, view.down.xyz)) * scale + odd;
    let area = area_of(slot.point, place, depth);
    let half = half_side(area);
    let reach = abs(place);
    let error = ERROR * ((reach.x + reach.y + reach.z) * scale + 1.0 + half);
    let begin = at + (0.5 - half);
    let end = at + (0.5 + half);
    let whole_begin = floor(begin);
    let whole_end = floor(end);
    let sure = clear_of_borders(begin - whole_begin, error) && clear_of_borders(end - whole_end, error);
    let middle = vec2<f32>(view.size / 2u);
    let window_low = vec2<f32>(view.window.xy) - middle;
    let window_high = vec2<f32>(view.window.zw) - middle;
    let low = max(whole_begin, window_low);
    let high = min(whole_end, window_high);
    let within = depth >= view.depth_range.x && depth <= view.depth_range.y && is_drawn(slot, area);
    let outside = any(end + error < window_low) || any(begin - error > window_high);
    let seen = within && sure && all(low < high);
    return Hit(seen, within && !outside && !sure, depth_key(depth), vec2<i32>(low + middle), vec2<i32>(high + middle));
}

fn clear_of_borders(fraction: vec2<f32>, error: f32) -> bool {
    return all(fraction > vec2<f32>(error)) && all(fraction < vec2<f32>(1.0 - error));
}

// Low and high word of what the nearest point of an ensemble has most of: epoch, and the complements of depth key and
// index. The newer an epoch, the more it is, so that a plane needs no clearing while there are epochs left; 0 stands
// for nothing.
fn key_words(point: u32, depth: u32) -> vec2<u32> {
    let near = ~depth;
    let index = ~(push.list + point) & (0xffffffffu >> push.epoch_bits);
    return vec2<u32>(((near << 1u) << (31u - push.epoch_bits)) | index, push.epoch | (near >> push.epoch_bits));
}
