//! The identity of a measurement: the same picture on the same device, by the same program.

use glam::Vec3;

use crate::gpu::DeviceInfo;
use crate::methods::Frame;
use crate::points::Points;
use crate::prepare::Arranged;

/// Returns a hash of everything that determines the image and the time of a frame, except for the method: points,
/// properties of their clouds, camera, size, shading, color space, background, memory budget, factors, samples and
/// seed; device and driver; the program's version. In hexadecimal digits.
///
/// The method only enters through `formation`.
pub fn hash(arranged: &Arranged, frame: &Frame, background: Vec3, formation: &str, device: &DeviceInfo) -> String {
    let Frame {
        camera,
        size,
        shading,
        color,
        method: _,
        detail,
        memory_budget,
        outputs: _,
        fragments: _,
        depths: _,
        stop,
        seed,
        max_error: _,
        spread: _,
        ensembles: _,
        shadows,
        factors,
        background: _,
        samples,
        only,
        four: _,
    } = frame;
    let mut hasher = blake3::Hasher::new();
    let mut add = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    let Points {
        positions,
        colors,
        opacities,
        radii,
        normals,
        file_order,
        dealt_ids: _,
        fields,
        gaussians,
        unseen,
        // The camera is part of the frame.
        sensor: _,
        whole,
    } = arranged.points();
    let coordinates: Vec<[f64; 3]> = positions.iter().map(|p| p.to_array()).collect();
    add(bytemuck::cast_slice(&coordinates));
    add(bytemuck::cast_slice(colors));
    add(bytemuck::cast_slice(opacities));
    add(bytemuck::cast_slice(radii));
    add(bytemuck::cast_slice(normals.as_deref().unwrap_or_default()));
    add(bytemuck::cast_slice(file_order));
    add(bytemuck::cast_slice(fields));
    if !unseen.positions.is_empty() {
        let coordinates: Vec<[f64; 3]> = unseen.positions.iter().map(|p| p.to_array()).collect();
        add(bytemuck::cast_slice(&coordinates));
    }
    if let Some(gaussians) = gaussians {
        add(bytemuck::cast_slice(&gaussians.extents));
        add(bytemuck::cast_slice(&gaussians.rotations));
        add(bytemuck::cast_slice(&gaussians.bases));
        add(bytemuck::cast_slice(&gaussians.harmonics));
        if gaussians.may_be_linear() {
            let linear: Vec<u8> = (0..gaussians.len()).map(|splat| gaussians.is_linear(splat).into()).collect();
            add(&linear);
        }
    }
    if let Some(whole) = whole {
        add(whole.identity.as_bytes());
    }
    // Debug output of floats is exact.
    let surfaces = arranged.surfaces();
    let settings = format!(
        "{camera:?} {size:?} {shading:?} {color:?} {memory_budget:?} {stop:?} {seed} {shadows:?} {factors:?} {background:?} {surfaces:?}"
    );
    let program = format!("{} {} {}", env!("CARGO_PKG_VERSION"), device.name, device.driver);
    // Measurements of all points are those of earlier versions.
    let settings = if detail.is_whole() { settings } else { format!("{settings} {detail:?}") };
    let settings = if *samples == 1 { settings } else { format!("{settings} {samples} {only:?}") };
    for text in [&settings, formation, &program] {
        add(text.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}
