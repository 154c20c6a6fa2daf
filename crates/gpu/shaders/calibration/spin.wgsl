// calibration/spin: a fixed chain of integer operations, each of which needs the one before. One invocation per word,
// which takes the result, so that no compiler can leave the chain out.
#import dispatch

@group(0) @binding(0) var<storage, read_write> words: array<u32>;
#push

#main i {
    if i >= push.count {
        return;
    }
    var word = i;
    for (var step = 0u; step < push.steps; step++) {
        word = (word ^ (word >> 15u)) * 0x2c1b3c6du + step;
    }
    words[i] = word;
}
