// Reaching the splats of fragments while composing: color and opacity by index.
#import elementary
#import splat
#import over

// Splats' colors (linear or encoded RGB, opacity) and footprints. A binding is limited (128 MiB on lavapipe), so each
// array is bound as four parts of PART_LENGTH elements.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> colors_0: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> colors_1: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> colors_2: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> colors_3: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> splats_0: array<Splat>;
@group(0) @binding(6) var<storage, read> splats_1: array<Splat>;
@group(0) @binding(7) var<storage, read> splats_2: array<Splat>;
@group(0) @binding(8) var<storage, read> splats_3: array<Splat>;
@group(0) @binding(9) var<storage, read> tilts_0: array<Tilt>;
@group(0) @binding(10) var<storage, read> tilts_1: array<Tilt>;
@group(0) @binding(11) var<storage, read> tilts_2: array<Tilt>;
@group(0) @binding(12) var<storage, read> tilts_3: array<Tilt>;

override PARTS: u32 = 1u;
override PART_LENGTH: u32 = 1u;
override FALLOFF: u32 = 0u;

fn color_at(i: u32) -> vec4<f32> {
    if PARTS == 1u {
        return colors_0[i];
    }
    let k = i % PART_LENGTH;
    switch i / PART_LENGTH {
        case 0u: { return colors_0[k]; }
        case 1u: { return colors_1[k]; }
        case 2u: { return colors_2[k]; }
        default: { return colors_3[k]; }
    }
}

fn splat_at(i: u32) -> Splat {
    if PARTS == 1u {
        return splats_0[i];
    }
    let k = i % PART_LENGTH;
    switch i / PART_LENGTH {
        case 0u: { return splats_0[k]; }
        case 1u: { return splats_1[k]; }
        case 2u: { return splats_2[k]; }
        default: { return splats_3[k]; }
    }
}

fn tilt_at(i: u32) -> Tilt {
    if !has_tilts() {
        return Tilt(vec4<f32>(0.0));
    }
    if PARTS == 1u {
        return tilts_0[i];
    }
    let k = i % PART_LENGTH;
    switch i / PART_LENGTH {
        case 0u: { return tilts_0[k]; }
        case 1u: { return tilts_1[k]; }
        case 2u: { return tilts_2[k]; }
        default: { return tilts_3[k]; }
    }
}

// Color and opacity of a splat's fragment in a pixel.
fn fragment_color(i: u32, pixel: vec2<u32>) -> vec4<f32> {
    var color = color_at(i);
    if FALLOFF == FALLOFF_GAUSSIAN {
        let rho = cover(splat_at(i), tilt_at(i), pixel, view).rho;
        color.a *= gaussian(rho);
    }
    return color;
}
