// Counts of a pass through the points of a chunk.
struct Stats {
    // Points that may cover a pixel of the part of the image in work.
    visible: atomic<u32>,
    // Splats of more than view.small_area pixels.
    large: atomic<u32>,
    // Tiles of all large splats, 64 bits.
    tiles_low: atomic<u32>,
    tiles_high: atomic<u32>,
    // Most columns and rows of pixels of a splat.
    widest: atomic<u32>,
    tallest: atomic<u32>,
    // Pixels of all rectangles, 64 bits.
    area_low: atomic<u32>,
    area_high: atomic<u32>,
}
