//! Compares the same forty splats in every format (tests/data/splats), as far as each format keeps them.

use glam::{DVec3, Quat};
use pellucid_core::cloud::filter::Filter;
use pellucid_core::cloud::gaussians::coefficients;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::progress::Progress;
use pellucid_io::{Hints, store};

use super::super::load;
use super::folder;

/// Largest distances of splats from those of `soup.ply`.
struct Bounds {
    position: f64,
    /// Difference of the logarithm of an extent.
    scale: f32,
    /// Angle between rotations, in radians.
    rotation: f64,
    base: f32,
    alpha: f32,
    harmonic: f32,
}

/// Rounding to float32.
const EXACT: Bounds = Bounds { position: 1e-6, scale: 1e-6, rotation: 1e-6, base: 1e-6, alpha: 1e-6, harmonic: 1e-6 };

/// Half a step of a byte that stands for 0 to 1, and of one for −1 to 1; rounding.
const UNIT: f32 = 0.5 / 255.0 + 1e-6;
const SIGNED: f32 = 1.0 / 255.0 + 1e-6;

/// Largest error of four parts within a step of 1/511/√2: each of three is off by half of it, the largest by as much as
/// all of them, twice for an angle.
const SMALLEST_THREE: f64 = 2.0 * 2.0 * 1.732 * 0.5 / 511.0 * 0.707_2;

/// Centers of 24 bits behind 12 of the fraction, logarithms of extents in sixteenths; a byte of color is 0.15/Y₀ of a
/// display value.
const SPZ: Bounds = Bounds {
    position: 1.7321 * 0.5 / 4096.0,
    scale: 1.0 / 32.0 + 1e-5,
    rotation: SMALLEST_THREE,
    base: 0.282_094_8 / 0.15 * UNIT,
    alpha: UNIT,
    harmonic: 0.5 / 128.0 + 1e-6,
};

fn soup() -> Cloud {
    load(&folder().join("soup.ply")).unwrap()
}

/// Finds, for each splat of a cloud, the nearest one in another.
fn nearest(from: &Cloud, to: &Cloud) -> Vec<usize> {
    let distance = |at: usize, p: DVec3| to.positions[at].distance(p);
    let nearest = |p: &DVec3| (0..to.len()).min_by(|a, b| distance(*a, *p).total_cmp(&distance(*b, *p))).unwrap();
    from.positions.iter().map(nearest).collect()
}

/// Half the angle between two rotations tells their product; for small angles its imaginary part does.
fn angle(a: Quat, b: Quat) -> f64 {
    let turn = a.as_dquat().inverse() * b.as_dquat();
    2.0 * turn.xyz().length().atan2(turn.w.abs())
}

/// Asserts that two clouds hold the same splats, in any order, with harmonics up to the lower degree.
#[track_caller]
fn assert_same(cloud: &Cloud, expected: &Cloud, bounds: &Bounds, name: &str) {
    assert_eq!((cloud.len(), cloud.non_finite), (expected.len(), 0), "{name}");
    let places = nearest(expected, cloud);
    let mut sorted = places.clone();
    sorted.sort_unstable();
    assert!(sorted.iter().copied().eq(0..cloud.len()), "{name}: splats stand for each other");
    let (own, other) = (cloud.gaussians.as_ref().unwrap(), expected.gaussians.as_ref().unwrap());
    let count = coefficients(own.degree.min(other.degree));
    for (b, a) in places.into_iter().enumerate() {
        let off = cloud.positions[a].distance(expected.positions[b]);
        assert!(off <= bounds.position, "{name}: position {off}");
        let off = (own.extents[a].map(f32::ln) - other.extents[b].map(f32::ln)).abs().max_element();
        assert!(off <= bounds.scale, "{name}: ln extent {off}");
        let off = angle(own.rotations[a], other.rotations[b]);
        assert!(off <= bounds.rotation, "{name}: rotation {off}");
        let off = (own.bases[a] - other.bases[b]).abs().max_element();
        assert!(off <= bounds.base, "{name}: base {off}");
        let off = (cloud.alphas.as_ref().unwrap()[a] - expected.alphas.as_ref().unwrap()[b]).abs();
        assert!(off <= bounds.alpha, "{name}: alpha {off}");
        let pairs = own.harmonics_of(a)[..count].iter().zip(&other.harmonics_of(b)[..count]);
        let off = pairs.map(|(a, b)| (*a - *b).abs().max_element()).fold(0.0, f32::max);
        assert!(off <= bounds.harmonic, "{name}: harmonic {off}");
    }
}

#[track_caller]
fn assert_reads_as_soup(name: &str, degree: u32, filter: Option<Filter>, bounds: &Bounds) {
    let cloud = load(&folder().join(name)).unwrap();
    assert_eq!(cloud.gaussians.as_ref().unwrap().degree, degree, "{name}");
    assert_eq!((cloud.up, cloud.filter, cloud.warnings.len()), (UpAxis::NegativeY, filter, 0), "{name}");
    assert_same(&cloud, &soup(), bounds, name);
}

#[test]
fn a_ply_file_holds_random_splats() {
    let soup = soup();
    let gaussians = soup.gaussians.as_ref().unwrap();
    assert_eq!((soup.len(), gaussians.degree, soup.filter), (40, 2, Some(Filter::Mip)));
    let closest = |at: usize| {
        let others = (0..40).filter(|other| *other != at);
        others.map(|other| soup.positions[at].distance(soup.positions[other])).fold(f64::INFINITY, f64::min)
    };
    let closest = (0..40).map(closest).fold(f64::INFINITY, f64::min);
    assert!(closest > 0.05, "{closest}: too close to be told apart by their places");
}

#[test]
fn splat() {
    // Four parts of a quaternion, each off by half a step of 1/128.
    let bounds = Bounds { rotation: 2.0 * 2.0 / 256.0, base: UNIT, alpha: UNIT, ..EXACT };
    assert_reads_as_soup("soup.splat", 0, None, &bounds);
}

#[test]
fn ksplat() {
    let floats = Bounds { base: UNIT, alpha: UNIT, ..EXACT };
    assert_reads_as_soup("soup-mode0.ksplat", 2, None, &floats);
    // Steps of 8/2/32767 of the center; ten bits and a hidden one of the others.
    let half = 0.5_f32.powi(11);
    let halves = Bounds {
        position: 1.7321 * 2.0 / 32767.0 + 1e-6,
        scale: half,
        rotation: 2.0 * 2.0 * f64::from(half),
        harmonic: half,
        ..floats
    };
    assert_reads_as_soup("soup-mode1.ksplat", 2, None, &halves);
    assert_reads_as_soup("soup-mode2.ksplat", 2, None, &Bounds { harmonic: SIGNED, ..halves });
}

#[test]
fn spz() {
    // w follows from the others, each off by half a step of 1/127.5; near zero it is off by the root of what they are
    // off.
    let three = (3.0_f64).sqrt() * 0.5 / 127.5;
    let rotation = 2.0 * (three * three + 2.0 * three).sqrt();
    // Float16 below 4 has steps of 1/512.
    let halves = Bounds { position: 1.7321 * 0.5 / 512.0, rotation, ..SPZ };
    assert_reads_as_soup("soup-v1.spz", 2, Some(Filter::Mip), &halves);
    assert_reads_as_soup("soup-v2.spz", 2, Some(Filter::Mip), &Bounds { rotation, ..SPZ });
    // Their writer keeps four bits of the harmonics of degree 2, as multiples of 16, after rounding to a byte.
    let harmonic = (8.0 + 0.5) / 128.0 + 1e-6;
    for name in ["soup-v3.spz", "soup-v4.spz"] {
        assert_reads_as_soup(name, 2, None, &Bounds { harmonic, ..SPZ });
    }
}

#[test]
fn compressed_ply() {
    // 11, 10 and 11 bits of 6 units of the center and of 4 of the logarithms; a byte of 8 units of harmonics.
    let step = |range: f64, bits: i32| range / (2.0_f64.powi(bits) - 1.0) / 2.0;
    let bounds = Bounds {
        position: DVec3::new(step(6.0, 11), step(6.0, 10), step(6.0, 11)).length(),
        scale: step(4.0, 10) as f32 + 1e-6,
        rotation: SMALLEST_THREE,
        base: UNIT,
        alpha: UNIT,
        harmonic: 8.0 / 256.0 / 2.0 + 1e-6,
    };
    assert_reads_as_soup("soup.compressed.ply", 2, None, &bounds);
}

/// Tables of extents, colors and harmonics follow from all splats, so that another reader tells what a file holds. It
/// keeps opacities as logits.
#[test]
fn sog() {
    for (name, other) in [
        ("soup.sog", "soup-of-sog.ply"),
        ("soup-folder", "soup-of-folder.ply"),
        ("soup-folder/meta.json", "soup-of-folder.ply"),
    ] {
        let cloud = load(&folder().join(name)).unwrap();
        assert_eq!((cloud.up, cloud.filter, cloud.warnings.len()), (UpAxis::NegativeY, None, 0), "{name}");
        assert_same(&cloud, &load(&folder().join(other)).unwrap(), &EXACT, name);
        // 16 bits of the logarithms of 1 to 4 of both signs, which their writer cuts; three bytes of √2 of the
        // quaternion, whose steps are four times those of nine bits and a sign.
        let position = 1.7321 * 4.0 * 2.0 * 4.0_f64.ln() / 65535.0;
        let loose = Bounds {
            position,
            scale: 0.05,
            rotation: 4.0 * 511.0 / 510.0 * SMALLEST_THREE,
            base: 0.01,
            alpha: SIGNED,
            harmonic: 2.0,
        };
        assert_same(&cloud, &soup(), &loose, name);
    }
}

/// Splats have no pieces that could be read one by one.
#[test]
fn stores_hold_them_as_a_whole() {
    for name in ["soup.ply", "soup.compressed.ply", "soup-v4.spz", "soup-folder"] {
        let (path, hints) = (folder().join(name), Hints::default());
        let store = store::open(&path, hints, &Progress::hidden()).unwrap();
        let cloud = store::whole(&*store, &Progress::hidden()).unwrap();
        assert_eq!(cloud, load(&path).unwrap(), "{name}");
        assert_eq!(
            (store::announced(&path, &hints).unwrap(), store::has_levels(&path, &hints).unwrap()),
            (None, false)
        );
    }
}
