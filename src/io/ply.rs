//! Stub.
use std::path::Path;

use super::Error;
use crate::cloud::Cloud;

/// Stub.
pub fn write(path: &Path, _cloud: &Cloud) -> Result<(), Error> {
    std::fs::write(path, "stub").map_err(|e| Error::Stub { path: path.display().to_string(), cause: e.to_string() })
}
