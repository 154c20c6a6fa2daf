// ceilings/atomic: additions to words, `rounds` for each invocation. PLACE says to which: 0 all to one word, 1 those
// of 32 neighbors to one, 2 each to any. With RETURNS the sums before are needed, and the next place waits for them.
#import dispatch

override PLACE: u32 = 0u;
override RETURNS: u32 = 0u;

@group(0) @binding(0) var<storage, read_write> words: array<atomic<u32>>;
@group(0) @binding(1) var<storage, read_write> ends: array<u32>;
#push

#main i {
    if i >= push.count {
        return;
    }
    var hash = select(i, i / 32u, PLACE == 1u) * 0x9e3779b9u;
    var kept = 0u;
    for (var round = 0u; round < push.rounds; round++) {
        hash = (hash ^ (hash >> 15u)) * 0x2c1b3c6du + round;
        let place = select((hash ^ (hash >> 16u)) & push.mask, 0u, PLACE == 0u);
        if RETURNS == 1u {
            let before = atomicAdd(&words[place], 1u);
            kept ^= before;
            // Never so large: nothing changes, but no compiler knows.
            hash += before >> 31u;
        } else {
            atomicAdd(&words[place], 1u);
        }
    }
    ends[i] = kept ^ hash;
}
