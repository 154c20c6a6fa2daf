// image-space/fill: a background pixel takes the values of the nearest around it, unless five consecutive neighbors are
// background too: then it lies beyond a silhouette. One workgroup per listed tile. Reference:
// reference::image_space::Layer::filled.
#import holes

const LARGEST = 3.4028234e38;

fn is_looked_at(depth: f32) -> bool {
    return is_background(depth);
}

fn floor_of(depth: f32) -> f32 {
    return LARGEST;
}
