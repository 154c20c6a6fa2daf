//! The passes.

use crate::methods::opaque::NearestSplat;
use crate::methods::prelude::*;
use crate::passes::project::View;

gpu_struct! {
    /// Push constants of the passes that go through slots.
    pub struct SlotsPush {
        count: u32, // Slots of this dispatch, and the number of the first among the cloud's slots of the round.
        first: u32,
        // Among what is bound the point of the first slot, or, of a later pass, the one that others are counted from
        // (modulo 2^32: it may lie before); and index among all points of the first that is bound.
        base: u32,
        list: u32,
        // For a later pass: first point of the first row, counted from `base`, and after how many the cloud begins
        // anew; blocks of a row, binary logarithm of the points of a block, which of the pass's ensembles the round's
        // first one is (modulo 2^32), and what tells the pass from others.
        start: u32,
        around: u32,
        columns: u32,
        block_bits: u32,
        hand: u32,
        pass_word: u32,
        // Slots of an ensemble: whole + rest / ensembles, and the sum of the rests before the round, below `ensembles`.
        whole: u32,
        rest: u32,
        carry: u32,
        ensembles: u32,
        planes: u32, // Ensembles of the round, each with a plane of its own, and the first of them.
        ensemble: u32,
        pixels: u32, // Pixels of a plane.
        epoch_bits: u32, // Bits of the epoch, at most 31, and the epoch in the uppermost of 32 bits.
        epoch: u32,
        key_x: u32, // Key of the random words.
        key_y: u32,
        depth: f32, // Depth at which a point is one pixel wide.
        unit: f32, // -ln(1 - alpha) of an opacity that asks for a whole such pixel.
        scale: f32, // A color of 1 in the units of the sums, and the largest color there.
        most: f32,
    }

    /// Counters of the passes.
    pub struct Counters {
        visible_low: u32,
        visible_high: u32,
        large: u32,
        spare: u32,
    }

    /// Push constants of `spbr/large`.
    pub struct LargePush {
        stripes: u32, // Workgroups of a square, and most workgroups in x.
        most: u32,
    }

    /// Push constants of `spbr/resolve`: pixels of the window, ensembles, and a color of 1 in the units of the sums.
    pub struct ResolvePush {
        pixels: u32,
        ensembles: u32,
        scale: f32,
    }
}

group! {
    /// Bindings of the points for a pass that goes through slots.
    pub Slots as SlotsGroup {
        /// The camera.
        camera: Uniform<View>,
        /// Positions, rounded.
        points_hi: Read<[f32; 4]>,
        /// The rest of the positions.
        points_lo: Read<[f32; 4]>,
        /// Normals; a single one if there are none.
        normals: Read<[f32; 4]>,
        /// Ids.
        ids: Read<u32>,
        /// Counters of the passes.
        counters: ReadWrite<Counters>,
        /// Large squares of a dispatch.
        large: ReadWrite<[u32; 4]>,
    }
}

pass! {
    /// Takes the 64-bit atomic maximum of epoch, complement of the depth key and complement of the point index at each
    /// pixel that a slot's point covers, in the ensemble's plane. The value that it replaces tells whose color to take
    /// back from the pixel's sums when its own is added. A dispatch has as many ensembles as fill the device.
    pub Draw(SlotsPush) = "spbr/draw" {
        slots: Shared<SlotsGroup>,
        nearest: ReadWrite<u64>,
        point_colors: Parts<[f32; 4]>,
        pixels: ReadWrite<u64>,
        squares: ReadWrite<u64>,
    }

    /// Takes the maximum of `spbr/draw` alone, where colors are shaded, too many to be bound together, or not all on
    /// the device.
    pub Nearest(SlotsPush) = "spbr/nearest" with "nearest_wide" {
        slots: Shared<SlotsGroup>,
        nearest: ReadWrite<u64>,
    }

    /// Finds the depth of `spbr/nearest` by a 32-bit minimum, where the device has no 64-bit atomics.
    pub NearestDepth(SlotsPush) = "spbr/nearest-depth" in "spbr/nearest" with "nearest_depth",
    /// Finds the index at the depth of `spbr/nearest-depth` by a second 32-bit pass.
    pub NearestId(SlotsPush) = "spbr/nearest-id" in "spbr/nearest" with "nearest_id" {
        slots: Shared<SlotsGroup>,
        nearest: ReadWrite<NearestSplat>,
    }

    /// Visits the slots again, and adds the colors of the nearest points, shaded only here, to the sums of their
    /// pixels.
    pub Sum(SlotsPush) = "spbr/sum" {
        slots: Shared<SlotsGroup>,
        nearest: Read<[u32; 2]>,
        point_colors: Read<[f32; 4]>,
        pixels: ReadWrite<u32>,
        squares: ReadWrite<u32>,
    }

    /// Turns the number of large squares into the arguments of the dispatch that fills them, workgroup by
    /// workgroup. It runs after each dispatch over slots where such squares are possible.
    pub Large(LargePush) = "spbr/large" {
        counters: Read<Counters>,
        arguments: ReadWrite<u32>,
    }

    /// Clears the nearest point beside each pixel's sums when there are no epochs left.
    pub Renew(CountPush) = "spbr/renew" {
        pixels: ReadWrite<[u32; 2]>,
    }

    /// Turns the sums of each pixel into color, A and depth, and the standard error if it is asked for.
    pub Resolve(ResolvePush) = "spbr/resolve" {
        pixels: Read<[u32; 4]>,
        squares: Read<[u32; 4]>,
        into: Shared<PixelsGroup>,
        spread: ReadWrite<[f32; 4]>,
    }
}
