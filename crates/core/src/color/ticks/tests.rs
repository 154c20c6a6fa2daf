use super::*;
use crate::color::colormap::Colormap;

fn labels(low: f64, high: f64, log: bool) -> Vec<String> {
    Scale::between([low, high], log).ticks(6, false).into_iter().map(|tick| tick.label).collect()
}

#[test]
fn numbers_worked_by_hand() {
    for (low, high, wanted) in [
        (0.0, 1.0, &["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"][..]),
        (-7.3, 12.1, &["-5", "0", "5", "10"]),
        (636_000.02, 636_000.05, &["636000.02", "636000.03", "636000.04", "636000.05"]),
        (0.0, 60_000.0, &["0", "20000", "40000", "60000"]),
        (-0.9, -0.1, &["-0.8", "-0.6", "-0.4", "-0.2"]),
        (0.0, 5e7, &["0", "1e7", "2e7", "3e7", "4e7", "5e7"]),
        (1.2e-9, 3.9e-9, &["1.5e-9", "2.0e-9", "2.5e-9", "3.0e-9", "3.5e-9"]),
        (-f64::MAX, f64::MAX, &["-1e308", "0", "1e308"]),
    ] {
        assert_eq!(labels(low, high, false), wanted, "{low} to {high}");
    }
}

#[test]
fn logarithms_worked_by_hand() {
    for (low, high, wanted) in [
        (1.0, 100.0, &["1", "10", "100"][..]),
        (2.0, 99.0, &["2", "5", "10", "20", "50"]),
        (0.9, 1.1e4, &["1", "10", "100", "1000", "10000"]),
        (1e-8, 1e3, &["1e-8", "1e-6", "1e-4", "1e-2", "1e0", "1e2"]),
        // No two of 1, 2, 5 lie between 3 and 4, so that steps are even.
        (3.0, 4.0, &["3.0", "3.2", "3.4", "3.6", "3.8", "4.0"]),
        (0.13, 0.6, &["0.2", "0.5"]),
    ] {
        assert_eq!(labels(low, high, true), wanted, "{low} to {high}");
    }
}

#[test]
fn scales_without_room_for_round_numbers() {
    for (value, wanted) in [(7.0, "7"), (-0.25, "-0.25"), (f64::from(0.1_f32), "0.1"), (636_000.023, "636000.023")] {
        let ticks = Scale::between([value; 2], false).ticks(6, false);
        assert_eq!(ticks, [Tick { value, place: 0.0, label: wanted.to_owned() }]);
    }
    assert_eq!(labels(5.0, 5.0, true), ["5"]);
    // The next float64 value after 1.
    assert_eq!(labels(1.0, 1.0 + f64::EPSILON, false), ["1", "1.0000000000000002"]);
}

#[test]
fn whole_numbers_where_two_of_them_fit() {
    let whole = |low, high| Scale::between([low, high], false).ticks(6, true);
    let text = |ticks: Vec<Tick>| ticks.into_iter().map(|tick| tick.label).collect::<Vec<_>>();
    assert_eq!(text(whole(1.0, 3.0)), ["1", "2", "3"]);
    assert_eq!(text(whole(1.2, 1.9)), ["1.2", "1.4", "1.6", "1.8"]);
    assert_eq!(text(whole(1.0, 40.0)), ["10", "20", "30", "40"]);
}

/// The numbers of a generator, from 0 to 1.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1u64 << 53) as f64
}

/// The color that the definition of `color_by` gives a value: t = (v - low) / (high - low), of logarithms with log;
/// linear between the entries that are nearest to t.
fn defined(map: &Colormap, value: f64, [low, high]: [f64; 2], log: bool, reverse: bool) -> [f64; 3] {
    let f = |x: f64| if log { x.log2() } else { x };
    let t = (f(value) - f(low)) / (f(high) - f(low));
    let place = 255.0 * if reverse { 1.0 - t } else { t };
    let entry = |i: f64| map.srgb(i / 255.0).to_array();
    let (below, above) = (entry(place.floor().clamp(0.0, 255.0)), entry(place.ceil().clamp(0.0, 255.0)));
    [0, 1, 2].map(|c| below[c] + (place - place.floor()) * (above[c] - below[c]))
}

#[test]
fn every_tick_is_its_label_and_stands_at_its_color() {
    let map = Colormap::named("viridis").unwrap();
    let mut seed = 5;
    for case in 0..4000 {
        let log = case % 2 == 1;
        let size = 10f64.powf(20.0 * random(&mut seed) - 10.0);
        let offset = if log { 0.0 } else { (random(&mut seed) - 0.5) * 10f64.powf(6.0 * random(&mut seed)) * size };
        let low = offset + size * random(&mut seed);
        let high = low + size * (0.01 + 10f64.powf(3.0 * random(&mut seed)));
        let scale = Scale::between([low, high], log);
        let ticks = scale.ticks(6, false);
        assert!((2..=8).contains(&ticks.len()), "{low} to {high}: {ticks:?}");
        for tick in &ticks {
            assert_eq!(tick.label.parse::<f64>().unwrap(), tick.value, "{low} to {high}");
            assert!(tick.value >= low && tick.value <= high);
            let reverse = case % 3 == 0;
            let wanted = defined(&map, tick.value, [low, high], log, reverse);
            let found = map.srgb(if reverse { 1.0 - tick.place } else { tick.place }).to_array();
            // The range is at least 1e-6 of its ends, so that cancellation leaves t exact to some 1e-9; a step between
            // two entries changes a color by at most 255 * 0.03 per t.
            let off = (0..3).map(|c| (found[c] - wanted[c]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-7, "{low} to {high}: {tick:?} off by {off}");
        }
        let mut labels: Vec<_> = ticks.iter().map(|tick| &tick.label).collect();
        labels.dedup();
        assert_eq!(labels.len(), ticks.len(), "labels tell ticks apart");
        assert!(ticks.is_sorted_by(|a, b| a.place < b.place), "{ticks:?}");
    }
}

#[test]
fn lengths_of_scale_bars() {
    for (most, length, label) in [
        (1.0, 1.0, "1"),
        (0.999, 0.5, "0.5"),
        (4.9, 2.0, "2"),
        (50.0, 50.0, "50"),
        (0.3, 0.2, "0.2"),
        (0.1, 0.1, "0.1"),
        (7.2e9, 5e9, "5e9"),
        (3e-8, 2e-8, "2e-8"),
        (1234.0, 1000.0, "1000"),
    ] {
        assert_eq!(round_below(most), Some((length, label.to_owned())));
    }
    for most in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(round_below(most), None);
    }
}
