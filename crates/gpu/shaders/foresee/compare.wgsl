// foresee/compare: whether words that the device counted are at most what the host took for granted. One invocation per
// word; go is set to 0 if one is more.
#import dispatch

@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<storage, read> most: array<u32>;
@group(0) @binding(2) var<storage, read_write> go: array<atomic<u32>>;
#push

#main i {
    if i < push.count && words[i] > most[i] {
        atomicStore(&go[0], 0u);
    }
}
