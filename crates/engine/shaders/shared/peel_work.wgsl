// How far peeling is.
struct PeelWork {
    // Whether the layer in work has a fragment anywhere; 0 at its start.
    found: atomic<u32>,
    // Layers that had one.
    layers: u32,
}
