//! Time to read a cloud. `PELLUCID_BENCH_CLOUD=scan.laz cargo bench --bench io` adds a file of yours.
//!
//! The figure to look at is points per second; a file's first run includes reading it from the disk.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3};
use pellucid_core::cloud::Cloud;
use pellucid_core::progress::Progress;
use pellucid_io as io;

fn bench_file(criterion: &mut Criterion, name: &str, path: &Path) {
    let points = io::load(path, &Progress::hidden()).expect("the file loads").len() as u64;
    let mut group = criterion.benchmark_group("load");
    group.sample_size(10).throughput(Throughput::Elements(points));
    group.bench_function(name, |b| b.iter(|| io::load(black_box(path), &Progress::hidden())));
    group.finish();
}

fn load(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("cloud.ply");
    let at = |i: u32| DVec3::new((i % 1000).into(), (i / 1000).into(), 0.5);
    let cloud = Cloud {
        positions: (0..200_000).map(at).collect(),
        colors: Some(vec![Vec3::splat(0.5); 200_000]),
        normals: Some(vec![Vec3::Z; 200_000]),
        ..Cloud::default()
    };
    io::ply::write(&path, &cloud).expect("the file is written");
    bench_file(criterion, "ply, 200 000 points", &path);
    if let Some(file) = std::env::var_os("PELLUCID_BENCH_CLOUD") {
        bench_file(criterion, &file.to_string_lossy(), Path::new(&file));
    }
}

criterion_group!(benches, load);
criterion_main!(benches);
