// How far peeling is.
struct PeelWork {
    // The most layers of a pixel that the walk in work found; 0 at its start.
    found: atomic<u32>,
    // Layers of all walks before.
    layers: u32,
}
