// A whole splat as stages take it that go through tiles, and the fragment that it leaves in a pixel.
#import elementary
#import tile_run
#import falloff

// A splat as it is handed from lane to lane.
struct Handed {
    // Its pixel is there only for its own lane.
    splat: Splat,
    // From the corner in work to the pixel of the center; once handed over, from that to the invocation's first pixel.
    whole: vec2<f32>,
    tilt: Tilt,
    color: vec4<f32>,
    index: u32,
}

// A splat by its index. Loads of what a stage does not use are left out.
fn whole_splat(i: u32, corner: vec2<u32>) -> Handed {
    let splat = splat_at(i);
    return Handed(splat, -whole_to(splat, corner), tilt_at(i), color_at(i), i);
}

// The numbers of lane k's splat that its shape has.
fn handed_tilt(own: Tilt, k: u32) -> Tilt {
    var tilt = no_tilt();
    if is_rectangle() {
        tilt.normal.x = subgroupShuffle(own.normal.x, k);
        tilt.normal.y = subgroupShuffle(own.normal.y, k);
        tilt.normal.z = subgroupShuffle(own.normal.z, k);
    }
    if may_tilt() {
        tilt.normal.w = subgroupShuffle(own.normal.w, k);
    }
    if tilt_stride() == 2u {
        tilt.rest = vec4<f32>(
            subgroupShuffle(own.rest.x, k), subgroupShuffle(own.rest.y, k),
            subgroupShuffle(own.rest.z, k), subgroupShuffle(own.rest.w, k),
        );
    }
    return tilt;
}

// That of lane k to an invocation whose first pixel lies at `first` from the corner in work; without `present` it
// covers no pixel.
fn handed(own: Handed, k: u32, present: bool, first: vec2<f32>) -> Handed {
    let tilt = handed_tilt(own.tilt, k);
    let color = vec4<f32>(
        subgroupShuffle(own.color.r, k), subgroupShuffle(own.color.g, k),
        subgroupShuffle(own.color.b, k), subgroupShuffle(own.color.a, k),
    );
    let index = subgroupShuffle(own.index, k);
    var splat = handed_splat(own.splat, k);
    if is_rectangle() {
        // No ray meets the plane of a tilted disc exactly where its center is not.
        splat.radius = select(0.0, splat.radius, present);
    }
    return Handed(splat, handed_whole(own.whole, k, present, first), tilt, color, index);
}

// A splat in a pixel; what a stage does not read costs nothing.
struct Fragment {
    hit: bool,
    // Linear or encoded RGB, and the opacity here: 0 where the splat misses the pixel.
    color: vec4<f32>,
    depth_key: u32,
    // That of the depth that shows.
    shown_key: u32,
    // The splat's, in canonical order: what breaks ties of depth.
    index: u32,
    // Distance from the splat's center over its radius, at most 1 but in a square's corners; and that radius in world
    // units.
    rho: f32,
    radius: f32,
}

// In the invocation's pixel, `further` along from its first one.
fn fragment_of(h: Handed, further: vec2<u32>, pixel: vec2<u32>) -> Fragment {
    let coverage = cover_from(h.splat, h.tilt, h.whole + vec2<f32>(further), pixel, tile_lens);
    let hit = coverage.hit;
    var c = h.color;
    c.a = select(0.0, fallen(h.splat, c.a, coverage.rho), hit);
    let depth = select(h.splat.depth, coverage.depth, may_cross());
    let shown = depth_key(shown_depth(h.splat, h.tilt, depth));
    let distance = select(h.splat.depth + view.eye_hi.w, 1.0, view.orthographic != 0u);
    return Fragment(hit, c, depth_key(depth), shown, h.index, coverage.rho, h.splat.radius * (distance / view.focal.x));
}
