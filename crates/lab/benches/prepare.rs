//! Time for radii, for radii, normals and field together, and for the canonical order, on random points on a sphere
//! (scans are surfaces, not volumes).
//!
//! `PELLUCID_BENCH_POINTS=3000000 cargo bench --bench prepare` sets their number. Radii should take time in proportion
//! to n·log n; ten times the points taking much more than thirteen times as long means the tree has stopped working.

use std::hint::black_box;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3};
use pellucid_core::points::Points;
use pellucid_core::progress::Progress;
use pellucid_scene::prepare::{order, radius, surface};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn sphere(count: usize) -> Vec<DVec3> {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let mut point = || DVec3::from([(); 3].map(|()| rng.random::<f64>() - 0.5)).normalize_or(DVec3::X);
    (0..count).map(|_| point()).collect()
}

fn prepare(criterion: &mut Criterion) {
    let count = std::env::var("PELLUCID_BENCH_POINTS").ok().and_then(|n| n.parse().ok()).unwrap_or(100_000);
    let positions = sphere(count);
    let mut group = criterion.benchmark_group(format!("{count} points"));
    group.sample_size(10).throughput(Throughput::Elements(count as u64));
    group.bench_function("radius, K = 24", |b| {
        b.iter(|| radius::estimate(black_box(&positions), 24, radius::DEFAULT_CAP, &Progress::hidden()));
    });
    group.bench_function("uncertainty, K = 24", |b| {
        b.iter(|| surface::estimate(black_box(&positions), None, (24, radius::DEFAULT_CAP), &Progress::hidden()));
    });
    let points = Points {
        colors: vec![Vec3::ONE; count],
        opacities: vec![1.0; count],
        radii: vec![0.0; count],
        normals: Some(positions.iter().map(|p| p.as_vec3()).collect()),
        positions,
        ..Points::default()
    };
    group.bench_function("canonical order", |b| {
        b.iter_batched(|| points.clone(), order::canonical, BatchSize::LargeInput);
    });
    group.finish();
}

criterion_group!(benches, prepare);
criterion_main!(benches);
