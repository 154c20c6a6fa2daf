// Merge sort of up to CAPACITY fragments in an array of the invocation's own: blocks by a network in registers, then
// bottom-up merging between the two halves of the array. The last two runs are merged as they are taken. CAPACITY, a
// multiple of BLOCK, is a text constant, since overrides cannot size local arrays; BLOCK is the size of the variant's
// network.
#import fragments

alias List = ptr<function, array<vec2<u32>, 2u * CAPACITY>>;

// State of merging two sorted runs: the indices of their next entries, the ends of the runs, and these entries.
struct Place {
    a: u32,
    middle: u32,
    b: u32,
    end: u32,
    first: vec2<u32>,
    second: vec2<u32>,
}

// The runs from `start` to `middle`, and from there to `end`, which may be none.
fn merging(list: List, start: u32, middle: u32, end: u32) -> Place {
    return Place(start, middle, middle, end, (*list)[start], (*list)[middle]);
}

// Takes the next entry. Without branches, and with one read for each entry: neither run's next entry is read twice.
fn taken(list: List, place: ptr<function, Place>) -> vec2<u32> {
    let p = *place;
    let of_second = (p.a >= p.middle) | ((p.b < p.end) & before(p.second, p.first));
    let next = select(p.a, p.b, of_second) + 1u;
    // Beyond the end of a run comes what is never taken.
    let entry = (*list)[min(next, 2u * CAPACITY - 1u)];
    (*place).a = select(next, p.a, of_second);
    (*place).b = select(p.b, next, of_second);
    (*place).first = select(entry, p.first, of_second);
    (*place).second = select(p.second, entry, of_second);
    return select(p.first, p.second, of_second);
}

fn sort_block(list: List, start: u32) {
#repeat     var x{i} = (*list)[start + {i}u];
#comparators
#repeat     (*list)[start + {i}u] = x{i};
}

// Sorts list[0 .. n], of which `taken` gives one entry after another.
fn sort_local(list: List, n: u32) -> Place {
    let padded = (n + BLOCK - 1u) / BLOCK * BLOCK;
    for (var i = n; i < padded; i++) {
        // Behind everything, and never read again.
        (*list)[i] = vec2<u32>(0xffffffffu);
    }
    for (var start = 0u; start < n; start += BLOCK) {
        sort_block(list, start);
    }
    var source = 0u;
    var width = BLOCK;
    for (; 2u * width < n; width *= 2u) {
        let destination = CAPACITY - source;
        for (var start = 0u; start < n; start += 2u * width) {
            let end = min(start + 2u * width, n);
            var place = merging(list, source + start, source + min(start + width, n), source + end);
            for (var k = start; k < end; k++) {
                (*list)[destination + k] = taken(list, &place);
            }
        }
        source = destination;
    }
    return merging(list, source, source + min(width, n), source + n);
}
