//! The ranks of a run, as MPI counts them, and what they say to one another.

use std::io::Write;

use mpi::environment::{Universe, processor_name};
use mpi::topology::SimpleCommunicator;
use mpi::traits::*;

/// Bytes of a message at most: MPI counts elements with 31 bits.
const PIECE: usize = 1 << 30;

/// Tag of everything that is sent to one rank.
const TAG: i32 = 1;

/// The ranks of a run, seen from one of them. The first one reads arguments for all, decides, and writes.
pub struct Ranks {
    world: SimpleCommunicator,
    /// This one's number among those of its host.
    local: usize,
    host: String,
    // Last: dropping it ends MPI.
    _universe: Universe,
}

impl Ranks {
    /// Joins the others; `None` if MPI runs in this process already.
    pub fn join() -> Option<Self> {
        let universe = mpi::initialize()?;
        let world = universe.world();
        let local = usize::try_from(world.split_shared(world.rank()).rank()).unwrap_or(0);
        let host = processor_name().unwrap_or_else(|_| "a host without a name".to_owned());
        Some(Self { world, local, host, _universe: universe })
    }

    /// This rank, from 0.
    pub fn own(&self) -> usize {
        usize::try_from(self.world.rank()).unwrap_or(0)
    }

    /// The number of all ranks.
    pub fn count(&self) -> usize {
        usize::try_from(self.world.size()).unwrap_or(1)
    }

    /// This rank's number among those of its host, from 0: on a machine with several GPUs each rank takes its own.
    pub fn local(&self) -> usize {
        self.local
    }

    /// True of the rank that decides and writes.
    pub fn is_first(&self) -> bool {
        self.own() == 0
    }

    /// This rank for people: `rank 2 of 4 (node17)`.
    pub fn name(&self) -> String {
        format!("rank {} of {} ({})", self.own(), self.count(), self.host)
    }

    /// What the first rank says, to all.
    pub fn told(&self, said: Vec<u8>) -> Vec<u8> {
        let first = self.world.process_at_rank(0);
        let mut length = said.len() as u64;
        first.broadcast_into(&mut length);
        let mut bytes = said;
        bytes.resize(length as usize, 0);
        bytes.chunks_mut(PIECE).for_each(|piece| first.broadcast_into(piece));
        bytes
    }

    /// What every rank says, in their order, to all.
    pub fn all_told(&self, said: &[u8]) -> Vec<Vec<u8>> {
        if self.is_first() {
            let mut all = vec![said.to_vec()];
            all.extend((1..self.count()).map(|rank| self.received(rank)));
            let lengths: Vec<u8> = all.iter().flat_map(|one| (one.len() as u64).to_le_bytes()).collect();
            let (lengths, all) = (self.told(lengths), self.told(all.concat()));
            cut(&lengths, &all)
        } else {
            self.send(0, said);
            let (lengths, all) = (self.told(Vec::new()), self.told(Vec::new()));
            cut(&lengths, &all)
        }
    }

    /// Sends bytes to a rank, which has to ask for them ([`Self::received`]).
    pub fn send(&self, to: usize, bytes: &[u8]) {
        let to = self.world.process_at_rank(to as i32);
        to.send_with_tag(&(bytes.len() as u64), TAG);
        bytes.chunks(PIECE).for_each(|piece| to.send_with_tag(piece, TAG));
    }

    /// The bytes that a rank sends.
    pub fn received(&self, from: usize) -> Vec<u8> {
        let from = self.world.process_at_rank(from as i32);
        let (length, _) = from.receive_with_tag::<u64>(TAG);
        let mut bytes = vec![0; length as usize];
        for piece in bytes.chunks_mut(PIECE) {
            from.receive_into_with_tag(piece, TAG);
        }
        bytes
    }

    /// Waits until all ranks are here.
    pub fn meet(&self) {
        self.world.barrier();
    }

    /// Says what went wrong and ends all ranks.
    pub fn fail(&self, message: &str, status: u8) -> ! {
        // Without a standard error the message is lost, which is fine.
        let _ = writeln!(std::io::stderr(), "error: {}: {message}", self.name());
        self.world.abort(status.into())
    }
}

fn cut(lengths: &[u8], all: &[u8]) -> Vec<Vec<u8>> {
    let mut rest = all;
    let lengths = lengths.chunks_exact(8).filter_map(|length| length.try_into().ok().map(u64::from_le_bytes));
    lengths
        .map(|length| {
            let (one, others) = rest.split_at((length as usize).min(rest.len()));
            rest = others;
            one.to_vec()
        })
        .collect()
}
