// raster/quad.vert: two triangles over each splat's rectangle of pixels; six pulled vertices per splat, no vertex
// buffer. Vertices lie on pixel corners, so that exactly the rectangle's pixels get a fragment, and all samples of
// them.
#import camera
#import splat

@group(0) @binding(3) var<storage, read> bounds: array<Bounds>;

struct Vertex {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) splat: u32,
}

@vertex
fn main(@builtin(vertex_index) vertex: u32) -> Vertex {
    view = camera;
    let i = vertex / 6u;
    let corner = vertex % 6u;
    let rect = bounds[i];
    let low = vec2<f32>(bounds_min(rect));
    let high = vec2<f32>(bounds_max(rect));
    let right = corner == 1u || corner == 2u || corner == 4u;
    let lower = corner == 2u || corner == 4u || corner == 5u;
    let pixel = select(low, high, vec2<bool>(right, lower)) - vec2<f32>(view.window.xy);
    let size = vec2<f32>(view.window.zw - view.window.xy);
    // An empty rectangle makes triangles without area.
    return Vertex(vec4<f32>(pixel / size * 2.0 - 1.0, 0.5, 1.0), i);
}
