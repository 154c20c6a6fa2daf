// points/nearest-id: among the points at a pixel's smallest depth the one of the smallest index. Second of two passes.
#import points
#import nearest
@group(0) @binding(6) var<storage, read_write> nearest: array<NearestAtomic>;

// The first pass has counted the points.
fn visit(i: u32, hit: Hit) -> u32 {
    if hit.key == atomicLoad(&nearest[hit.pixel].key) {
        atomicMin(&nearest[hit.pixel].id, i);
    }
    return 0u;
}
