//! The building blocks of the methods: prefix sums and radix sorts. Integers, so exact.

use super::prelude::*;
use pellucid_engine::methods::Error;
use pellucid_engine::passes::radix::Radix;
use pellucid_engine::passes::scan::Scan;
use pellucid_gpu::Memory;
use pellucid_reference as reference;

pub(super) fn cases() -> Vec<Case> {
    let about = "prefix sums of zeros, ones, one large number and arbitrary numbers: wrong sums";
    let scan = |n: usize| one(&format!("scan/{n}-elements"), about, move |stage| sums(stage, n));
    let about = "a stable sort of arbitrary, few, equal and falling keys: records in the wrong place";
    let sort = |n: usize| one(&format!("radix/{n}-records"), about, move |stage| sort(stage, n));
    let scans = [1, 255, 256, 257, 4097, (1 << 20) + 1].map(scan);
    let sorts = [1, 255, 256, 257, 1025, 100_000].map(sort);
    let wrap = one("scan/overflow", "sums of 2^32 - 1 pass, larger sums are reported: wrong verdicts", overflow);
    scans.into_iter().chain([wrap]).chain(sorts).collect()
}

/// Numbers without a pattern.
fn any(n: usize) -> impl Iterator<Item = u32> {
    (0..n as u32).map(|i| i.wrapping_mul(2_654_435_761) ^ (i >> 3).wrapping_mul(2_246_822_519))
}

/// Prefix sums on the device, and true if it reports an overflow.
fn scan(stage: &CaseRenderer, values: &[u32]) -> Result<(Vec<u32>, bool)> {
    let (device, n) = (stage.device(), values.len() as u64);
    let input = device.upload("values", values)?;
    let output = device.buffer::<u32>("sums", n, Memory::Device)?;
    let scan = Scan::new(device, n)?;
    scan.overflow.upload(&[0])?;
    let mut recorder = device.recorder()?;
    scan.record(&mut recorder, input.all(), output.all())?;
    recorder.submit("scan")?;
    Ok((output.read(0, n)?, scan.overflow.read(0, 1)?.first() != Some(&0)))
}

fn sums(stage: &mut CaseRenderer, n: usize) -> CaseResult {
    let mut single = vec![0u32; n];
    single[n / 2] = 4_000_000_000;
    let contents = [vec![0; n], vec![1; n], any(n).map(|v| v % 4000).collect(), single];
    let (mut error, mut naive) = (0, 0);
    for values in contents {
        let (found, overflow) = scan(stage, &values)?;
        let wanted = reference::scan::exclusive(&values);
        error += found.iter().zip(&wanted).filter(|(a, b)| u64::from(**a) != **b).count() + usize::from(overflow);
        // Blocks of 256 by themselves; for one block, sums that hold their own number.
        let mut sum = 0u64;
        for (i, value) in values.iter().enumerate() {
            sum = if i % 256 == 0 { 0 } else { sum };
            let own = if n <= 256 { u64::from(*value) } else { 0 };
            naive += usize::from(sum + own != wanted[i]);
            sum += u64::from(*value);
        }
    }
    Ok(Finding::counted(error, naive))
}

fn overflow(stage: &mut CaseRenderer) -> CaseResult {
    let most = u32::MAX;
    let (mut error, mut naive) = (0, 0);
    for n in [2usize, 64, 65, 5000, 70_000] {
        for (first, last, beyond) in [(most - 1, 1, false), (most, 1, true), (1, most, true), (most, most, true)] {
            let mut values = vec![0u32; n];
            (values[0], values[n - 1]) = (first, last);
            error += usize::from(scan(stage, &values)?.1 != beyond);
            // A sum that wraps looks valid on its own.
            let sum = values.iter().fold(0u32, |sum, value| sum.wrapping_add(*value));
            naive += usize::from((u64::from(sum) > u64::from(most)) != beyond);
        }
    }
    Ok(Finding::counted(error, naive))
}

/// Records sorted by the lowest bits of their keys on the device.
fn sorted(stage: &CaseRenderer, records: &[[u32; 2]], bits: u32) -> Result<Vec<[u32; 2]>> {
    let (device, n) = (stage.device(), records.len() as u64);
    let none = || Error::NoSubgroups { device: device.info().name.clone() };
    let subgroup = device.info().subgroup.ok_or_else(none)?;
    let from = device.upload("records", records)?;
    let to = device.buffer("moved", n, Memory::Device)?;
    let mut radix = Radix::new(device)?;
    radix.reserve(device, n)?;
    let mut recorder = device.recorder()?;
    let place = radix.record(&mut recorder, [from.all(), to.all()], bits, subgroup)?;
    recorder.submit("radix")?;
    Ok([from, to][place].read(0, n)?)
}

fn sort(stage: &mut CaseRenderer, n: usize) -> CaseResult {
    let keys =
        [any(n).collect::<Vec<u32>>(), any(n).map(|k| k % 3).collect(), vec![7; n], (0..n as u32).rev().collect()];
    let (mut error, mut naive) = (0, 0);
    for keys in keys {
        let records: Vec<[u32; 2]> = keys.iter().zip(0..).map(|(key, i)| [*key, i]).collect();
        let mut wanted = records.clone();
        wanted.sort_by_key(|[key, _]| *key);
        let apart = |found: &[[u32; 2]]| found.iter().zip(&wanted).filter(|(a, b)| a != b).count();
        error += apart(&sorted(stage, &records, 32)?);
        // Equal keys in any order: here, backward.
        let mut backward = records;
        backward.sort_by_key(|[key, i]| (*key, u32::MAX - i));
        naive += apart(&backward);
    }
    let why = "one record is in its place however it is sorted; it is here as the shortest list";
    Ok(if n == 1 { Finding::stated(error as f64, 0.0, why) } else { Finding::counted(error, naive) })
}
