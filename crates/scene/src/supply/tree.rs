//! Blocks as the nodes of trees: which of them a place is in, from the coarsest level down.

use glam::DVec3;

use super::Block;
use crate::lists::Lists;
use pellucid_core::cloud::Bounds;

/// The trees of some blocks.
#[derive(Debug)]
pub(super) struct BlockTree {
    /// Children of each block.
    children: Lists,
    roots: Vec<u32>,
    /// Root of each block's tree; the block's own number without levels.
    root_of: Vec<u32>,
}

impl BlockTree {
    /// Builds the tree of blocks whose parents come before them.
    pub fn new(blocks: &[Block]) -> Self {
        let parent = |block: &Block| block.branch.and_then(|branch| branch.parent);
        let pair = |(number, block): (u32, &Block)| Some((parent(block)? as usize, number));
        let children = Lists::new(blocks.len(), || (0..).zip(blocks).filter_map(pair));
        let (mut roots, mut root_of) = (Vec::new(), Vec::<u32>::with_capacity(blocks.len()));
        for (number, block) in (0..).zip(blocks) {
            root_of.push(parent(block).map_or(number, |above| root_of[above as usize]));
            roots.extend(block.branch.filter(|branch| branch.parent.is_none()).map(|_| number));
        }
        Self { children, roots, root_of }
    }

    /// Returns the factor on the radius of a point of this block, where the blocks that are not `kept` are left out:
    /// that of the first of them on the way down from the root to the place; 1 where all are kept. The box of a block
    /// is that of its points: a place next to it, as far as the points above are apart, is its own, too.
    pub fn growth(&self, blocks: &[Block], kept: &[bool], block: u32, place: DVec3) -> f32 {
        let mut at = self.root_of[block as usize];
        loop {
            let mut nearest: Option<(f64, u32)> = None;
            for child in self.children.of(at as usize) {
                let bounds = &blocks[*child as usize].bounds;
                let apart = place.distance(place.clamp(bounds.min, bounds.max));
                if apart <= reach(&blocks[*child as usize]) && nearest.is_none_or(|(least, _)| apart < least) {
                    nearest = Some((apart, *child));
                }
            }
            match nearest {
                None => return 1.0,
                Some((_, child)) if kept[child as usize] => at = child,
                Some((_, child)) => return blocks[child as usize].branch.map_or(1.0, |branch| branch.growth),
            }
        }
    }

    /// Returns the largest such factor in a box, or more.
    pub fn most_growth(&self, blocks: &[Block], kept: &[bool], bounds: &Bounds) -> f32 {
        let mut open = self.roots.clone();
        let mut most = 1.0f32;
        while let Some(at) = open.pop() {
            for child in self.children.of(at as usize) {
                let block = &blocks[*child as usize];
                let reach = DVec3::splat(reach(block));
                let meets = bounds.min.cmple(block.bounds.max + reach).all()
                    && (block.bounds.min - reach).cmple(bounds.max).all();
                if meets && kept[*child as usize] {
                    open.push(*child);
                } else if meets {
                    most = block.branch.map_or(most, |branch| most.max(branch.growth));
                }
            }
        }
        most
    }
}

/// Returns the largest distance from its box at which a place belongs to a block.
fn reach(block: &Block) -> f64 {
    block.branch.map_or(0.0, |branch| branch.spacing)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::supply::Branch;

    fn block(range: [f64; 2], parent: Option<u32>, spacing: f64, growth: f32) -> Block {
        let [min, max] = range.map(|x| DVec3::new(x, 0.0, 0.0));
        let branch = Some(Branch { parent, spacing, growth });
        Block { bounds: Bounds { min, max }, radius: 1.0, points: 1, branch }
    }

    #[test]
    fn radii_grow_by_what_is_left_out_at_their_place() {
        // A root, two children, and two children of the second one.
        let blocks = [
            block([0.0, 8.0], None, f64::INFINITY, 1.0),
            block([0.0, 4.0], Some(0), 0.5, 2.0),
            block([4.6, 8.0], Some(0), 0.5, 4.0),
            block([4.6, 6.0], Some(2), 0.25, 3.0),
            block([6.0, 8.0], Some(2), 0.25, 5.0),
        ];
        let tree = BlockTree::new(&blocks);
        let growth = |kept: [bool; 5], x: f64| tree.growth(&blocks, &kept, 0, DVec3::new(x, 0.0, 0.0));
        let all = [true; 5];
        assert_eq!([1.0, 4.5, 5.0, 7.0].map(|x| growth(all, x)), [1.0; 4]);
        let without_children = [true, false, false, false, false];
        // Beside a box as far as points are apart, the nearer box counts; between them none does.
        assert_eq!([1.0, 4.2, 4.4, 5.0, 8.4].map(|x| growth(without_children, x)), [2.0, 2.0, 4.0, 4.0, 4.0]);
        assert_eq!(growth(without_children, 8.6), 1.0);
        let partly = [true, true, true, true, false];
        assert_eq!([1.0, 5.0, 7.0].map(|x| growth(partly, x)), [1.0, 1.0, 5.0]);
        let most = |kept: &[bool], low: f64, high: f64| {
            tree.most_growth(&blocks, kept, &block([low, high], None, 0.0, 1.0).bounds)
        };
        assert_eq!((most(&partly, 0.0, 5.0), most(&partly, 5.0, 5.8), most(&partly, 5.0, 7.0)), (1.0, 5.0, 5.0));
        assert_eq!(most(&without_children, 0.0, 3.0), 2.0);
    }
}
