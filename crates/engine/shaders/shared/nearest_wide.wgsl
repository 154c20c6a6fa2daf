// Finds each pixel's nearest by one 64-bit atomic minimum of depth key and index; all ones at the start.
@group(0) @binding(NEAREST_BINDING) var<storage, read_write> nearest: array<atomic<u64>>;

// Offers something to a pixel. Returns 1 in the pass that meets all that is offered for the first time.
fn offer(pixel: u32, key: u32, id: u32) -> u32 {
    let rank = (u64(key) << 32u) | u64(id);
    // Most of what is offered in a dense cloud is not the nearest, and reading is cheaper than an atomic.
    if rank < atomicLoad(&nearest[pixel]) {
        atomicMin(&nearest[pixel], rank);
    }
    return 1u;
}
