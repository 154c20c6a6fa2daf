// A pixel's nearest splat. Read as one 64-bit integer (little endian) the depth decides first, then the index.
struct NearestAtomic {
    id: atomic<u32>,
    key: atomic<u32>,
}
