// An order of points that was made beforehand, in runs that a subgroup takes each.
#import dispatch

#push

// The point at a place of the order.
fn point_at(place: u32) -> u32 {
    return order[select(place, push.count - 1u - place, push.backward != 0u)];
}

fn is_drawn(rectangle: vec2<u32>) -> bool {
    return any(rectangle != vec2<u32>(0u));
}
