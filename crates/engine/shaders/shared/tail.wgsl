// The tail of `hybrid`: the fragments behind the last one that is composed exactly, and those that are too faint for
// that, wherever they lie. The stage binds `lasts`, and has a push constant `core_alpha_min`.
#import rank

// Rank of the last fragment in front of the tail.
var<private> front_end: Rank;

fn is_in_tail(f: Fragment) -> bool {
    return f.color.a > 0.0 && (f.color.a < push.core_alpha_min || before(front_end, rank_of(f)));
}
