// image-space/occlusion: a pixel takes the values of the nearest around it, unless five consecutive neighbors lie no
// more than d~ before it: then it is not seen through a hole. One workgroup per listed tile. Reference:
// reference::image_space::Layer::occluded_replaced.
#import holes

fn is_looked_at(depth: f32) -> bool {
    return !is_background(depth);
}

// Below the depth itself, even where d~ is less than a unit of it in the last place: what is as near hides nothing.
fn floor_of(depth: f32) -> f32 {
    return min(depth - p.distance, key_depth(depth_key(depth) - 1u));
}
