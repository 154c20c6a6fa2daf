//! Classes of list lengths, and the kernels that sort their lists.

use crate::gpu::Variant;
use crate::methods::abuffer::LOCAL_LENGTH;

/// Lists of up to this length are sorted in registers on a CPU, and the blocks that longer ones begin with. A network
/// for twice as many has three times the code: it would take a third of the time in which all kernels compile.
const BLOCK_LENGTH: u32 = 16;
/// Lists of up to this length are sorted in registers where invocations share work. Twice as many would take more
/// registers than a workgroup should.
const NETWORK_LENGTH: u32 = 32;

/// Upper bounds of the classes of list lengths, and the names of their kernels; longer lists make one class more.
pub const CLASSES: [(u32, &str); 7] = [
    (1, "abuffer/resolve-1"),
    (4, "abuffer/resolve-4"),
    (8, "abuffer/resolve-8"),
    (BLOCK_LENGTH, "abuffer/resolve-16"),
    (NETWORK_LENGTH, "abuffer/resolve-32"),
    (128, "abuffer/resolve-128"),
    (LOCAL_LENGTH, "abuffer/resolve-256"),
];

/// Words of a class in the table of classes: workgroups x, y, z; number of pixels; where its pixels begin in the work
/// list; how many of them are in place; two unused.
pub(super) const CLASS_WORDS: u64 = 8;
/// Place of the number of pixels among a class's words.
pub(super) const CLASS_TOTAL: u64 = 3;
/// Place of where its pixels begin.
pub(super) const CLASS_START: u64 = 4;
/// Place of how many of them are in place.
pub(super) const CLASS_PLACED: u64 = 5;

/// Returns the longest list of the classes before this one.
pub fn lower_bound(class: usize) -> u32 {
    class.checked_sub(1).map_or(0, |i| CLASSES[i].0)
}

/// Kernels that sort the lists of a class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sorting {
    /// The kernel that blends them sorts in registers.
    Network,
    /// The kernel that blends them sorts in an array of the invocation's own.
    Merge,
    /// Before the kernel, in the memory of a workgroup.
    Group,
}

impl Sorting {
    /// Returns the way to sort lists of up to `capacity` fragments; `shared` is `true` if a device prefers that
    /// invocations share work. On a CPU an array of the invocation's own lies in the cache, on a GPU in the device's
    /// memory.
    pub(crate) fn of(capacity: u32, shared: bool) -> Self {
        let in_registers = if shared { NETWORK_LENGTH } else { BLOCK_LENGTH };
        match shared {
            _ if capacity <= in_registers => Self::Network,
            false => Self::Merge,
            true => Self::Group,
        }
    }

    /// Returns the variant of the kernel for lists of up to `capacity` fragments, from the one that composes.
    pub(crate) fn resolve_variant(self, compose: Variant, capacity: u32) -> Variant {
        let classified = compose.text(&class_text());
        match self {
            Self::Network => classified.network(capacity),
            Self::Merge => local_sort(classified),
            Self::Group => classified,
        }
    }

    /// Returns the variants of the kernels of all classes that are sorted so, from the variants that resolve.
    pub(crate) fn kernels(self, resolving: impl Fn(Self, u32) -> Vec<Variant>) -> Vec<Variant> {
        let capacities = CLASSES.iter().map(|(capacity, _)| *capacity);
        let wanted =
            capacities.filter(|capacity| [false, true].map(|shared| Self::of(*capacity, shared)).contains(&self));
        let mut found: Vec<Variant> = Vec::new();
        for variant in wanted.flat_map(|capacity| resolving(self, capacity)) {
            // A kernel may serve several classes.
            if !found.contains(&variant) {
                found.push(variant);
            }
        }
        found
    }
}

/// Returns the variant of the passes that know the classes.
pub(super) fn class_variant() -> Variant {
    Variant::plain().text(&class_text())
}

/// WGSL of the table of classes: the function counts the bounds that a length exceeds; empty lists are in no class.
fn class_text() -> String {
    let exceeded: Vec<String> = CLASSES.iter().map(|(bound, _)| format!("select(0u, 1u, n > {bound}u)")).collect();
    let count = CLASSES.len() + 1;
    let sum = exceeded.join(" + ");
    format!("const CLASS_COUNT = {count}u;\nfn class_of(n: u32) -> u32 {{ return select({count}u, {sum}, n > 0u); }}\n")
}

/// Returns the variant of `abuffer/sort-runs`.
pub(super) fn sort_runs_variant() -> Variant {
    local_sort(Variant::plain())
}

/// Adds the constants of shaders/shared/local_sort.wgsl. One kernel serves all classes: an array that is longer than
/// its list costs nothing.
fn local_sort(variant: Variant) -> Variant {
    variant.constant("CAPACITY", LOCAL_LENGTH).constant("BLOCK", BLOCK_LENGTH).network(BLOCK_LENGTH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_cover_every_length_once() {
        for n in 1..=LOCAL_LENGTH {
            let classes = CLASSES.iter().enumerate().filter(|(i, (most, _))| n > lower_bound(*i) && n <= *most);
            assert_eq!(classes.count(), 1, "{n}");
        }
    }
}
