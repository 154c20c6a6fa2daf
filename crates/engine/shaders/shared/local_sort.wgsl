// Merge sort of up to CAPACITY fragments in an array of the invocation's own: blocks by a network in registers, then
// bottom-up merging between the two halves of the array. CAPACITY, a multiple of BLOCK, is a text constant, since overrides
// cannot size local arrays; BLOCK is the size of the variant's network.
#import fragments

fn sort_block(list: ptr<function, array<vec2<u32>, 2u * CAPACITY>>, start: u32) {
#repeat     var x{i} = (*list)[start + {i}u];
#comparators
#repeat     (*list)[start + {i}u] = x{i};
}

// Sorts list[0 .. n]; returns where the sorted run begins: 0 or CAPACITY.
fn sort_local(list: ptr<function, array<vec2<u32>, 2u * CAPACITY>>, n: u32) -> u32 {
    let padded = (n + BLOCK - 1u) / BLOCK * BLOCK;
    for (var i = n; i < padded; i++) {
        // Behind everything, and never read again.
        (*list)[i] = vec2<u32>(0xffffffffu);
    }
    for (var start = 0u; start < n; start += BLOCK) {
        sort_block(list, start);
    }
    var source = 0u;
    for (var width = BLOCK; width < n; width *= 2u) {
        let destination = CAPACITY - source;
        for (var start = 0u; start < n; start += 2u * width) {
            let middle = min(start + width, n);
            let end = min(start + 2u * width, n);
            var a = start;
            var b = middle;
            for (var k = start; k < end; k++) {
                let take_a = b >= end || (a < middle && !before((*list)[source + b], (*list)[source + a]));
                if take_a {
                    (*list)[destination + k] = (*list)[source + a];
                    a++;
                } else {
                    (*list)[destination + k] = (*list)[source + b];
                    b++;
                }
            }
        }
        source = destination;
    }
    return source;
}
