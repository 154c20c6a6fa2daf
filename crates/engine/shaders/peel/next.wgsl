// peel/next: after a layer without a fragment there is no further one: every dispatch and draw still recorded becomes
// empty. One invocation.
#import peel_work

@group(0) @binding(0) var<storage, read_write> work: PeelWork;
// Indirect arguments, four words each; the first is the number of workgroups in x, or of vertices.
@group(0) @binding(1) var<storage, read_write> arguments: array<u32>;

@compute @workgroup_size(1)
fn main() {
    if atomicLoad(&work.found) == 1u {
        atomicStore(&work.found, 0u);
        work.layers += 1u;
        return;
    }
    for (var i = 0u; i < arrayLength(&arguments); i += 4u) {
        arguments[i] = 0u;
    }
}
