// abuffer/groups: numbers of pixels to workgroups (folded over x and y) and to places in the work list. One invocation.
#import classes
#import folded

@group(0) @binding(0) var<storage, read_write> classes: array<u32>;

const MOST = 65535u;

@compute @workgroup_size(1)
fn main() {
    var start = 0u;
    for (var c = 0u; c < CLASS_COUNT; c++) {
        let word = c * CLASS_WORDS;
        let total = classes[word + CLASS_TOTAL];
        let groups = folded((total + WG_SIZE - 1u) / WG_SIZE, MOST);
        classes[word] = groups.x;
        classes[word + 1u] = groups.y;
        classes[word + 2u] = 1u;
        classes[word + CLASS_START] = start;
        start += total;
    }
}
