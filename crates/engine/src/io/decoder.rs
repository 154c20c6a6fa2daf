//! Keeps a panic inside a decoder library from ending the program.

use std::cell::Cell;
use std::panic;
use std::sync::Once;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs code of a decoder library; a panic becomes its message and prints nothing.
///
/// The panic hook is replaced once and for good by one that is silent on threads inside this function and calls the
/// previous hook on all others, so that no two threads ever swap hooks.
pub(crate) fn guard<T>(decode: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let previous = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !QUIET.get() {
                previous(info);
            }
        }));
    });
    let outer = QUIET.replace(true);
    // What a panic leaves behind is dropped by the caller: the file is refused.
    let result = panic::catch_unwind(panic::AssertUnwindSafe(decode));
    QUIET.set(outer);
    result.map_err(|payload| {
        let text = payload.downcast_ref::<String>().map(String::as_str).or(payload.downcast_ref::<&str>().copied());
        text.unwrap_or("unknown cause").to_owned()
    })
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
