// A sorted list in an array of the invocation's own, and the place of what comes next in it.
alias List = ptr<function, array<vec2<u32>, CAPACITY>>;
alias Place = u32;

// Takes the next entry.
fn taken(list: List, place: ptr<function, Place>) -> vec2<u32> {
    let entry = (*list)[*place];
    *place += 1u;
    return entry;
}
