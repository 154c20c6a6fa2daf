//! Keys of the sort: what they are made of, and how many bits of them there are.

use super::Order;
use crate::gpu::Variant;

pub(super) const ORDER_DEPTH: u32 = 0;
pub(super) const ORDER_INDEX: u32 = 1;
pub(super) const ORDER_FILE: u32 = 2;
const ORDER_ARRIVAL: u32 = 3;

/// Returns the variant of `bin/keys`.
pub(super) fn keys_variant(order: Order) -> Variant {
    let value = match order {
        Order::Depth | Order::Along(_) => ORDER_DEPTH,
        Order::Index => ORDER_INDEX,
        Order::File => ORDER_FILE,
        Order::Arrival => ORDER_ARRIVAL,
    };
    Variant::plain().with("ORDER", value)
}

/// Returns the key of the nearest depth, and the key, less that, of what lies beyond the farthest.
pub(super) fn depth_keys(depth_range: [f32; 2]) -> [u32; 2] {
    let [near, far] = depth_range.map(depth_key);
    [near, far - near + 1]
}

/// Returns the number subtracted from keys, and the key that undrawn splats then have.
pub(super) fn keys(order: Order, depth_range: [f32; 2], points: u64) -> [u32; 2] {
    match order {
        Order::Depth | Order::Along(_) => depth_keys(depth_range),
        Order::Index => [0, 1],
        Order::File | Order::Arrival => [0, points as u32],
    }
}

/// Returns the number of bits of the keys of so many splats between two depths.
pub fn key_bits(order: Order, depth_range: [f32; 2], points: u64) -> u32 {
    (u32::BITS - keys(order, depth_range, points)[1].leading_zeros()).max(1)
}

/// The key of a depth, as `depth_key` in WGSL.
fn depth_key(depth: f32) -> u32 {
    let bits = depth.to_bits();
    if bits >> 31 != 0 { !bits } else { bits | 1 << 31 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_keep_the_order_of_depths_and_what_is_not_drawn_comes_last() {
        let depths = [f32::NEG_INFINITY, -2.0, -0.0, 0.0, 1e-40, 1.0, 1.000_000_1, 3e38, f32::INFINITY];
        assert!(depths.windows(2).all(|pair| depth_key(pair[0]) < depth_key(pair[1])));
        assert_eq!(depth_keys([1.0, 1.0])[1], 1);
        // From 1 to 2 there are 2^23 steps.
        assert_eq!((depth_keys([1.0, 2.0])[1], key_bits(Order::Depth, [1.0, 2.0], 5)), ((1 << 23) + 1, 24));
        assert_eq!(key_bits(Order::Depth, [f32::NEG_INFINITY, f32::INFINITY], 5), 32);
        // Indices are in order already: one bit says what is drawn. In a file of 5 points keys go from 0 to 5.
        let bits = [Order::Index, Order::File, Order::Arrival].map(|order| key_bits(order, [1.0, 2.0], 5));
        assert_eq!(bits, [1, 3, 3]);
    }
}
