//! Values from rank to rank.

use super::ranks::Ranks;

/// The value that the first rank has, to all.
pub fn told<T: serde::Serialize + serde::de::DeserializeOwned>(value: T, ranks: &Ranks) -> T {
    let said = ranks.told(encoded(&value));
    postcard::from_bytes(&said).unwrap_or(value)
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
