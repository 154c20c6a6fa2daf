// spbr/large: number of large squares to the arguments of an indirect dispatch. A single invocation.
#import folded
#push

struct Counters {
    visible_low: u32,
    visible_high: u32,
    large: u32,
    spare: u32,
}
@group(0) @binding(0) var<storage, read> counters: array<Counters>;
@group(0) @binding(1) var<storage, read_write> arguments: array<u32>;

@compute @workgroup_size(WG_SIZE)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u {
        let groups = folded(counters[0].large * push.stripes, push.most);
        arguments[0] = groups.x;
        arguments[1] = groups.y;
        arguments[2] = 1u;
    }
}
