// Bindings of a layer of peeling beside the splats. A fragment's rank is its depth key, then its splat's index: the
// order in which abuffer blends. `last` holds the rank of each pixel's last peeled fragment, 0 before the first one: no
// depth has the key 0.
#import raster
#import fragments
@group(0) @binding(9) var<storage, read> last: array<vec2<u32>>;

// True if a fragment lies behind those that were peeled from its pixel.
fn is_left(p: u32, key: u32, id: u32) -> bool {
    return before(last[p], vec2<u32>(key, id));
}
