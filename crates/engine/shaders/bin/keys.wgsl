// bin/keys: a record for the sort of each point of a chunk: the key of its splat, and its index. Splats that are not
// drawn come last. One invocation per point.
#import splat
#import dispatch

@group(0) @binding(0) var<storage, read> splat_depths: array<f32>;
@group(0) @binding(1) var<storage, read> bounds: array<Bounds>;
// Red, green, blue, and where in the files the point stood.
@group(0) @binding(2) var<storage, read> points: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> records: array<vec2<u32>>;
#push

override ORDER: u32 = 0u;

fn key(i: u32) -> u32 {
    if ORDER == ORDER_DEPTH {
        return min(depth_key(splat_depths[i]) - push.nearest, push.none - 1u);
    }
    if ORDER == ORDER_INDEX {
        return 0u;
    }
    if ORDER == ORDER_FILE {
        // The last one of the files comes first.
        return push.none - 1u - points[i].w;
    }
    return points[i].w;
}

#main i {
    if i >= push.count {
        return;
    }
    let drawn = any(bounds[i] != vec2<u32>(0u));
    records[push.first + i] = vec2<u32>(select(push.none, key(i), drawn), push.first + i);
}
