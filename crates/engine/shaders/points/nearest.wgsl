// points/nearest, points/nearest-depth, points/nearest-id: depth and index of each pixel's nearest point.
#import points
#piece

const NEAREST_BINDING = 6;

fn visit(i: u32, hit: Hit) -> u32 {
    return offer(hit.pixel, hit.key, i);
}
