// Reaching every splat by its index, however many there are.
#import splat
#import view

// Splats' colors (linear or encoded RGB, opacity) and footprints. A binding is limited (128 MiB on lavapipe), so each
// array is bound as four parts of PART_LENGTH elements.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> colors_0: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> colors_1: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> colors_2: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> colors_3: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> splats_0: array<PackedSplat>;
@group(0) @binding(6) var<storage, read> splats_1: array<PackedSplat>;
@group(0) @binding(7) var<storage, read> splats_2: array<PackedSplat>;
@group(0) @binding(8) var<storage, read> splats_3: array<PackedSplat>;
@group(0) @binding(9) var<storage, read> splat_depths_0: array<f32>;
@group(0) @binding(10) var<storage, read> splat_depths_1: array<f32>;
@group(0) @binding(11) var<storage, read> splat_depths_2: array<f32>;
@group(0) @binding(12) var<storage, read> splat_depths_3: array<f32>;
@group(0) @binding(13) var<storage, read> tilts_0: array<vec4<f32>>;
@group(0) @binding(14) var<storage, read> tilts_1: array<vec4<f32>>;
@group(0) @binding(15) var<storage, read> tilts_2: array<vec4<f32>>;
@group(0) @binding(16) var<storage, read> tilts_3: array<vec4<f32>>;

override PARTS: u32 = 1u;
override PART_LENGTH: u32 = 1u;

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

// Without its depth.
fn packed_at(i: u32) -> PackedSplat {
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

fn depth_at(i: u32) -> f32 {
    if PARTS == 1u {
        return splat_depths_0[i];
    }
    let k = i % PART_LENGTH;
    switch i / PART_LENGTH {
        case 0u: { return splat_depths_0[k]; }
        case 1u: { return splat_depths_1[k]; }
        case 2u: { return splat_depths_2[k]; }
        default: { return splat_depths_3[k]; }
    }
}

fn splat_at(i: u32) -> Splat {
    return unpack_splat(packed_at(i), depth_at(i));
}

fn tilt_at(i: u32) -> Tilt {
    if !has_tilts() {
        return no_tilt();
    }
    if tilt_stride() == 1u {
        return Tilt(tilt_element(i, 0u), vec4<f32>(0.0));
    }
    return Tilt(tilt_element(i, 0u), tilt_element(i, 1u));
}

fn tilt_element(i: u32, which: u32) -> vec4<f32> {
    if PARTS == 1u {
        return tilts_0[tilt_stride() * i + which];
    }
    let k = tilt_stride() * (i % PART_LENGTH) + which;
    switch i / PART_LENGTH {
        case 0u: { return tilts_0[k]; }
        case 1u: { return tilts_1[k]; }
        case 2u: { return tilts_2[k]; }
        default: { return tilts_3[k]; }
    }
}
