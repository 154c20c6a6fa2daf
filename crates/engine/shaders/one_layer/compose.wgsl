// one-layer/compose: the layer of soft points over what is opaque, where it lies before the solid ones. One invocation
// per pixel. Opaque soft points lie behind the layer, so that the nearest of all that is opaque lies before the layer
// only if it is solid. Reference: reference::one_layer::Parts::blend.
#import dispatch

#push

@group(0) @binding(0) var<storage, read> layer: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read> layer_depths: array<f32>;
@group(0) @binding(2) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> depths: array<f32>;

@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(local_invocation_index) local: u32,
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let p = invocation_index(workgroup, groups, local);
    if p >= push.count || !(layer_depths[p] < depths[p]) {
        return;
    }
    let rest = image[p];
    // An opaque pixel stays opaque, to the bit.
    let alpha = select(push.softness, 1.0, rest.a > 0.0);
    image[p] = vec4<f32>(push.softness * layer[p].rgb + (1.0 - push.softness) * rest.rgb, alpha);
    if push.softness > 0.0 {
        depths[p] = layer_depths[p];
    }
}
