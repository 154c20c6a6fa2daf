// bin/measure: the longest list of a tile. One invocation per tile.
#import dispatch

@group(0) @binding(0) var<storage, read> starts: array<u32>;
@group(0) @binding(1) var<storage, read_write> longest: array<atomic<u32>>;
#push

#main tile {
    if tile < push.tiles {
        atomicMax(&longest[0], starts[(tile + 1u) * push.runs] - starts[tile * push.runs]);
    }
}
