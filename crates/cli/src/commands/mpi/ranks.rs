//! The ranks of a run, as MPI counts them, and what they say to one another.

use std::cell::Cell;
use std::io::Write;
use std::time::{Duration, Instant};

use mpi::environment::{Threading, Universe, processor_name};
use mpi::topology::SimpleCommunicator;
use mpi::traits::*;
use pellucid_gpu as gpu;

use crate::commands::Error;
use crate::commands::console::Streams;
use crate::commands::options::DeviceArgs;

/// Bytes of a message at most: MPI counts elements with 31 bits.
const PIECE: usize = 1 << 30;

/// Tags of everything that is sent to one rank, and of words that only say that somebody is there.
const TAG: i32 = 1;
const HERE: i32 = 4;

/// Shortest and longest sleep between two looks for a message: a wait that never sleeps takes a core from ranks that
/// work.
const NAPS: [Duration; 2] = [Duration::from_micros(10), Duration::from_millis(1)];

/// Sleeps until something is there, ever longer.
pub fn patiently<T>(mut look: impl FnMut() -> Option<T>) -> T {
    let mut nap = NAPS[0];
    loop {
        if let Some(found) = look() {
            return found;
        }
        std::thread::sleep(nap);
        nap = (nap * 2).min(NAPS[1]);
    }
}

/// Delay per rank number before a failing rank speaks, so that a lower rank with the same failure can speak first; and
/// the longest delay.
const PATIENCE: Duration = Duration::from_millis(100);
const LONGEST_PATIENCE: Duration = Duration::from_secs(3);

/// The ranks of a run, seen from one of them. The first one reads arguments for all, decides, and writes.
pub struct Ranks {
    world: SimpleCommunicator,
    /// Number of this rank among those of its host, from 0.
    local: usize,
    host: String,
    traffic: Cell<Traffic>,
    /// True if each rank says what it begins with.
    pub tells: bool,
    /// Communicator of all ranks, if this one is seen as if it was alone.
    all: Option<Box<Self>>,
    // Last: dropping it ends MPI.
    _universe: Option<Universe>,
}

/// Messages that a rank has sent and received, and how long it waited for them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Traffic {
    /// Bytes that were sent.
    pub sent: u64,
    /// Bytes that were received.
    pub received: u64,
    /// Time without any message.
    pub waited: Duration,
}

impl Traffic {
    /// Returns the traffic since `before`.
    pub fn since(self, before: Self) -> Self {
        Self {
            sent: self.sent - before.sent,
            received: self.received - before.received,
            waited: self.waited.saturating_sub(before.waited),
        }
    }
}

impl Ranks {
    /// Joins the others.
    ///
    /// # Errors
    /// MPI runs in this process already, or lets only one thread send messages.
    pub fn join() -> Result<Self, &'static str> {
        let (universe, threads) =
            mpi::initialize_with_threading(Threading::Multiple).ok_or("MPI is not available in this process")?;
        if threads != Threading::Multiple {
            return Err(
                "this MPI library has no thread support (MPI_THREAD_MULTIPLE), which pellucid-mpi needs to hand out work",
            );
        }
        let world = universe.world();
        let local = usize::try_from(world.split_shared(world.rank()).rank()).unwrap_or(0);
        let host = processor_name().unwrap_or_else(|_| "a host without a name".to_owned());
        Ok(Self { world, local, host, traffic: Cell::default(), tells: false, all: None, _universe: Some(universe) })
    }

    /// Returns this rank as if it was alone, for a command that the others don't follow: they do as it orders.
    pub fn leading(self) -> Self {
        let (local, host, tells) = (self.local, self.host.clone(), self.tells);
        let world = SimpleCommunicator::self_comm();
        Self { world, local, host, traffic: Cell::default(), tells, all: Some(Box::new(self)), _universe: None }
    }

    /// Returns all ranks, if this one leads others.
    pub fn led(&self) -> Option<&Self> {
        self.all.as_deref()
    }

    /// Number of this rank, from 0.
    pub fn own(&self) -> usize {
        usize::try_from(self.world.rank()).unwrap_or(0)
    }

    /// The number of all ranks.
    pub fn count(&self) -> usize {
        usize::try_from(self.world.size()).unwrap_or(1)
    }

    /// The device of this rank: the one that is asked for, or, where the host has several GPUs, that of the rank's
    /// number on the host.
    pub fn device(&self, asked: &DeviceArgs) -> pellucid_engine::Result<gpu::Device> {
        let mut options = asked.options();
        if options.device.is_none() {
            let (all, _) = gpu::devices(None)?;
            let gpus: Vec<_> = all.iter().filter(|d| d.kind.contains("discrete") && d.lacks.is_empty()).collect();
            options.device = (gpus.len() > 1).then(|| gpus[self.local % gpus.len()].index.to_string());
        }
        Ok(gpu::Device::open(&options)?)
    }

    /// The name of its host.
    pub fn host(&self) -> &str {
        &self.host
    }

    /// True of the rank that decides and writes.
    pub fn is_first(&self) -> bool {
        self.own() == 0
    }

    /// Name of this rank for people: `rank 2 of 4 (node17)`.
    pub fn name(&self) -> String {
        if let Some(all) = &self.all {
            return all.name();
        }
        format!("rank {} of {} ({})", self.own(), self.count(), self.host)
    }

    /// Returns the traffic so far.
    pub fn traffic(&self) -> Traffic {
        self.traffic.get()
    }

    /// Broadcasts the first rank's bytes: along a tree, in which each rank sends them to those that differ from it by
    /// one bit more.
    pub fn told(&self, said: Vec<u8>) -> Vec<u8> {
        let bytes = self.parent().map_or(said, |parent| {
            self.wait(parent, TAG);
            self.received_now(parent)
        });
        for child in self.children().rev() {
            self.send_now(child, &bytes);
        }
        bytes
    }

    /// Parent in the tree: the rank from which this one receives the first one's bytes.
    fn parent(&self) -> Option<usize> {
        (!self.is_first()).then(|| self.own() & (self.own() - 1))
    }

    /// Children in the tree: the ranks to which this one sends the bytes.
    fn children(&self) -> impl DoubleEndedIterator<Item = usize> {
        let (own, count) = (self.own(), self.count());
        let bits = if own == 0 { usize::BITS } else { own.trailing_zeros() };
        (0..bits.min(31)).map(move |bit| own + (1 << bit)).filter(move |child| *child < count)
    }

    /// Returns the bytes of every rank, in their order, on all ranks.
    pub fn all_told(&self, said: &[u8]) -> Vec<Vec<u8>> {
        if !self.is_first() {
            self.send(0, said);
            return told(Vec::new(), self);
        }
        let others = (1..self.count()).map(|rank| self.received(rank));
        told(std::iter::once(said.to_vec()).chain(others).collect(), self)
    }

    /// Sends bytes to a rank, which has to ask for them ([`Self::received`]). Sleeps until it does: MPI would wait at
    /// work.
    pub fn send(&self, to: usize, bytes: &[u8]) {
        self.hear(to);
        self.send_now(to, bytes);
    }

    fn send_now(&self, to: usize, bytes: &[u8]) {
        self.world.process_at_rank(to as i32).send_with_tag(&(bytes.len() as u64), TAG);
        self.send_exactly(to, bytes);
    }

    /// Signals a rank that this one is here.
    fn tell(&self, to: usize) {
        self.world.process_at_rank(to as i32).send_with_tag(&0u8, HERE);
    }

    /// Sleeps until a rank signals that it is here.
    fn hear(&self, from: usize) {
        self.wait(from, HERE);
        let _ = self.world.process_at_rank(from as i32).receive_with_tag::<u8>(HERE);
    }

    /// Sends as many bytes as the other one expects ([`Self::receive_exactly`]).
    pub fn send_exactly(&self, to: usize, bytes: &[u8]) {
        let to = self.world.process_at_rank(to as i32);
        bytes.chunks(PIECE).for_each(|piece| to.send_with_tag(piece, TAG));
        let traffic = self.traffic.get();
        self.traffic.set(Traffic { sent: traffic.sent + bytes.len() as u64, ..traffic });
    }

    /// The bytes that a rank sends.
    pub fn received(&self, from: usize) -> Vec<u8> {
        self.tell(from);
        self.wait(from, TAG);
        self.received_now(from)
    }

    fn received_now(&self, from: usize) -> Vec<u8> {
        let (length, _) = self.world.process_at_rank(from as i32).receive_with_tag::<u64>(TAG);
        let mut bytes = vec![0; length as usize];
        self.receive_exactly(from, &mut bytes);
        bytes
    }

    /// Fills a slice with the bytes that a rank sends.
    pub fn receive_exactly(&self, from: usize, bytes: &mut [u8]) {
        let process = self.world.process_at_rank(from as i32);
        for piece in bytes.chunks_mut(PIECE) {
            self.wait(from, TAG);
            process.receive_into_with_tag(piece, TAG);
        }
        let traffic = self.traffic.get();
        self.traffic.set(Traffic { received: traffic.received + bytes.len() as u64, ..traffic });
    }

    /// Sleeps until there is a message.
    fn wait(&self, from: usize, tag: i32) {
        let (process, begin) = (self.world.process_at_rank(from as i32), Instant::now());
        patiently(|| process.immediate_probe_with_tag(tag));
        let traffic = self.traffic.get();
        self.traffic.set(Traffic { waited: traffic.waited + begin.elapsed(), ..traffic });
    }

    /// Waits until all ranks are here.
    pub fn meet(&self) {
        self.children().for_each(|child| self.hear(child));
        if let Some(parent) = self.parent() {
            self.tell(parent);
            self.hear(parent);
        }
        self.children().rev().for_each(|child| self.tell(child));
    }

    /// Says with what this rank begins, if ranks are to.
    pub fn begin(&self, what: &str) {
        if self.tells {
            say(&format!("{}, process {}: {what}", self.name(), std::process::id()));
        }
    }

    /// Says what went wrong and ends all ranks. Of several that fail for the same reason the first one speaks, and the
    /// others are ended while they wait.
    pub fn fail(&self, message: &str, status: u8) -> ! {
        if let Some(all) = &self.all {
            all.fail(message, status);
        }
        std::thread::sleep(PATIENCE.saturating_mul(self.own() as u32).min(LONGEST_PATIENCE));
        say(&format!("error: {}: {message}", self.name()));
        self.world.abort(status.into())
    }
}

/// Prints a line in one piece, so that those of several ranks don't mix.
fn say(line: &str) {
    // Without a standard error it is lost, which is fine.
    let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
}

/// The value that the first rank has, to all.
pub fn told<T: serde::Serialize + serde::de::DeserializeOwned>(value: T, ranks: &Ranks) -> T {
    let said = ranks.told(encoded(&value));
    postcard::from_bytes(&said)
        .unwrap_or_else(|error| ranks.fail(&format!("rank 0 sent an unexpected message: {error}"), 1))
}

/// A value as bytes for another rank.
pub fn encoded(value: &impl serde::Serialize) -> Vec<u8> {
    postcard::to_allocvec(value).unwrap_or_default()
}

/// The value that a rank sends; another one than expected ends all ranks.
pub fn decoded<T: serde::de::DeserializeOwned>(from: usize, ranks: &Ranks) -> T {
    postcard::from_bytes(&ranks.received(from))
        .unwrap_or_else(|error| ranks.fail(&format!("rank {from} sent an unexpected message: {error}"), 1))
}

/// Returns the result of a rank once all others have theirs: an error of one is an error of all, and the first rank
/// prints it.
///
/// # Errors
/// The exit status, as [`Error::Told`].
pub fn together<T>(ranks: &Ranks, done: pellucid_engine::Result<T>) -> Result<T, Error> {
    let (own, said) = match done {
        Ok(own) => (Some(own), Vec::new()),
        Err(error) => {
            let error = Error::from(error);
            let text = format!("{}: {}", ranks.name(), error.with_causes());
            (None, [vec![error.exit_status()], text.into_bytes()].concat())
        }
    };
    let all = ranks.all_told(&said);
    let Some(first) = all.iter().find(|said| !said.is_empty()) else {
        return own.ok_or(Error::Told(1));
    };
    if ranks.is_first() {
        let others = all.iter().filter(|said| !said.is_empty()).count() - 1;
        let more = if others > 0 { format!(" (and {others} other ranks)") } else { String::new() };
        Streams::Process.print_stderr(format_args!("error: {}{more}", String::from_utf8_lossy(&first[1..])));
    }
    Err(Error::Told(first[0]))
}
