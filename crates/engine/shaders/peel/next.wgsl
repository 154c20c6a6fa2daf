// peel/next: after a walk that found fewer layers than it could there is no further one: every dispatch and draw still
// recorded becomes empty. One invocation.
#import peel_work

@group(0) @binding(0) var<storage, read_write> work: PeelWork;
// Indirect arguments, four words each; the first is the number of workgroups in x, or of vertices.
@group(0) @binding(1) var<storage, read_write> arguments: array<u32>;
// Layers that a walk can find.
override SLOTS: u32 = 1u;

@compute @workgroup_size(1)
fn main() {
    let found = atomicLoad(&work.found);
    work.layers += found;
    // Empty walks that follow find nothing to add.
    atomicStore(&work.found, 0u);
    if found == SLOTS {
        return;
    }
    for (var i = 0u; i < arrayLength(&arguments); i += 4u) {
        arguments[i] = 0u;
    }
}
