// All points take part, and nobody counts them.
#import walk_points

fn is_kept(i: u32, place: vec3<f32>) -> bool {
    return true;
}

fn is_behind(hit: Hit) -> bool {
    return true;
}

fn is_counted() -> bool {
    return false;
}
