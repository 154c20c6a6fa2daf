// Random numbers from counters, and masks of samples: bit for bit src/random.rs, which says what they are.

// Threefry-2x32, 20 rounds (Salmon et al. 2011). Written out: no loop, and rotations by constants.
fn threefry2x32(counter: vec2<u32>, key: vec2<u32>) -> vec2<u32> {
    let third = 0x1BD11BDAu ^ key.x ^ key.y;
    var v = counter + key;
    v = four_rounds_a(v) + vec2<u32>(key.y, third + 1u);
    v = four_rounds_b(v) + vec2<u32>(third, key.x + 2u);
    v = four_rounds_a(v) + vec2<u32>(key.x, key.y + 3u);
    v = four_rounds_b(v) + vec2<u32>(key.y, third + 4u);
    return four_rounds_a(v) + vec2<u32>(third, key.x + 5u);
}

fn four_rounds_a(v: vec2<u32>) -> vec2<u32> {
    return one_round(one_round(one_round(one_round(v, 13u), 15u), 26u), 6u);
}

fn four_rounds_b(v: vec2<u32>) -> vec2<u32> {
    return one_round(one_round(one_round(one_round(v, 17u), 29u), 16u), 24u);
}

fn one_round(v: vec2<u32>, turn: u32) -> vec2<u32> {
    let sum = v.x + v.y;
    return vec2<u32>(sum, ((v.y << turn) | (v.y >> (32u - turn))) ^ sum);
}

// The words of two strata that a fragment's samples are drawn from; `key` is that of the two.
fn words_of(pixel: vec2<u32>, splat: u32, key: vec2<u32>) -> vec2<u32> {
    return threefry2x32(vec2<u32>((pixel.y << 16u) | pixel.x, splat), key);
}

// Which samples of a stratum a fragment covers, a bit for each of four.
fn mask_of(alpha: f32, word: u32) -> u32 {
    let steps = u32(alpha * 268435456.0 + 0.5);
    let covered = min((steps + (word >> 6u)) >> 26u, 4u);
    // Eight bits for each number of samples, the mask twice over, so that a shift rotates it.
    var two = 0x33u;
    if ((word >> 2u) & 15u) < 5u {
        two = 0x55u;
    }
    let few = 0x1100u | (two << 16u) | 0x77000000u;
    let doubled = select((few >> (8u * (covered & 3u))) & 0xffu, 0xffu, covered == 4u);
    return (doubled >> (4u - (word & 3u))) & 15u;
}
