//! Prefix sums on the device against the float64 reference's u64 sums: integers, so exactly.

use pellucid_engine::passes::scan::Scan;
use pellucid_gpu::{Device, Memory, Preferences};
use pellucid_reference as reference;
use pellucid_testing::{random, with_device_that_prefers};
use rand::RngExt;

/// Offsets and the overflow flag.
fn scan(device: &Device, values: &[u32]) -> (Vec<u32>, u32) {
    let n = values.len() as u64;
    let input = device.upload("values", values).expect("fits");
    let output = device.buffer::<u32>("offsets", n, Memory::Device).expect("fits");
    let scan = Scan::new(device, n).expect("fits");
    scan.overflow.upload(&[0]).expect("uploaded");
    let mut recorder = device.recorder().expect("a recorder");
    scan.record(&mut recorder, input.all(), output.all()).expect("recorded");
    recorder.submit("scan").expect("submitted");
    (output.read(0, n).expect("read"), scan.overflow.read(0, 1).expect("read")[0])
}

fn expected(values: &[u32]) -> Vec<u64> {
    let mut sums = reference::scan::exclusive(values);
    sums.truncate(values.len());
    sums
}

#[test]
fn any_length_and_content() {
    for prefers in [Preferences::CPU, Preferences::GPU] {
        with_device_that_prefers(prefers, scans_of_any_length);
    }
}

fn scans_of_any_length(device: &Device) {
    let mut r = random(7);
    for n in [1usize, 2, 63, 64, 65, 255, 256, 257, 2047, 2048, 2049, 4097, 262_144, (1 << 20) + 1, (4 << 20) + 5] {
        let mut single = vec![0u32; n];
        single[n / 2] = 4_000_000_000;
        let contents = [vec![0u32; n], vec![1; n], (0..n).map(|_| r.random_range(0..1000)).collect(), single];
        for values in contents {
            let (offsets, overflow) = scan(device, &values);
            let wanted = expected(&values);
            assert!(offsets.iter().zip(&wanted).all(|(a, b)| u64::from(*a) == *b), "length {n}");
            assert_eq!(overflow, 0, "length {n}");
        }
    }
}

#[test]
fn totals_over_32_bits_are_detected_and_not_wrapped() {
    for prefers in [Preferences::CPU, Preferences::GPU] {
        with_device_that_prefers(prefers, totals_over_32_bits);
    }
}

fn totals_over_32_bits(device: &Device) {
    let most = u32::MAX;
    for n in [2usize, 64, 65, 5000, 300_000] {
        // Exactly 2^32 − 1 in all fits; one more does not, wherever it lies.
        for (first, last, flag) in [(most - 1, 1, 0), (most, 1, 1), (1, most, 1)] {
            let mut values = vec![0u32; n];
            values[0] = first;
            values[n - 1] = last;
            assert_eq!(scan(device, &values).1, flag, "{first} and {last} over {n}");
        }
        assert_eq!(scan(device, &vec![most; n]).1, 1, "all large over {n}");
    }
}
