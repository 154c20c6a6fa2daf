// Shared by the passes that go through the spheres of the soft points and the pixels of their silhouettes.
#import raster
#import sphere

// 1: what lies behind the solid points is left out.
override CUT: u32 = 0u;
@group(0) @binding(8) var<storage, read> solids: array<f32>;

// Depth before which nothing is seen.
fn near_depth() -> f32 {
    return view.eye_lo.w;
}

// Depth of the solid point behind which nothing is seen.
fn solid_depth(p: u32) -> f32 {
    if CUT == 0u {
        return 3.4e38;
    }
    return solids[p];
}
