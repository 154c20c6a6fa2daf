// abuffer/resolve-N, N from 128, first half where invocations share work: sorts the lists of a class where they lie. A
// workgroup takes those of its invocations one after another.
#import classes
#import group_sort
#import dispatch

@group(0) @binding(0) var<storage, read> offsets: array<u32>;
@group(0) @binding(1) var<storage, read> classes: array<u32>;
@group(0) @binding(2) var<storage, read> pixels: array<u32>;
@group(0) @binding(3) var<storage, read_write> fragments: array<vec2<u32>>;
#push

#main item {
    let word = push.class_index * CLASS_WORDS;
    var own = vec2<u32>(0u);
    if item < classes[word + CLASS_TOTAL] {
        let p = pixels[classes[word + CLASS_START] + item];
        own = vec2<u32>(offsets[p] - push.first_fragment, offsets[p + 1u] - offsets[p]);
    }
    for (var owner = 0u; owner < WG_SIZE; owner++) {
        if local == owner {
            range = own;
        }
        sort_range(local);
    }
}
