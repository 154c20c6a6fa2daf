// Walker: the rasterizer visits the pixels of each splat's rectangle (raster/quad.vert); the same test decides.
@fragment
fn main(@builtin(position) position: vec4<f32>, @location(0) @interpolate(flat) i: u32) {
    view = camera;
    let corner = view.window.xy;
    visit(i, splat_of(i), tilt_of(i), vec2<u32>(position.xy) + corner);
}
