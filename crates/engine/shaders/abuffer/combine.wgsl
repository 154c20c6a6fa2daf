// abuffer/combine: composes the runs of each long list, front to back: composition is associative. One invocation per
// list.
#import view
#import over
#import long_list
#import dispatch

@group(0) @binding(0) var<storage, read_write> work: LongWork;
@group(0) @binding(1) var<storage, read> lists: array<LongList>;
@group(0) @binding(2) var<storage, read> partials: array<Partial>;
@group(0) @binding(3) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> depths: array<f32>;

#main item {
    if item >= atomicLoad(&work.list_count) {
        return;
    }
    let list = lists[item];
    var sum = Composed(vec4<f32>(0.0), NOTHING);
    for (var k = 0u; k < list.runs; k++) {
        let part = partials[list.first_run + k];
        sum = run_behind(sum, Composed(part.rgba, part.key.x));
    }
    image[list.pixel] = sum.rgba;
    depths[list.pixel] = list_depth(sum);
}
