// Sorted lists whose runs are composed: bindings of the passes over them. Imported after what binds the splats.
#import long_list
#import dispatch
@group(0) @binding(17) var<storage, read_write> work: LongWork;
@group(0) @binding(18) var<storage, read> lists: array<LongList>;
@group(0) @binding(19) var<storage, read> runs: array<ListRun>;
@group(0) @binding(20) var<storage, read> fragments: array<vec2<u32>>;
