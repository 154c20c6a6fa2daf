// Finds, of what is at each pixel's smallest depth, the smallest index. Second of two passes.
#import nearest
@group(0) @binding(NEAREST_BINDING) var<storage, read_write> nearest: array<NearestAtomic>;

// As in shared/nearest_wide.
fn offer(pixel: u32, key: u32, id: u32) -> u32 {
    if key == atomicLoad(&nearest[pixel].key) {
        atomicMin(&nearest[pixel].id, id);
    }
    return 0u;
}
