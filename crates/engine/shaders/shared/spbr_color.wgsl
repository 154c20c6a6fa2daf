// Colors as whole numbers, so that sums of them are the same in any order.
fn whole_color(color: vec3<f32>) -> vec3<u32> {
    return vec3<u32>(clamp(color * push.scale + 0.5, vec3<f32>(0.0), vec3<f32>(push.most)));
}
