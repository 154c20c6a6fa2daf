// Where radix/scatter moves records to.
@group(0) @binding(2) var<storage, read_write> moved: array<vec2<u32>>;

fn put(place: u32, record: vec2<u32>) {
    moved[place] = record;
}
