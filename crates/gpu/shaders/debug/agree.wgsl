// debug/agree: whether the words that a pass left are what was counted. One invocation per word; found holds the number
// of words that aren't, and place, word and count of up to TOLD of them. Recorded in debug builds alone.
#import dispatch

@group(0) @binding(0) var<storage, read_write> found: array<atomic<u32>>;
@group(0) @binding(1) var<storage, read> stored: array<u32>;
@group(0) @binding(2) var<storage, read> ends: array<u32>;
@group(0) @binding(3) var<storage, read> counts: array<u32>;
#push

#main i {
    if i >= push.count {
        return;
    }
    let word = stored[push.stored_first + i * push.stride];
    let end = ends[push.ends_first + i * push.stride];
    let below = end - select(0u, counts[push.counts_first + i * push.stride], push.mode == BELOW);
    let counted = select(push.value, below, push.mode <= BELOW);
    if word != counted {
        let place = atomicAdd(&found[0], 1u);
        if place < TOLD {
            atomicStore(&found[1u + 3u * place], i);
            atomicStore(&found[2u + 3u * place], word);
            atomicStore(&found[3u + 3u * place], counted);
        }
    }
}
