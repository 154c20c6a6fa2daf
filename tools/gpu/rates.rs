//! Opaque points, sort and scan by their number: up to what fits.

use std::time::Duration;

use glam::{DVec3, Vec3};
use pellucid_core::camera::{Camera, Projection};
use pellucid_core::points::Points;
use pellucid_engine::methods::{self, Frame, Outputs, Renderer};
use pellucid_engine::passes::radix::Radix;
use pellucid_engine::passes::scan::Scan;
use pellucid_engine::totals::{self, Effort};
use pellucid_engine::{Error, Result};
use pellucid_gpu::{Device, Memory, Stamps, Yardstick};
use pellucid_io::has_memory;
use pellucid_scene::Method;
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::{Bounds, lines};

/// Numbers of points, of records that are sorted, and of counters that are summed.
struct Numbers {
    points: &'static [u64],
    records: &'static [u64],
    size: [u32; 2],
}

const FULL: Numbers = Numbers {
    points: &[10_000_000, 100_000_000, 260_000_000, 1_000_000_000],
    records: &[100_000, 1_000_000, 10_000_000, 100_000_000],
    size: [1920, 1080],
};
const QUICK: Numbers = Numbers { points: &[20_000], records: &[20_000], size: [96, 64] };

/// Bytes of a point on the host: those of its columns.
const HOST_BYTES: u64 = 44;
/// Runs of a sort or a scan, of which the fastest counts.
const RUNS: usize = 5;

/// Prints a line for each number and order; true if none failed.
pub fn run(device: &Device, bounds: Bounds) -> Result<bool> {
    let numbers = if bounds.quick { QUICK } else { FULL };
    let mut good = true;
    for count in numbers.records {
        good &= put("sort", *count, "any", bounds, || sort(device, *count));
        good &= put("scan", *count, "any", bounds, || scan(device, *count));
    }
    let yardstick = Yardstick::new(device)?;
    for count in numbers.points {
        for (order, is_shuffled) in [("along the curve", false), ("shuffled", true)] {
            good &= put("points", *count, order, bounds, || {
                if !has_memory(HOST_BYTES * count) {
                    return Ok(json!({ "refused": "the host has no memory for them" }));
                }
                draw(device, &yardstick, &cube(*count, is_shuffled), numbers.size, bounds)
            });
        }
    }
    Ok(good)
}

/// Prints what was found; false if it failed or was left out.
fn put(
    what: &str,
    count: u64,
    order: &str,
    bounds: Bounds,
    measure: impl FnOnce() -> std::result::Result<Value, Error>,
) -> bool {
    let mut line = json!({ "what": what, "count": count, "order": order });
    if bounds.is_over() {
        lines::put_missing("rate", line, "left_out", "the time was over");
        return false;
    }
    match measure() {
        Ok(found) => {
            for (key, value) in found.as_object().into_iter().flatten() {
                line[key.as_str()] = value.clone();
            }
            lines::put("rate", line);
            true
        }
        Err(error) => {
            let text = error.to_string();
            let refused = match error {
                Error::Render(error) => error.is_refusal(),
                Error::Gpu(error) => methods::Error::from(error).is_refusal(),
                _ => false,
            };
            lines::put_missing("rate", line, if refused { "refused" } else { "failed" }, &text);
            refused
        }
    }
}

/// 10⁹ of so many things per second.
fn rate(count: u64, time: Duration) -> Value {
    lines::rounded(count as f64 / time.as_secs_f64().max(f64::MIN_POSITIVE) / 1e9)
}

/// A stable sort of 32-bit keys with their values.
fn sort(device: &Device, count: u64) -> std::result::Result<Value, Error> {
    let Some(subgroup) = device.info().subgroup else { return Ok(json!({ "refused": "no subgroups" })) };
    let mixed = |i: u64| (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as u32;
    let records: Vec<[u32; 2]> = (0..count).into_par_iter().map(|i| [mixed(i), i as u32]).collect();
    let kept = device.upload("records", &records)?;
    let from = device.buffer::<[u32; 2]>("records to sort", count, Memory::Device)?;
    let to = device.buffer::<[u32; 2]>("records moved", count, Memory::Device)?;
    let mut radix = Radix::new(device)?;
    radix.reserve(device, count)?;
    let mut times = Vec::new();
    for _ in 0..=RUNS {
        let mut recorder = device.plain_recorder()?;
        recorder.copy("rates/copy", kept.all(), from.all())?;
        recorder.submit("records")?;
        let mut recorder = device.recorder_with(Stamps::Ends)?;
        radix.record(&mut recorder, [from.all(), to.all()], 32, subgroup)?;
        times.push(recorder.submit("sort")?.whole.unwrap_or_default());
    }
    let least = times.into_iter().skip(1).min().unwrap_or_default();
    Ok(json!({ "ms": lines::ms(least), "rate": rate(count, least), "unit": "G records/s" }))
}

/// Prefix sums.
fn scan(device: &Device, count: u64) -> std::result::Result<Value, Error> {
    let values = device.buffer::<u32>("counters", count, Memory::Device)?;
    let offsets = device.buffer::<u32>("offsets", count, Memory::Device)?;
    let scan = Scan::new(device, count)?;
    let mut recorder = device.plain_recorder()?;
    recorder.fill("rates/fill", values.all(), 1)?;
    recorder.fill("rates/fill", scan.overflow.all(), 0)?;
    recorder.submit("counters")?;
    let mut times = Vec::new();
    for _ in 0..=RUNS {
        let mut recorder = device.recorder_with(Stamps::Ends)?;
        scan.record(&mut recorder, values.all(), offsets.all())?;
        times.push(recorder.submit("scan")?.whole.unwrap_or_default());
    }
    let least = times.into_iter().skip(1).min().unwrap_or_default();
    Ok(json!({ "ms": lines::ms(least), "rate": rate(count, least), "unit": "G counters/s" }))
}

/// Points in a cube along the Morton curve, or the same points in an order that jumps.
fn cube(count: u64, is_shuffled: bool) -> Points {
    // An odd number near the golden ratio of the next power of two: a permutation of its places, of which those beyond
    // the points are left out.
    let power = count.next_power_of_two();
    let step = ((power as f64 * 0.618_034) as u64) | 1;
    let place = |i: u64| if is_shuffled { i.wrapping_mul(step) & (power - 1) } else { i };
    let numbers = if is_shuffled { power } else { count };
    let places = (0..numbers).into_par_iter().map(place).filter(|place| *place < count);
    let (positions, colors): (Vec<DVec3>, Vec<Vec3>) = places.map(|i| point(i, count)).unzip();
    Points {
        opacities: vec![1.0; positions.len()],
        radii: vec![0.0; positions.len()],
        positions,
        colors,
        ..Points::default()
    }
}

/// Position and color of the i-th of `count` points along the curve through the unit cube.
fn point(i: u64, count: u64) -> (DVec3, Vec3) {
    // Places along the curve of 60 bits, 20 for each axis.
    let code = ((u128::from(i) << 60) / u128::from(count.max(1))) as u64;
    let axis =
        |first: u32| (0..20).fold(0u32, |found, bit| found | ((((code >> (3 * bit + first)) & 1) as u32) << bit));
    let unit = [axis(0), axis(1), axis(2)].map(|axis| f64::from(axis) / f64::from(1 << 20));
    let position = DVec3::from_array(unit) - 0.5;
    (position, DVec3::from_array(unit).as_vec3())
}

fn draw(
    device: &Device,
    yardstick: &Yardstick,
    points: &Points,
    size: [u32; 2],
    bounds: Bounds,
) -> std::result::Result<Value, Error> {
    let projection = Projection::Perspective { fov_y: 40f64.to_radians() };
    let camera = Camera::look_at(DVec3::new(1.6, -1.3, 1.1), DVec3::ZERO, DVec3::Z, projection, 0.1, 10.0);
    let Some(camera) = camera else { return Ok(json!({ "refused": "no camera" })) };
    let frame = Frame { outputs: Outputs::SCREEN, ..Frame::new(camera, size, Method::Points) };
    let mut renderer = Renderer::new(device)?;
    let mut cloud = renderer.upload(points)?;
    let effort = if bounds.quick { Effort::LOOK } else { Effort::RELIABLE };
    let totals = totals::measure(&mut renderer, &mut cloud, &frame, Some(yardstick), effort)?;
    device.check_validation()?;
    let mut found = lines::all_rounded(totals.to_json());
    let rate = points.len() as f64 / totals.device.median.max(f64::MIN_POSITIVE) / 1e6;
    found["rate"] = lines::rounded(rate);
    found["unit"] = "G points/s".into();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn points_along_the_curve_are_those_of_any_order() {
        let bits = |points: &Points| -> Vec<[u64; 3]> {
            points.positions.iter().map(|position| position.to_array().map(f64::to_bits)).collect()
        };
        let (ordered, shuffled) = (bits(&cube(1000, false)), bits(&cube(1000, true)));
        assert!(ordered.len() == 1000 && ordered != shuffled);
        assert_eq!(ordered.iter().collect::<HashSet<_>>(), shuffled.iter().collect::<HashSet<_>>());
        assert_eq!(shuffled.iter().collect::<HashSet<_>>().len(), 1000);
    }

    #[test]
    fn the_curve_of_eight_points_visits_the_corners_of_a_cube() {
        // x is the lowest bit.
        let corner = |i: u64| point(i, 8).0;
        assert_eq!(corner(0), DVec3::new(-0.5, -0.5, -0.5));
        assert_eq!(corner(1), DVec3::new(0.0, -0.5, -0.5));
        assert_eq!(corner(6), DVec3::new(-0.5, 0.0, 0.0));
        assert_eq!(corner(7), DVec3::ZERO);
    }
}
