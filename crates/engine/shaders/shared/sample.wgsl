// A sample of a deep EXR: color times opacity, and opacity.
const NO_SAMPLE = -1.0;

// A sample of a color, or one of the opacity NO_SAMPLE, which stands for none.
fn sample_of(color: vec4<f32>, is_there: bool) -> vec4<f32> {
    return vec4<f32>(color.a * color.rgb, select(NO_SAMPLE, color.a, is_there));
}
