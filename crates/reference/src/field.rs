//! Radii, normals and the scalar field of soft transparency (Seemann et al., Eq. 20 and 21, corrected), by comparing
//! every point with every other.

use std::cmp::Ordering;

use glam::{DMat3, DVec3};

/// The results of Eq. 20 and 21 for each point.
#[derive(Debug, Clone, PartialEq)]
pub struct PointEstimates {
    /// Eq. 20.
    pub radii: Vec<f64>,
    /// Eq. 20 without the cap.
    pub uncapped: Vec<f64>,
    /// Given or, where missing, estimated; zero without a single direction.
    pub normals: Vec<DVec3>,
    /// Amount by which the middle variance of a point and its neighbors exceeds four times the smallest, as a share of
    /// all three: above 0 they lie about a surface. What is within rounding of 0 may do either.
    pub planarity: Vec<f64>,
    /// Eq. 21, scaled to [0, 1].
    pub fields: Vec<f64>,
}

/// Returns the K nearest other points of each: by squared distance, then x, y, z, then normal up to its sign.
pub fn nearest(positions: &[DVec3], normals: &[DVec3], neighbors: usize) -> Vec<Vec<usize>> {
    let k = neighbors.min(positions.len().saturating_sub(1));
    let upright = |n: DVec3| if (n.x, n.y, n.z) < (0.0, 0.0, 0.0) { -n } else { n };
    let lexical = |a: DVec3, b: DVec3| a.to_array().partial_cmp(&b.to_array()).unwrap_or(Ordering::Equal);
    let surface_at = |i: usize| {
        let mut others: Vec<usize> = (0..positions.len()).filter(|j| *j != i).collect();
        others.sort_by(|&a, &b| {
            let squared = |j: usize| positions[i].distance_squared(positions[j]);
            let by_place = || lexical(positions[a], positions[b]);
            let by_normal = || lexical(upright(normals[a]), upright(normals[b]));
            squared(a).total_cmp(&squared(b)).then_with(by_place).then_with(by_normal)
        });
        others.truncate(k);
        others
    };
    (0..positions.len()).map(surface_at).collect()
}

/// Radii, normals and field of points with these normals, zero where one is missing. A radius is at most `cap` times
/// the median of those of its neighbors and its own, unless that is 0.
pub fn surface(positions: &[DVec3], normals: &[DVec3], neighbors: usize, cap: f64) -> PointEstimates {
    let lists = nearest(positions, normals, neighbors);
    let uncapped: Vec<f64> = (0..positions.len())
        .map(|i| {
            let farthest = lists[i].iter().map(|&j| positions[i].distance(positions[j])).fold(0.0, f64::max);
            if lists[i].is_empty() { 0.0 } else { 2.0 * farthest / (lists[i].len() as f64).sqrt() }
        })
        .collect();
    let radius = |i: usize| {
        let around = lists[i].iter().chain([&i]).map(|&j| uncapped[j]).collect();
        if cap == 0.0 { uncapped[i] } else { uncapped[i].min(cap * median(around)) }
    };
    let around = |i: usize| lists[i].iter().chain([&i]).map(|&j| positions[j] - positions[i]).collect();
    let normal = |i: usize| match normals[i] {
        DVec3::ZERO => smallest_axis(around(i)),
        given => given,
    };
    let radii: Vec<f64> = (0..positions.len()).map(radius).collect();
    let normals: Vec<DVec3> = (0..positions.len()).map(normal).collect();
    let field = |i: usize| {
        let terms = lists[i].iter().map(|&j| (2.0 - normals[i].dot(normals[j]).abs()).powi(2));
        radii[i] * terms.sum::<f64>() / lists[i].len().max(1) as f64
    };
    let raw: Vec<f64> = (0..positions.len()).map(field).collect();
    let least = raw.iter().copied().fold(f64::INFINITY, f64::min);
    let most = raw.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Values that differ by rounding only are equal.
    let constant = most - least <= 1e-9 * most;
    let fields = raw.iter().map(|f| if constant { 0.0 } else { (f - least) / (most - least) }).collect();
    let planarity = (0..positions.len()).map(|i| planarity(around(i))).collect();
    PointEstimates { radii, uncapped, normals, planarity, fields }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let [low, high] = [(values.len() - 1) / 2, values.len() / 2];
    0.5 * (values[low] + values[high])
}

/// Outliers by the mean distance to the `neighbors` nearest other points: how far each mean distance lies above mean +
/// `factor` · standard deviation of the sample, as a share of the mean. Above 0 a point is one; what is within rounding
/// of 0 may be either.
pub fn outlying(positions: &[DVec3], neighbors: usize, factor: f64) -> Vec<f64> {
    let lists = nearest(positions, &vec![DVec3::ZERO; positions.len()], neighbors);
    let distance = |(i, list): (usize, &Vec<usize>)| {
        list.iter().map(|&j| positions[i].distance(positions[j])).sum::<f64>() / list.len() as f64
    };
    let distances: Vec<f64> = lists.iter().enumerate().map(distance).collect();
    let count = distances.len() as f64;
    let mean = distances.iter().sum::<f64>() / count;
    let variance = distances.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (count - 1.0);
    distances.iter().map(|d| (d - mean - factor * variance.sqrt()) / mean).collect()
}

/// Covariance of points, times their number.
fn covariance(points: &[DVec3]) -> DMat3 {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let outer = |p: DVec3| DMat3::from_cols(p * p.x, p * p.y, p * p.z);
    points.iter().fold(DMat3::ZERO, |sum, p| sum + outer(*p - mean))
}

fn trace(m: DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// (λ₂ − 4λ₃) / (λ₁ + λ₂ + λ₃) of the covariance of points, by the trigonometric roots of its characteristic polynomial
/// (Smith 1961); 0 in a single place.
fn planarity(points: Vec<DVec3>) -> f64 {
    let covariance = covariance(&points);
    let total = trace(covariance);
    if total == 0.0 {
        return 0.0;
    }
    // Of trace 1: the eigenvalues are a third, more or less.
    let share = covariance * total.recip();
    let off = share - DMat3::IDENTITY * (1.0 / 3.0);
    let size = (trace(off * off) / 6.0).sqrt();
    if size == 0.0 {
        return -1.0;
    }
    let angle = ((off * size.recip()).determinant() * 0.5).clamp(-1.0, 1.0).acos() / 3.0;
    let root = |turns: f64| 1.0 / 3.0 + 2.0 * size * (angle + turns * std::f64::consts::TAU / 3.0).cos();
    let (most, least) = (root(0.0), root(1.0));
    (1.0 - most - least) - 4.0 * least
}

/// The direction in which points vary least: the eigenvector for the smallest eigenvalue of their covariance C, which
/// has the largest one of tr(C) − C, and so is all that is left of a high power of that matrix.
fn smallest_axis(points: Vec<DVec3>) -> DVec3 {
    let covariance = covariance(&points);
    let total = trace(covariance);
    if total == 0.0 {
        return DVec3::ZERO;
    }
    let mut power = DMat3::IDENTITY - covariance * total.recip();
    // 2³⁴ takes a share of 1 − 10⁻⁹ to 10⁻⁷ or less: directions nearer to each other than that are not one.
    for _ in 0..34 {
        power = power * power;
        power *= trace(power).recip();
    }
    let single = power.to_cols_array().iter().map(|x| x * x).sum::<f64>() > 0.99;
    let axis = [power.x_axis, power.y_axis, power.z_axis].into_iter().max_by(|a, b| a.length().total_cmp(&b.length()));
    axis.filter(|_| single).map_or(DVec3::ZERO, DVec3::normalize)
}
