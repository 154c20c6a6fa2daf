// A sorted list in an array of the invocation's own.
alias SortedList = ptr<function, array<vec2<u32>, 2u * CAPACITY>>;

fn listed(list: SortedList, i: u32) -> vec2<u32> {
    return (*list)[i];
}
