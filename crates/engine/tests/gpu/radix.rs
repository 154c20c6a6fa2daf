//! The radix sort on the device against a stable sort on the host: integers, so exactly.

use pellucid_engine::passes::radix::{self, Radix, RadixPush};
use pellucid_engine::passes::scan::Scan;
use pellucid_gpu::{Device, DeviceOptions, Dispatch, Memory, Preferences, Run};
use pellucid_testing::{alone, random, with_device_that_prefers};
use rand::RngExt;

fn sorted(device: &Device, keys: &[u32], bits: u32) -> Vec<[u32; 2]> {
    let records: Vec<[u32; 2]> = keys.iter().zip(0..).map(|(key, i)| [*key, i]).collect();
    let n = records.len() as u64;
    let from = device.upload("records", &records).expect("fits");
    let to = device.buffer("moved", n, Memory::Device).expect("fits");
    let mut radix = Radix::new(device).expect("fits");
    radix.reserve(device, n).expect("fits");
    let subgroup = device.info().subgroup.expect("a device with subgroups of 8 to 32");
    let mut recorder = device.recorder().expect("a recorder");
    let result = radix.record(&mut recorder, [from.all(), to.all()], bits, subgroup).expect("recorded");
    recorder.submit("radix").expect("submitted");
    [from, to][result].read(0, n).expect("read")
}

/// The values alone, in the order of the lowest bits of their keys.
fn sorted_values(device: &Device, keys: &[u32], bits: u32) -> Vec<u32> {
    let records: Vec<[u32; 2]> = keys.iter().zip(0..).map(|(key, i)| [*key, i]).collect();
    let n = records.len() as u64;
    let from = device.upload("records", &records).expect("fits");
    let to = device.buffer("moved", n, Memory::Device).expect("fits");
    let values = device.buffer("values", n, Memory::Device).expect("fits");
    let mut radix = Radix::new(device).expect("fits");
    radix.reserve(device, n).expect("fits");
    let subgroup = device.info().subgroup.expect("a device with subgroups of 8 to 32");
    let mut recorder = device.recorder().expect("a recorder");
    radix.record_values(&mut recorder, [from.all(), to.all()], bits, subgroup, values.all()).expect("recorded");
    recorder.submit("radix").expect("submitted");
    values.read(0, n).expect("read")
}

#[test]
fn values_alone_are_those_of_the_sorted_records() {
    for prefers in [Preferences::CPU, Preferences::GPU] {
        with_device_that_prefers(prefers, |device| {
            let mut r = random(12);
            for (n, bits) in [(1usize, 1), (1000, 8), (5000, 13), (70_000, 20)] {
                let keys: Vec<u32> = (0..n).map(|_| r.random::<u32>() & (u32::MAX >> (32 - bits))).collect();
                let mut wanted: Vec<u32> = (0..n as u32).collect();
                wanted.sort_by_key(|i| keys[*i as usize]);
                assert!(sorted_values(device, &keys, bits) == wanted, "{n} records of {bits} bits, {prefers:?}");
            }
        });
    }
}

#[test]
fn any_length_and_content_in_order_of_arrival() {
    for prefers in [Preferences::CPU, Preferences::GPU] {
        with_device_that_prefers(prefers, |device| {
            let mut r = random(11);
            for n in [1usize, 2, 7, 8, 9, 1023, 1024, 1025, 4097, 200_000] {
                for bits in [1, 9, 10, 25, 32] {
                    let mask = u32::MAX >> (32 - bits);
                    let few = (0..n).map(|_| r.random_range(0..3) & mask).collect::<Vec<u32>>();
                    let any = (0..n).map(|_| r.random::<u32>() & mask).collect();
                    let falling = (0..n as u32).rev().map(|i| i & mask).collect();
                    for keys in [few, any, falling, vec![mask; n]] {
                        let mut wanted: Vec<[u32; 2]> = keys.iter().zip(0..).map(|(key, i)| [*key, i]).collect();
                        wanted.sort_by_key(|[key, _]| *key);
                        assert!(sorted(device, &keys, bits) == wanted, "{n} records of {bits} bits, {prefers:?}");
                    }
                }
            }
        });
    }
}

/// One digit of one run of 1000 records counted, and `stored` of them scattered: what the comparison of the two says.
fn scattered(device: &Device, stored: u32) -> Result<(), String> {
    let (count, run_length) = (1000u32, 2048);
    let records: Vec<[u32; 2]> = (0..2 * count).map(|i| [i * 7 % 16, i]).collect();
    let records = device.upload("records", &records).expect("fits");
    let moved = device.buffer("moved", u64::from(count), Memory::Device).expect("fits");
    let counts = device.upload("digit counts", &[0u32; 16]).expect("fits");
    let cursors = device.buffer("digit cursors", 16, Memory::Device).expect("fits");
    let scan = Scan::new(device, 16).expect("fits");
    let push = |count| RadixPush { count, runs: 1, run_length, shift: 0, mask: 15 };
    let run = || Run::new(Dispatch::Groups(1));
    let variant = radix::scatter_variant(device.info().subgroup.expect("a device with subgroups of 8 to 32"));
    let (records, counts, cursors) = (records.all(), counts.all(), cursors.all());
    let mut recorder = device.recorder().expect("a recorder");
    recorder.run(&radix::Count { records, counts }, push(count), &run()).expect("recorded");
    scan.record(&mut recorder, counts, cursors).expect("recorded");
    let scatter = radix::Scatter { records, cursors, moved: moved.all() };
    recorder.run(&scatter, push(stored), &run().variant(variant)).expect("recorded");
    radix::agree(&mut recorder, counts, cursors, count).expect("recorded");
    recorder.submit("radix").map(drop).map_err(|e| e.to_string())
}

#[test]
fn one_record_more_or_less_than_counted_is_found_with_and_without_robust_access() {
    alone(|| {
        for robust in [false, true] {
            let options = DeviceOptions { robust, gpu_assisted: false, ..DeviceOptions::validated() };
            let device = Device::open(&options).expect("a device");
            scattered(&device, 1000).expect("all that were counted");
            // Digits are 7 i mod 16: record 999 has digit 1, record 1000 has 8. Of 1000 records those of i mod 16 < 8
            // are 63 a digit, the others 62, so that digits 0 and 1 have 126 together, and 0 to 8 some 4 · 62 + 5 · 63.
            for (stored, wanted) in [(999, "1 ends at 125 instead of 126"), (1001, "8 ends at 564 instead of 563")] {
                let error = scattered(&device, stored).expect_err("one more or less");
                let wanted =
                    format!("radix/scatter did not store what was counted: digit of a run {wanted} (2 of 15 differ)");
                assert_eq!(error, wanted);
            }
        }
    });
}
