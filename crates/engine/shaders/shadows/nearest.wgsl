// shadows/nearest: the smallest depth of each pixel of a light's image, by atomic minimum of its key; all ones at the
// start.
#import every_point
@group(0) @binding(4) var<storage, read_write> nearest: array<atomic<u32>>;

fn visit(i: u32, hit: Hit) -> u32 {
    atomicMin(&nearest[hit.pixel], hit.key);
    return 0u;
}
