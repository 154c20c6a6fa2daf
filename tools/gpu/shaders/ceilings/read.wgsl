// ceilings/read: reads of 8 bytes, `rounds` for each invocation: of neighbors one after the other, or with ANY at any
// place.
#import dispatch

override ANY: u32 = 0u;

@group(0) @binding(0) var<storage, read> pairs: array<vec2<u32>>;
@group(0) @binding(1) var<storage, read_write> ends: array<u32>;
#push

#main i {
    if i >= push.count {
        return;
    }
    var hash = i * 0x9e3779b9u;
    var kept = 0u;
    for (var round = 0u; round < push.rounds; round++) {
        hash = (hash ^ (hash >> 15u)) * 0x2c1b3c6du + round;
        let place = select(round * push.count + i, hash ^ (hash >> 16u), ANY == 1u) & push.mask;
        let pair = pairs[place];
        kept ^= pair.x ^ pair.y;
    }
    ends[i] = kept;
}
