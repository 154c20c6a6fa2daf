//! Lists of numbers by key, one behind the other in a single column.

/// The lists.
#[derive(Debug)]
pub(crate) struct Lists {
    /// Index at which each list begins, and the last one ends.
    starts: Vec<u32>,
    members: Vec<u32>,
}

impl Lists {
    /// Makes so many lists from pairs of a list and a member, which are gone through twice. Members keep their order.
    pub fn new<I: Iterator<Item = (usize, u32)>>(count: usize, pairs: impl Fn() -> I) -> Self {
        let mut starts = vec![0; count + 1];
        pairs().for_each(|(list, _)| starts[list + 1] += 1);
        for list in 0..count {
            starts[list + 1] += starts[list];
        }
        let (mut next, mut members) = (starts.clone(), vec![0; starts[count] as usize]);
        for (list, member) in pairs() {
            members[next[list] as usize] = member;
            next[list] += 1;
        }
        Self { starts, members }
    }

    /// Returns the members of a list.
    pub fn of(&self, list: usize) -> &[u32] {
        &self.members[self.starts[list] as usize..self.starts[list + 1] as usize]
    }
}
