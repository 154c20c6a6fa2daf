// ceilings/wide: minima of 64-bit words, `rounds` for each invocation, each at any place: what finds nearest points.
#import dispatch

@group(0) @binding(0) var<storage, read_write> words: array<atomic<u64>>;
#push

#main i {
    if i >= push.count {
        return;
    }
    var hash = i * 0x9e3779b9u;
    for (var round = 0u; round < push.rounds; round++) {
        hash = (hash ^ (hash >> 15u)) * 0x2c1b3c6du + round;
        atomicMin(&words[(hash ^ (hash >> 16u)) & push.mask], (u64(hash) << 32u) | u64(i));
    }
}
