//! Shared by the fuzz targets and by `crates/cli/tests/fuzz.rs` of the main package. CONTRIBUTING.md says how to fuzz.

pub mod bodies;
pub mod harness;

use std::sync::Once;

/// Counts what an input makes the readers allocate.
#[global_allocator]
static MEMORY: peak_alloc::PeakAlloc = peak_alloc::PeakAlloc;

/// Runs one input of the fuzzer; whatever is wrong ends the process, which the fuzzer takes for a finding.
pub fn run(body: harness::Body, input: &[u8]) {
    // libFuzzer's hook ends the process at every panic, also at those of decoder libraries that become errors.
    static HOOK: Once = Once::new();
    HOOK.call_once(|| drop(std::panic::take_hook()));
    if let Err(fault) = harness::run(&MEMORY, body, input) {
        eprintln!("{fault}");
        std::process::abort();
    }
}

/// The entry point of the target that is called like a body.
#[macro_export]
macro_rules! target {
    ($name:ident) => {
        libfuzzer_sys::fuzz_target!(|input: &[u8]| $crate::run($crate::bodies::$name, input));
    };
}
