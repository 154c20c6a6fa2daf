// A run of GROUP_RUN elements in the hands of a workgroup, which goes through it in steps: in each every invocation has
// four elements in a row, and its neighbors those beside them, so that a step reads a stretch of memory. The stage
// binds `values`.
#import dispatch

#push
// Sums of the invocations, and of each ROW of them.
var<workgroup> lanes: array<u32, WG_SIZE>;
var<workgroup> rows: array<u32, ROWS>;
// True once a sum was over 32 bits.
var<private> carried: bool = false;

const STEPS = GROUP_RUN / (4u * WG_SIZE);
const FOURS = GROUP_RUN / 4u;
const ROW = 8u;
const ROWS = WG_SIZE / ROW;

fn plus(a: u32, b: u32) -> u32 {
    let sum = a + b;
    carried = carried || sum < a;
    return sum;
}

fn first_of_four(run: u32, step: u32, local: u32) -> u32 {
    return run * GROUP_RUN + 4u * (step * WG_SIZE + local);
}

fn value_at(i: u32) -> u32 {
    return select(0u, values[min(i, push.count - 1u)], i < push.count);
}

fn sum_of_four(run: u32, step: u32, local: u32) -> u32 {
    let first = first_of_four(run, step, local);
    let sum = plus(value_at(first), value_at(first + 1u));
    return plus(plus(sum, value_at(first + 2u)), value_at(first + 3u));
}

// Sums each row of `lanes`, in which each invocation is left with the sum of those before it.
fn sum_rows(own: u32, local: u32) {
    lanes[local] = own;
    workgroupBarrier();
    if local < ROWS {
        var sum = 0u;
        var i = local * ROW;
        loop {
            let lane = lanes[i];
            lanes[i] = sum;
            sum = plus(sum, lane);
            i += 1u;
            if i == (local + 1u) * ROW {
                break;
            }
        }
        rows[local] = sum;
    }
    workgroupBarrier();
}
