// The records of a subgroup's step with a digit: who has an equal one a small subgroup finds by a shuffle for each
// invocation, a large one by a ballot for each bit.
#import radix

// Invocations with the digit of this one, how many of them come before it, and the first.
struct Equals {
    all: u32,
    before: u32,
    first: u32,
}

// Invocations without a record have a digit of their own.
fn equals_of(digit: u32, present: bool, lane: u32) -> Equals {
    var found = Equals(0u, 0u, SUBGROUP);
    if SUBGROUP >= MOST_SHUFFLED {
        var equal = subgroupBallot(present).x;
        for (var bits = push.mask; bits != 0u; bits &= bits - 1u) {
            let bit = bits & (~bits + 1u);
            let holders = subgroupBallot((digit & bit) != 0u).x;
            equal &= select(~holders, holders, (digit & bit) != 0u);
        }
        found = Equals(countOneBits(equal), countOneBits(equal & ((1u << lane) - 1u)), firstTrailingBit(equal));
    } else {
#repeat         let other{i} = subgroupShuffle(digit, {i}u);
#repeat         found.all += select(0u, 1u, other{i} == digit);
#repeat         found.before += select(0u, 1u, other{i} == digit && {i}u < lane);
#repeat         found.first = select(found.first, min(found.first, {i}u), other{i} == digit);
    }
    return found;
}
