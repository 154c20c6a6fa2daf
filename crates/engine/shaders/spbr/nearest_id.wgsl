// spbr/nearest-id: among the points at the smallest depth the one of the smallest index. Second of two passes.
#import spbr
#import nearest
#walker
@group(0) @binding(6) var<storage, read_write> nearest: array<NearestAtomic>;

fn visit(point: u32, plane: u32, depth: u32, pixel: u32) {
    let place = plane * push.pixels + pixel;
    if ~depth == atomicLoad(&nearest[place].key) {
        atomicMax(&nearest[place].id, ~(push.list + point));
    }
}
