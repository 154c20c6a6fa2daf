// image-space/occlusion: a pixel takes the values of the nearest around it, unless five consecutive neighbors lie no more
// than d~ before it: then it is not seen through a hole. One workgroup per listed tile. Reference:
// reference::image_space::Layer::occluded_replaced.
#import holes

fn is_looked_at(depth: f32) -> bool {
    return !is_background(depth);
}

fn floor_of(depth: f32) -> f32 {
    return depth - p.distance;
}
