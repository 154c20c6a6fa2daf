//! The radix sort on the device against a stable sort on the host: integers, so exactly.

mod common;

use common::{random, with_device};
use pellucid::gpu::{Device, Memory};
use pellucid::passes::radix::Radix;
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
    let result = radix.record(&mut recorder, device, [from.all(), to.all()], bits, subgroup).expect("recorded");
    recorder.submit("radix").expect("submitted");
    [from, to][result].read(0, n).expect("read")
}

#[test]
fn any_length_and_content_in_order_of_arrival() {
    with_device(|device| {
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
                    assert!(sorted(device, &keys, bits) == wanted, "{n} records of {bits} bits");
                }
            }
        }
    });
}
