// A list that was sorted where it lies among the band's fragments, and the place of what comes next in it.
alias List = u32;
alias Place = u32;

// Takes the next entry.
fn taken(list: List, place: ptr<function, Place>) -> vec2<u32> {
    let entry = fragments[list + *place];
    *place += 1u;
    return entry;
}
