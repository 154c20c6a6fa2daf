//! (in work)

/// (in work)
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {}
