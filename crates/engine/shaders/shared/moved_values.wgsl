// Where radix/scatter moves the values of records to, without their keys.
@group(0) @binding(2) var<storage, read_write> moved: array<u32>;

fn put(place: u32, record: vec2<u32>) {
    moved[place] = record.y;
}
