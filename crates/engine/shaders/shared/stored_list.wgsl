// A list that was sorted where it lies: where it begins among the band's fragments.
alias SortedList = u32;

fn listed(list: SortedList, i: u32) -> vec2<u32> {
    return fragments[list + i];
}
