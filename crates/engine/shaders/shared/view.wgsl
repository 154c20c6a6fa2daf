// The camera and the part of the image in work. Camera axes: x right, y down, z forward.
struct View {
    // Axes as sums of two floats. In w of `right` the number of shells of a soft sphere at most. In w of `down` the
    // pixels of its radius for each, 0 where every sphere has as many. In w of `forward` the share of light at which
    // lists with Gaussians end, 0 for none.
    right: vec4<f32>,
    right_lo: vec4<f32>,
    down: vec4<f32>,
    down_lo: vec4<f32>,
    forward: vec4<f32>,
    forward_lo: vec4<f32>,
    // Eye minus the cloud's origin as a sum of two floats.
    // In w the depth that those of splats are relative to: 0, or, where spheres are blended, one that no point is
    // nearer than, since the less depths are, the more digits they have. And near relative to it.
    eye_hi: vec4<f32>,
    eye_lo: vec4<f32>,
    // To the light (w = 0) or the light's place relative to the eye (w = 1), in camera axes.
    light: vec4<f32>,
    // Ambient, diffuse, specular, shininess.
    material: vec4<f32>,
    // The rectangle in work: first column, first row, one past the last column and row.
    window: vec4<u32>,
    // Columns and rows of the whole image.
    size: vec2<u32>,
    // Pixels over a world unit at depth 1 (perspective) or anywhere (orthographic), as a sum of two floats.
    focal: vec2<f32>,
    // Near and far.
    depth_range: vec2<f32>,
    // Factor on the radius, and largest radius in pixels; a factor below 0: every radius is the largest.
    radius_limits: vec2<f32>,
    orthographic: u32,
    // Factor on opacities.
    opacity_factor: f32,
    // Threshold of the field: up to it points are solid, above it soft.
    threshold: f32,
    // Field from which soft points are as transparent as the model says (Seemann et al., l_m); not above the threshold:
    // all.
    modulation: f32,
    // Splats of at most this many pixels are walked by one invocation; larger ones tile by tile.
    small_area: u32,
    // Of Gaussians: KERNEL_ and ORDER_ of their fragments.
    kernel: u32,
    order: u32,
    // 1: discs lie in their tangent planes, where Gaussians are in the scene.
    tilted: u32,
    // Of Gaussians: least and most opacity of a fragment, and what is added to the variances on the screen, in square
    // pixels; 1 in the last: opacity is less by as much as that adds.
    gaussian: vec4<f32>,
    // Where quarters of pixels are drawn, the place of the sample in one of even column and row; in z how much farther
    // that of odd ones lies; in w how far samples lie from the middle at most (shared/sample_place.wgsl).
    sample: vec4<f32>,
    // Pixels by which projected positions are moved, in x and y.
    shift: vec2<f32>,
    padding: vec2<f32>,
}

// Place of a pixel in the buffers of the rectangle in work.
fn window_index(pixel: vec2<u32>, window: vec4<u32>) -> u32 {
    return (pixel.y - window.y) * (window.z - window.x) + pixel.x - window.x;
}
