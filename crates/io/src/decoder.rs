//! Keeps a panic inside a decoder library from ending the program.

use std::cell::Cell;
use std::io::Read;
use std::panic;

use ruzstd::decoding::StreamingDecoder;

thread_local! {
    /// True while this thread runs a decoder.
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Replaces the panic hook by one that is silent while a decoder library runs and calls the present hook otherwise.
///
/// A damaged file may make a decoder panic. The panic becomes an error in any case, but the default hook prints it
/// first. The hook belongs to the process, so a program decides whether it is replaced, once and before it reads
/// anything.
pub fn silence_decoder_panics() {
    let previous = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        if !QUIET.get() {
            previous(info);
        }
    }));
}

/// Runs code of a decoder library; a panic becomes its message.
pub(crate) fn guard<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    let outer = QUIET.replace(true);
    // The caller drops the state after a panic, because it refuses the file.
    let result = panic::catch_unwind(panic::AssertUnwindSafe(decode));
    QUIET.set(outer);
    result.map_err(|payload| {
        let text = payload.downcast_ref::<String>().map(String::as_str).or(payload.downcast_ref::<&str>().copied());
        text.unwrap_or("unknown cause").to_owned()
    })
}

/// Unpacks a Zstandard stream, of which no more is unpacked than a byte beyond so many.
pub(crate) fn zstandard(stream: &[u8], most: u64) -> Result<Vec<u8>, String> {
    guard(|| {
        let mut all = Vec::new();
        let decoder = StreamingDecoder::new(stream).map_err(|e| e.to_string())?;
        decoder.take(most.saturating_add(1)).read_to_end(&mut all).map_err(|e| e.to_string())?;
        Ok(all)
    })?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_message() {
        assert_eq!(guard(|| 3), Ok(3));
        assert_eq!(guard(|| panic!("bits {}", 4)), Err::<(), _>("bits 4".to_owned()));
        let empty: &[u8] = std::hint::black_box(&[]);
        assert!(guard(|| empty[0]).unwrap_err().contains("out of bounds"));
        assert!(!QUIET.get());
    }
}
