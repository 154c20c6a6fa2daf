//! Ceilings of a device: rates of copies, reads, atomics and arithmetic, and what passes cost that do nothing.

use std::time::Duration;

use pellucid_engine::Result;
use pellucid_gpu::shader::Sources;
use pellucid_gpu::{
    Buffer, Device, Dispatch, Error, GpuType, Memory, Recorder, Run, Stamps, Submitted, Variant, Yardstick, gpu_struct,
    pass,
};
use serde_json::json;

use crate::{Bounds, lines};

/// The shaders of this module.
static SOURCES: Sources = Sources {
    files: include_dir::include_dir!("$CARGO_MANIFEST_DIR/../../tools/gpu/shaders"),
    constants: &[],
    floats: &[],
};

gpu_struct! {
    /// Push constants: invocations, operations of each, and the last place, a power of two less one.
    pub struct CeilingPush {
        count: u32,
        rounds: u32,
        mask: u32,
    }
}

gpu_struct! {
    /// Push constants: how many words.
    pub struct EmptyPush {
        count: u32,
    }
}

pass! {
    @from SOURCES;
    /// Adds to words.
    pub Atomic(CeilingPush) = "ceilings/atomic" {
        words: ReadWrite<u32>,
        ends: ReadWrite<u32>,
    }

    /// Takes minima of 64-bit words.
    pub Wide(CeilingPush) = "ceilings/wide" {
        words: ReadWrite<u64>,
    }

    /// Reads 8 bytes at a time.
    pub Read(CeilingPush) = "ceilings/read" {
        pairs: Read<[u32; 2]>,
        ends: ReadWrite<u32>,
    }

    /// Does nothing that takes time.
    pub Empty(EmptyPush) = "ceilings/empty" {
        words: ReadWrite<u32>,
    }
}

/// Runs of each, of which the fastest counts.
const RUNS: usize = 5;

/// Invocations, operations of each, and sizes of the memory they go to.
struct Amount {
    count: u32,
    rounds: u32,
    bytes: &'static [u64],
    passes: usize,
}

const FULL: Amount = Amount { count: 1 << 22, rounds: 16, bytes: &[1 << 24, 1 << 27, 1 << 30], passes: 200 };
const QUICK: Amount = Amount { count: 1 << 14, rounds: 4, bytes: &[1 << 20], passes: 10 };

/// Prints a line for each rate; true if none failed.
pub fn run(device: &Device, bounds: Bounds) -> Result<bool> {
    let amount = if bounds.quick { QUICK } else { FULL };
    let work: [(&str, Measure); 6] = [
        ("calibration", calibration),
        ("passes", passes),
        ("atomics", atomics),
        ("minima", minima),
        ("reads", reads),
        ("copies", copies),
    ];
    let mut good = true;
    for (name, measure) in work {
        if bounds.is_over() {
            good = false;
            lines::put_missing("ceiling", json!({ "name": name }), "left_out", "the time was over");
        } else if let Err(error) = measure(device, &amount) {
            good = false;
            lines::put_missing("ceiling", json!({ "name": name }), "failed", &error.to_string());
        }
    }
    Ok(good)
}

type Measure = fn(&Device, &Amount) -> std::result::Result<(), Error>;

/// Prints a rate: of operations, or of bytes, in 10⁹ per second.
fn put_rate(name: &str, bytes: u64, amount: u64, unit: &str, time: Duration) {
    let rate = amount as f64 / time.as_secs_f64().max(f64::MIN_POSITIVE) / 1e9;
    let line =
        json!({ "name": name, "bytes": bytes, "rate": lines::rounded(rate), "unit": unit, "ms": lines::ms(time) });
    lines::put("ceiling", line);
}

/// The least time of some recordings of one pass.
fn least<'a>(
    device: &'a Device,
    record: impl Fn(&mut Recorder<'a>) -> std::result::Result<(), Error>,
) -> std::result::Result<Duration, Error> {
    let mut times = Vec::new();
    // The first pays for the pipeline.
    for _ in 0..=RUNS {
        let mut recorder = device.recorder()?;
        record(&mut recorder)?;
        let Submitted { passes, .. } = recorder.submit("ceilings")?;
        times.push(passes.last().map_or(Duration::ZERO, |pass| pass.gpu));
    }
    Ok(times.into_iter().skip(1).min().unwrap_or_default())
}

/// A pass over all invocations.
fn over<'a>(amount: &Amount) -> Run<'a> {
    Run::new(Dispatch::Invocations(amount.count.into()))
}

fn push(amount: &Amount, places: u64) -> CeilingPush {
    CeilingPush { count: amount.count, rounds: amount.rounds, mask: (places - 1) as u32 }
}

/// Memory of so many bytes; `None` where the device has none as large.
fn memory<T: GpuType>(device: &Device, bytes: u64) -> std::result::Result<Option<Buffer<T>>, Error> {
    let limits = device.limits();
    if bytes > limits.binding_bytes.min(limits.allocation_bytes).min(limits.heap_bytes / 4) {
        return Ok(None);
    }
    device.buffer("ceilings", bytes / size_of::<T>() as u64, Memory::Device).map(Some)
}

/// The fixed work of calibrations: a chain of four operations a step, and a copy.
fn calibration(device: &Device, _: &Amount) -> std::result::Result<(), Error> {
    let yardstick = Yardstick::new(device)?;
    // Twice, the first of which wakes the clocks.
    yardstick.measure()?;
    let found = yardstick.measure()?;
    put_rate("integer operations", 0, yardstick.operations(), "Gop/s", found.spin);
    put_rate("copy", yardstick.copied_bytes(), 2 * yardstick.copied_bytes(), "GB/s", found.copy);
    Ok(())
}

/// Copies and fills of large buffers.
fn copies(device: &Device, amount: &Amount) -> std::result::Result<(), Error> {
    for bytes in amount.bytes {
        let [from, to] = [memory::<u32>(device, *bytes)?, memory::<u32>(device, *bytes)?];
        let (Some(from), Some(to)) = (from, to) else { continue };
        let fill = least(device, |recorder| recorder.fill("ceilings/fill", from.all(), 0))?;
        put_rate("fill", *bytes, *bytes, "GB/s", fill);
        let copy = least(device, |recorder| recorder.copy("ceilings/copy", from.all(), to.all()))?;
        put_rate("copy", *bytes, 2 * bytes, "GB/s", copy);
    }
    Ok(())
}

/// Additions to 32-bit words.
fn atomics(device: &Device, amount: &Amount) -> std::result::Result<(), Error> {
    let ends = device.buffer::<u32>("ceilings ends", amount.count.into(), Memory::Device)?;
    let all = u64::from(amount.count) * u64::from(amount.rounds);
    let mut places = vec![("one word", 0, amount.bytes[0]), ("a word for 32 neighbors", 1, amount.bytes[0])];
    places.extend(amount.bytes.iter().map(|bytes| ("any word", 2, *bytes)));
    for (name, place, bytes) in places {
        let Some(words) = memory::<u32>(device, bytes)? else { continue };
        for returns in [0u32, 1] {
            let found = least(device, |recorder| {
                let variant = Variant::plain().with("PLACE", place).with("RETURNS", returns);
                let pass = Atomic { words: words.all(), ends: ends.all() };
                recorder.run(&pass, push(amount, words.len()), &over(amount).variant(variant))
            })?;
            let how = if returns == 1 { "with" } else { "without" };
            put_rate(&format!("additions to {name}, {how} the sum"), bytes, all, "Gop/s", found);
        }
    }
    Ok(())
}

/// Minima of 64-bit words, where the device has them.
fn minima(device: &Device, amount: &Amount) -> std::result::Result<(), Error> {
    if !device.info().int64_atomics {
        return Ok(());
    }
    let all = u64::from(amount.count) * u64::from(amount.rounds);
    for bytes in amount.bytes {
        let Some(words) = memory::<u64>(device, *bytes)? else { continue };
        let pass = || Wide { words: words.all() };
        let found = least(device, |recorder| recorder.run(&pass(), push(amount, words.len()), &over(amount)))?;
        put_rate("64-bit minima of any word", *bytes, all, "Gop/s", found);
    }
    Ok(())
}

/// Reads of 8 bytes.
fn reads(device: &Device, amount: &Amount) -> std::result::Result<(), Error> {
    let ends = device.buffer::<u32>("ceilings ends", amount.count.into(), Memory::Device)?;
    let all = 8 * u64::from(amount.count) * u64::from(amount.rounds);
    for bytes in amount.bytes {
        let Some(pairs) = memory::<[u32; 2]>(device, *bytes)? else { continue };
        // Reading what nobody wrote is an error.
        let mut recorder = device.recorder()?;
        recorder.fill("ceilings/fill", pairs.all(), 0)?;
        recorder.submit("ceilings")?;
        for (any, name) in [(0u32, "reads of neighbors"), (1, "reads of any 8 bytes")] {
            let found = least(device, |recorder| {
                let pass = Read { pairs: pairs.all(), ends: ends.all() };
                let variant = Variant::plain().with("ANY", any);
                recorder.run(&pass, push(amount, pairs.len()), &over(amount).variant(variant))
            })?;
            put_rate(name, *bytes, all, "GB/s", found);
        }
    }
    Ok(())
}

/// Passes that do nothing: each after the other or at once, with timestamps around each or around all.
fn passes(device: &Device, amount: &Amount) -> std::result::Result<(), Error> {
    let words = device.buffer::<u32>("ceilings words", 64 * amount.passes as u64, Memory::Device)?;
    let measure = |name: &str, stamps: Stamps, apart: bool| -> std::result::Result<(), Error> {
        let mut times = Vec::new();
        for _ in 0..=RUNS {
            let mut recorder = device.recorder_with(stamps)?;
            for number in 0..amount.passes as u64 {
                // Passes that write the same words wait for each other.
                let words = words.slice(if apart { 64 * number } else { 0 }, 64);
                recorder.run(&Empty { words }, EmptyPush { count: 64 }, &Run::new(Dispatch::Invocations(64)))?;
            }
            let Submitted { wall, whole, .. } = recorder.submit("ceilings")?;
            times.push(whole.unwrap_or(wall));
        }
        let least = times.into_iter().skip(1).min().unwrap_or_default() / amount.passes as u32;
        let us = lines::rounded(least.as_secs_f64() * 1e6);
        lines::put("ceiling", json!({ "name": name, "bytes": 0, "us": us }));
        Ok(())
    };
    measure("empty pass, each after the other", Stamps::Ends, false)?;
    measure("empty pass, all at once", Stamps::Ends, true)?;
    measure("empty pass, timed and counted", Stamps::Passes, false)
}

#[cfg(test)]
mod tests {
    use pellucid_gpu::shader::Shader;

    use super::*;

    #[test]
    fn the_shaders_fit_their_declarations() {
        let variants = |name: &'static str, count: u32| (0..count).map(move |i| Variant::plain().with(name, i));
        Shader::new::<Atomic<'_>>(variants("PLACE", 3)).check().expect("atomic");
        Shader::plain::<Wide<'_>>().check().expect("wide");
        Shader::new::<Read<'_>>(variants("ANY", 2)).check().expect("read");
        Shader::plain::<Empty<'_>>().check().expect("empty");
    }
}
