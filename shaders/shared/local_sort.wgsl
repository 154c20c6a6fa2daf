// Merge sort of up to CAPACITY fragments in an array of the invocation's own: runs of four by insertion, then bottom-up
// merging between the two halves of the array. CAPACITY is a text constant, since overrides cannot size local arrays.
#import fragments

// Sorts list[0 .. n]; returns where the sorted run begins: 0 or CAPACITY.
fn sort_local(list: ptr<function, array<vec2<u32>, 2u * CAPACITY>>, n: u32) -> u32 {
    for (var start = 0u; start < n; start += 4u) {
        let end = min(start + 4u, n);
        for (var i = start + 1u; i < end; i++) {
            let moved = (*list)[i];
            var j = i;
            while j > start && before(moved, (*list)[j - 1u]) {
                (*list)[j] = (*list)[j - 1u];
                j--;
            }
            (*list)[j] = moved;
        }
    }
    var source = 0u;
    for (var width = 4u; width < n; width *= 2u) {
        let target_start = CAPACITY - source;
        for (var start = 0u; start < n; start += 2u * width) {
            let middle = min(start + width, n);
            let end = min(start + 2u * width, n);
            var a = start;
            var b = middle;
            for (var k = start; k < end; k++) {
                let take_a = b >= end || (a < middle && !before((*list)[source + b], (*list)[source + a]));
                if take_a {
                    (*list)[target_start + k] = (*list)[source + a];
                    a++;
                } else {
                    (*list)[target_start + k] = (*list)[source + b];
                    b++;
                }
            }
        }
        source = target_start;
    }
    return source;
}
