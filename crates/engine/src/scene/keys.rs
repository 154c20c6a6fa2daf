//! The keys of every method, so that a key of a method that is not in force can be told from a slip.

/// The methods, by the names a scene file gives them.
pub const METHODS: &[&str] = &[
    "auto",
    "points",
    "squares",
    "circles",
    "paraboloid",
    "cone",
    "sphere",
    "abuffer",
    "linked-list",
    "sorted",
    "peel",
    "peel-layers",
    "stochastic",
    "hybrid",
    "weighted",
    "average",
    "unsorted",
    "hqs",
    "splats",
    "image-space",
    "soft-base",
    "soft-concentric",
    "soft-express",
    "one-layer",
    "spbr",
    "spbr-simplified",
];

/// The keys of `[shading]`.
pub const SHADING_KEYS: &[&str] = &["model", "ambient", "diffuse", "specular", "shininess", "light"];

/// The keys of `[shadows]`.
pub const SHADOW_KEYS: &[&str] = &["method", "samples", "light_radius", "resolution", "min_layer_distance"];

const SPLATS: &[&str] = &["size", "max_pixel_radius"];
const NEAREST: &[&str] = &["raster"];
const BLENDED: &[&str] = &["blend_depth"];
const DISCS: &[&str] = &["shape", "falloff", "raster"];
const LISTS: &[&str] = &["long_lists"];
const FILTERS: &[&str] =
    &["fill", "occlusion", "smooth", "antialias", "antialias_threshold", "min_layer_distance", "cull"];
const SOFT: &[&str] = &["threshold", "lambda", "softness", "modulation", "shells", "pixels_per_shell", "layout"];

/// Every method with groups of keys of its own; `name` is everyone's.
const METHOD_KEYS: &[(&str, &[&[&str]])] = &[
    ("auto", &[DISCS]),
    ("points", &[]),
    ("squares", &[SPLATS, NEAREST]),
    ("circles", &[SPLATS, NEAREST]),
    ("paraboloid", &[SPLATS, NEAREST, &["shape"]]),
    ("cone", &[SPLATS, NEAREST, &["shape"]]),
    ("sphere", &[SPLATS, NEAREST]),
    ("hqs", &[SPLATS, BLENDED, &["shape"]]),
    ("splats", &[SPLATS, BLENDED]),
    ("image-space", &[FILTERS]),
    ("abuffer", &[DISCS, LISTS]),
    ("linked-list", &[DISCS, LISTS]),
    ("sorted", &[DISCS]),
    ("peel", &[DISCS, &["layers"]]),
    ("peel-layers", &[FILTERS, &["layers"]]),
    ("stochastic", &[DISCS, &["samples", "alpha_correction"]]),
    ("weighted", &[DISCS]),
    ("hybrid", &[DISCS, &["k"]]),
    ("average", &[DISCS]),
    ("unsorted", &[DISCS]),
    ("soft-base", &[SOFT]),
    ("soft-concentric", &[SOFT]),
    ("soft-express", &[SOFT]),
    ("one-layer", &[&["threshold", "softness"]]),
    ("spbr", &[&["ensembles", "cos_theta", "brighten"]]),
    ("spbr-simplified", &[&["ensembles", "brightness"]]),
];

/// The keys of a method beside `name`, in the order of its list; none of a method that there isn't.
pub fn method_keys(method: &str) -> Vec<&'static str> {
    let groups = METHOD_KEYS.iter().filter(|(name, _)| *name == method).flat_map(|(_, groups)| groups.iter());
    groups.flat_map(|group| group.iter().copied()).collect()
}

/// Whether `key` is one of `method`'s own.
pub(crate) fn belongs(method: &str, key: &str) -> bool {
    METHOD_KEYS.iter().any(|(name, groups)| *name == method && groups.iter().any(|group| group.contains(&key)))
}

/// The methods that have `key`.
pub(crate) fn owners(key: &str) -> Vec<&'static str> {
    METHOD_KEYS.iter().map(|(name, _)| *name).filter(|name| belongs(name, key)).collect()
}

/// Every key that some method has, `name` included, each once.
pub(crate) fn all_method_keys() -> Vec<&'static str> {
    let groups = METHOD_KEYS.iter().flat_map(|(_, groups)| groups.iter());
    let mut keys: Vec<_> = groups.flat_map(|group| group.iter().copied()).chain(["name"]).collect();
    keys.sort_unstable();
    keys.dedup();
    keys
}
