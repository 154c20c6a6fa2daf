// Sorts up to RUN_LENGTH fragments where they lie, by a workgroup in the memory that it shares: a bitonic network
// (Batcher 1968) over the next power of two.
#import fragments

// Of the list that is sorted: its first fragment, and how many it has.
var<workgroup> range: vec2<u32>;
var<workgroup> sorting: array<vec2<u32>, RUN_LENGTH>;

// Sorts the list at `range`, which one invocation has written. All invocations of the workgroup call it.
fn sort_range(local: u32) {
    let found = workgroupUniformLoad(&range);
    let n = min(found.y, RUN_LENGTH);
    var size = 1u;
    while size < n {
        size *= 2u;
    }
    for (var i = local; i < size; i += WG_SIZE) {
        // Padding comes behind all entries of the list, and is not written back.
        sorting[i] = select(vec2<u32>(0xffffffffu), fragments[found.x + min(i, n - 1u)], i < n);
    }
    for (var width = 2u; width <= size; width *= 2u) {
        for (var distance = width / 2u; distance > 0u; distance /= 2u) {
            workgroupBarrier();
            for (var pair = local; pair < size / 2u; pair += WG_SIZE) {
                let a = 2u * pair - (pair & (distance - 1u));
                let b = a + distance;
                let x = sorting[a];
                let y = sorting[b];
                if before(y, x) == ((a & width) == 0u) {
                    sorting[a] = y;
                    sorting[b] = x;
                }
            }
        }
    }
    workgroupBarrier();
    for (var i = local; i < n; i += WG_SIZE) {
        fragments[found.x + i] = sorting[i];
    }
}
