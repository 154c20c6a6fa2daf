// The points by their index, whatever their number, and the colors that they are blended with.
#import locate
#import shade

// The points, each array in four parts of PART_LENGTH elements as in shared/compose.wgsl.
@group(0) @binding(1) var<storage, read> points_hi_0: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> points_hi_1: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> points_hi_2: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> points_hi_3: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read> points_lo_0: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read> points_lo_1: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read> points_lo_2: array<vec4<f32>>;
@group(0) @binding(8) var<storage, read> points_lo_3: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> point_colors_0: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read> point_colors_1: array<vec4<f32>>;
@group(0) @binding(11) var<storage, read> point_colors_2: array<vec4<f32>>;
@group(0) @binding(12) var<storage, read> point_colors_3: array<vec4<f32>>;
@group(0) @binding(13) var<storage, read> normals_0: array<vec4<f32>>;
@group(0) @binding(14) var<storage, read> normals_1: array<vec4<f32>>;
@group(0) @binding(15) var<storage, read> normals_2: array<vec4<f32>>;
@group(0) @binding(16) var<storage, read> normals_3: array<vec4<f32>>;

override PARTS: u32 = 1u;
override PART_LENGTH: u32 = 1u;

fn hi_at(i: u32) -> vec3<f32> {
    if PARTS == 1u {
        return points_hi_0[i].xyz;
    }
    let k = i % PART_LENGTH;
    switch i / PART_LENGTH {
        case 0u: { return points_hi_0[k].xyz; }
        case 1u: { return points_hi_1[k].xyz; }
        case 2u: { return points_hi_2[k].xyz; }
        default: { return points_hi_3[k].xyz; }
    }
}

// The rest of the position, and the opacity.
fn lo_at(i: u32) -> vec4<f32> {
    if PARTS == 1u {
        return points_lo_0[i];
    }
    let k = i % PART_LENGTH;
    switch i / PART_LENGTH {
        case 0u: { return points_lo_0[k]; }
        case 1u: { return points_lo_1[k]; }
        case 2u: { return points_lo_2[k]; }
        default: { return points_lo_3[k]; }
    }
}

fn color_at(i: u32) -> vec3<f32> {
    if PARTS == 1u {
        return point_colors_0[i].xyz;
    }
    let k = i % PART_LENGTH;
    switch i / PART_LENGTH {
        case 0u: { return point_colors_0[k].xyz; }
        case 1u: { return point_colors_1[k].xyz; }
        case 2u: { return point_colors_2[k].xyz; }
        default: { return point_colors_3[k].xyz; }
    }
}

// The normal, and the share of light.
fn normal_at(i: u32) -> vec4<f32> {
    if PARTS == 1u {
        return normals_0[i];
    }
    let k = i % PART_LENGTH;
    switch i / PART_LENGTH {
        case 0u: { return normals_0[k]; }
        case 1u: { return normals_1[k]; }
        case 2u: { return normals_2[k]; }
        default: { return normals_3[k]; }
    }
}

fn color_of(i: u32) -> vec3<f32> {
    let color = color_at(i);
    if SHADING == SHADING_NONE {
        return blended_color(color, vec3<f32>(0.0), vec3<f32>(0.0));
    }
    let position = rounded(in_camera(minus_eye(hi_at(i), lo_at(i).xyz)));
    let normal = normal_at(i);
    return lit_color(color, position, rounded(turned(normal.xyz)), normal.w);
}
