//! Findings: a panic that nothing caught, and too much memory. The fuzzer looks after time.

use std::panic::{AssertUnwindSafe, catch_unwind};

use peak_alloc::PeakAlloc;

/// A target: takes an input, and returns if all is well, be the file read or refused.
pub type Body = fn(&[u8]);

/// Bytes that a small file may take: what refusing a file promises to stay under.
pub const MEMORY_LIMIT: usize = 200 << 20;

/// Runs a body; fails with what is wrong. `memory` is the program's allocator, and nothing else may allocate meanwhile.
pub fn run(memory: &PeakAlloc, body: Body, input: &[u8]) -> Result<(), String> {
    memory.reset_peak_usage();
    let before = memory.current_usage();
    catch_unwind(AssertUnwindSafe(|| body(input))).map_err(|payload| {
        let text = payload.downcast_ref::<String>().map(String::as_str).or(payload.downcast_ref::<&str>().copied());
        format!("a panic: {}", text.unwrap_or("without a message"))
    })?;
    let taken = memory.peak_usage().saturating_sub(before);
    if taken > MEMORY_LIMIT {
        return Err(format!("{} MiB of memory for {} bytes", taken >> 20, input.len()));
    }
    Ok(())
}
