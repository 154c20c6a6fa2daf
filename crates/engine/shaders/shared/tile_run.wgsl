// The run that a subgroup takes of a tile's splats, in the order in which they were binned. Bindings 0 to 19 are those
// of any_splat and these; the stage's push constants have a member `walk: TileWalk`.
#import any_splat
#import blocks

struct TileWalk {
    // Tiles of the window in x; the first tile in work, and their number.
    columns: u32,
    first_tile: u32,
    tiles: u32,
    // Cells of a tile in the table of ends; 0 if that is a table of the tiles' starts, and of the end of the last.
    runs: u32,
    // Which part of each tile's splats: those from segment * TAKEN on; and the number of parts of the longest tile.
    segment: u32,
    segments: u32,
}

@group(0) @binding(17) var<storage, read> ends: array<u32>;
@group(0) @binding(18) var<storage, read> entries: array<u32>;
@group(0) @binding(19) var<storage, read> bounds: array<Bounds>;

// Splats of a tile that one run takes: some 5 iterations for each stay below what CPU drivers allow.
override TAKEN: u32 = 1u;

// A subgroup's number among all: a workgroup has TEAM of them.
fn subgroup_of(workgroup: u32, member: u32) -> u32 {
    return select(workgroup * TEAM + member, workgroup, TEAM == 1u);
}

// Where the splats of a tile begin that is not the first: the place in the table that says so.
fn begun(tile: u32) -> u32 {
    return select(tile * push.walk.runs - 1u, tile, push.walk.runs == 0u);
}

// One past a tile's last splat.
fn tile_end(tile: u32) -> u32 {
    return ends[begun(tile + 1u)];
}

// The run's first splat of a tile, and one past its last.
fn run_of(tile: u32) -> vec2<u32> {
    let before = select(0u, ends[begun(max(tile, 1u))], tile > 0u);
    let start = before + push.walk.segment * TAKEN;
    return vec2<u32>(start, min(start + TAKEN, tile_end(tile)));
}

// True if the run goes on from the result of earlier ones, wherever the stage keeps that.
fn is_later() -> bool {
    return push.walk.segment > 0u;
}

// True if some tile takes several runs, so that each leaves what it knows.
fn is_one_of_several() -> bool {
    return push.walk.segments > 1u;
}

// True if a run has nothing to add to the result of earlier ones. The first one also writes where a tile has no splat.
fn is_idle(run: vec2<u32>) -> bool {
    return is_later() && run.x >= run.y;
}

// An entry is a splat's index and, in its highest bits, the blocks of the tile that its rectangle meets.
fn index_of(entry: u32) -> u32 {
    return entry & ((1u << INDEX_BITS) - 1u);
}

fn meets_block(entry: u32, block: u32) -> bool {
    return (entry >> (INDEX_BITS + block) & 1u) != 0u;
}

fn tile_corner(tile: u32) -> vec2<u32> {
    return view.window.xy + vec2<u32>(tile % push.walk.columns, tile / push.walk.columns) * TILE_SIDE;
}

// A splat without its depth, which few stages need.
fn flat_at(i: u32) -> Splat {
    return unpack_splat(packed_at(i), 0.0);
}

// Where a splat lies that stands in where none is left, in pixels: beyond any radius.
const NOWHERE = 1e19;

// The way from the center of lane k's splat to an invocation's first pixel.
fn handed_whole(own: vec2<f32>, k: u32, present: bool, first: vec2<f32>) -> vec2<f32> {
    return first - vec2<f32>(select(NOWHERE, subgroupShuffle(own.x, k), present), subgroupShuffle(own.y, k));
}

// The splat of lane k, but for its pixel.
fn handed_splat(own: Splat, k: u32) -> Splat {
    var s: Splat;
    s.fraction_x = subgroupShuffle(own.fraction_x, k);
    s.fraction_y = subgroupShuffle(own.fraction_y, k);
    s.radius = subgroupShuffle(own.radius, k);
    s.depth = subgroupShuffle(own.depth, k);
    return s;
}
