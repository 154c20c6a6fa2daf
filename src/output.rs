//! Files that come out: PNG and EXR with their metadata, written whole or not at all.

/// Why a result could not be written or an image not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {}

impl Error {
    /// 2 for an unknown extension, else 1.
    pub fn exit_status(&self) -> u8 {
        1
    }
}
