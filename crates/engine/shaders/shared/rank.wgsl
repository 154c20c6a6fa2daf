// The order of a pixel's fragments, of which no two are equal: depth key, and index, which breaks ties.
alias Rank = vec2<u32>;
const NO_RANK = Rank(0xffffffffu, 0xffffffffu);

fn rank_of(f: Fragment) -> Rank {
    return Rank(f.depth_key, f.index);
}

fn before(a: Rank, b: Rank) -> bool {
    return a.x < b.x || (a.x == b.x && a.y < b.y);
}
