// How far peeling is.
struct PeelWork {
    // 1 if the layer in work has a fragment anywhere; 0 at its start.
    found: atomic<u32>,
    // Layers that had one.
    layers: u32,
}
