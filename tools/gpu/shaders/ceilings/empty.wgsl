// ceilings/empty: does nothing that takes time. One invocation for each word.
#import dispatch

@group(0) @binding(0) var<storage, read_write> words: array<u32>;
#push

#main i {
    if i < push.count {
        words[i] = i;
    }
}
