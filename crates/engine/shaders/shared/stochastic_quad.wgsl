// Shared by the fragment shaders of stochastic transparency: the splat of a quad (raster/quad.vert) in a pixel.
#import elementary
#import camera
#import splat
#import falloff

@group(0) @binding(1) var<storage, read> splats: array<PackedSplat>;
@group(0) @binding(2) var<storage, read> tilts: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> bounds: array<Bounds>;
@group(0) @binding(4) var<storage, read> colors: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> splat_depths: array<f32>;
#push

struct QuadFragment {
    hit: bool,
    // Linear or encoded RGB, and the opacity here: 0 where the splat misses the pixel.
    color: vec4<f32>,
    depth_key: u32,
}

fn quad_fragment(i: u32, pixel: vec2<u32>) -> QuadFragment {
    var tilt = no_tilt();
    if has_tilts() {
        tilt.normal = tilts[tilt_stride() * i];
    }
    if tilt_stride() == 2u {
        tilt.rest = tilts[tilt_stride() * i + 1u];
    }
    let splat = unpack_splat(splats[i], splat_depths[i]);
    let coverage = cover(splat, tilt, pixel);
    var color = colors[i];
    color.a = fallen(splat, color.a, coverage.rho);
    color.a = select(0.0, color.a, coverage.hit);
    return QuadFragment(coverage.hit, color, depth_key(coverage.depth));
}
