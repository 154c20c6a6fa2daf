// A whole splat as stages take it that go through tiles, and the fragment that it leaves in a pixel.
#import elementary
#import tile_run

// 1: a run goes on from the result of earlier ones, wherever the stage keeps that.
override LATER: u32 = 0u;
override FALLOFF: u32 = 0u;

// A splat as it is handed from lane to lane.
struct Handed {
    // Its pixel is there only for its own lane.
    splat: Splat,
    // From the corner in work to the pixel of the centre; once handed over, from that to the invocation's first pixel.
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

// That of lane k to an invocation whose first pixel lies at `first` from the corner in work; without `present` it covers no
// pixel.
fn handed(own: Handed, k: u32, present: bool, first: vec2<f32>) -> Handed {
    var tilt = Tilt(vec4<f32>(0.0));
    if SHAPE == SHAPE_ORIENTED {
        tilt.normal = vec4<f32>(
            subgroupShuffle(own.tilt.normal.x, k), subgroupShuffle(own.tilt.normal.y, k),
            subgroupShuffle(own.tilt.normal.z, k), subgroupShuffle(own.tilt.normal.w, k),
        );
    }
    let color = vec4<f32>(
        subgroupShuffle(own.color.r, k), subgroupShuffle(own.color.g, k),
        subgroupShuffle(own.color.b, k), subgroupShuffle(own.color.a, k),
    );
    let index = subgroupShuffle(own.index, k);
    var splat = handed_splat(own.splat, k);
    if SHAPE == SHAPE_ORIENTED {
        // No ray meets the plane of a tilted disc exactly where its centre is not.
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
    // The splat's, in canonical order: what breaks ties of depth.
    index: u32,
    // Distance from the splat's centre over its radius, at most 1 but in a square's corners; and that radius in world units.
    rho: f32,
    radius: f32,
}

// In the invocation's pixel, `further` along from its first one.
fn fragment_of(h: Handed, further: vec2<u32>, pixel: vec2<u32>) -> Fragment {
    let coverage = cover_from(h.splat, h.tilt, h.whole + vec2<f32>(further), pixel, view);
    let hit = coverage.hit;
    var c = h.color;
    if FALLOFF == FALLOFF_GAUSSIAN {
        c.a *= gaussian(coverage.rho);
    }
    c.a = select(0.0, c.a, hit);
    let key = depth_key(select(h.splat.depth, coverage.depth, SHAPE == SHAPE_ORIENTED));
    let distance = select(h.splat.depth + view.eye_hi.w, 1.0, view.orthographic != 0u);
    return Fragment(hit, c, key, h.index, coverage.rho, h.splat.radius * (distance / view.focal.x));
}
