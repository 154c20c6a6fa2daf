//! What the passes of a frame took, and the bytes that each must move at least.

use std::time::Duration;

use super::parts::splatting_bytes;
use super::{Facts, Frame, PassProfile};
use crate::gpu::PassTime;
use crate::methods::stochastic::hardware;
use crate::methods::{abuffer, approximate, image_space, linked_list, peel, shadows, spbr, splats, stochastic};
use crate::passes::bin;
use crate::passes::project::DeviceCloud;
use crate::scene::{DiscShape, Method, Stochastic};

/// Sums the dispatches of each pass, in order of first appearance, and adds the bytes that each must move.
/// `lengths` are those of all lists, if they were read back.
pub(super) fn aggregate(
    timeline: &[(PassTime, Duration)],
    facts: &Facts,
    frame: &Frame,
    cloud: &DeviceCloud,
    lengths: &[u32],
) -> Vec<PassProfile> {
    let mut passes: Vec<PassProfile> = Vec::new();
    let runs = |name| timeline.iter().filter(|(time, _)| time.name == name).count() as u64;
    for (time, _) in timeline {
        match passes.iter_mut().find(|p| p.name == time.name) {
            Some(pass) => {
                pass.gpu += time.gpu;
                pass.invocations = pass.invocations.zip(time.invocations).map(|(a, b)| a + b);
            }
            None => passes.push(PassProfile {
                name: time.name,
                gpu: time.gpu,
                invocations: time.invocations,
                bytes: least_bytes(time.name, runs(time.name), facts, frame, cloud)
                    .or_else(|| abuffer::least_bytes(time.name, lengths)),
            }),
        }
    }
    passes
}

/// Bytes that a pass must at least read and write in its `runs`, from the counts of the frame; cached re-reads are not counted.
fn least_bytes(name: &str, runs: u64, facts: &Facts, frame: &Frame, cloud: &DeviceCloud) -> Option<u64> {
    let pixels = u64::from(frame.size[0]) * u64::from(frame.size[1]);
    let normal = if cloud.has_normals() || cloud.casting().is_some() { 16 } else { 0 };
    let discs = frame.method.discs();
    let transparent = discs.is_some();
    let tilted = matches!(frame.method, Method::Splats(_)) || discs.is_some_and(|d| d.shape == DiscShape::Oriented);
    let oriented = tilted && cloud.has_normals();
    let splat = 20 + if oriented { 16 } else { 0 };
    // Each band's store reads the rectangles of all splats again.
    let walks = facts.points * 8 * facts.windows.max(1) + facts.visible * splat;
    let of_filters = !name.starts_with("image/") && !name.starts_with("shadows/");
    if let Some(filters) = frame.method.filters().filter(|_| of_filters) {
        return image_space::least_bytes(name, facts, cloud, filters.cull);
    }
    match name {
        "splat/project" => {
            Some(facts.points * (32 + 16 + normal + 8) * facts.windows.max(1) + facts.visible * (splat + 16))
        }
        "abuffer/clear" => Some(pixels * 4),
        "peel/clear" => Some(pixels * peel::pixel_bytes(frame.fragments)),
        "abuffer/count" | "peel/count" => Some(walks + facts.fragments * 8),
        "abuffer/measure" => Some(pixels * 4),
        "abuffer/store" => {
            Some(facts.points * 8 * facts.bands + facts.visible * splat + facts.fragments * (8 + FRAGMENT))
        }
        // Besides the node, its link and the counter of nodes, read and written.
        "linked-list/store" => {
            Some(facts.points * 8 * facts.bands + facts.visible * splat + facts.fragments * (8 + FRAGMENT + LINK + 8))
        }
        // Every run looks at all offsets.
        "linked-list/gather" => Some(pixels * 8 + facts.fragments * (2 * FRAGMENT + LINK)),
        "abuffer/cursors" => Some(pixels * 8),
        "image/clear" => Some(pixels * 20),
        "abuffer/classify" => Some(pixels * 4),
        "abuffer/order" => Some(pixels * 8),
        "splat/clear" if !transparent && splatting_bytes(&frame.method) == 0 => Some(pixels * 8),
        "points/nearest" => Some(facts.points * 32 * facts.windows.max(1) + facts.visible * 8),
        "soft/count" => Some(walks + facts.fragments * 8),
        "soft/compose" => Some(pixels * 3 * 20),
        "splat/resolve" | "points/resolve" => Some(pixels * (8 + 16 + 20)),
        "image/read-back" => Some(pixels * 20 * 2),
        name if name.starts_with("shadows/") => {
            let resolution = frame.shadows.map_or(0, |shadows| shadows.resolution);
            shadows::least_bytes(name, runs, facts.points, cloud.chunks().count() as u64, resolution)
        }
        _ => match frame.method {
            method if method.is_dealt() => spbr::least_bytes(name, facts, frame.spread(), pixels),
            Method::Stochastic(Stochastic { samples, alpha_correction: exact, .. })
                if name.starts_with("stochastic/") =>
            {
                let kind = stochastic::Kind { exact, spread: frame.spread() };
                let quads = facts.points * 8 + facts.visible / facts.windows.max(1) * (splat + 16);
                stochastic::least_bytes(name, samples, kind, facts, pixels, splat)
                    .or_else(|| hardware::least_bytes(name, runs, u64::from(samples.div_ceil(4)), quads, pixels))
            }
            Method::Hqs(_) | Method::Splats(_) => {
                let binned = Facts { bands: facts.splatted, ..facts.clone() };
                bin::least_bytes(name, runs, &binned, splat)
                    .or_else(|| splats::least_bytes(name, facts, oriented, pixels))
            }
            Method::SoftExpress(_) if facts.solid_points == 0 || ["bin/pick", "bin/place"].contains(&name) => {
                bin::least_bytes(name, runs, facts, splat)
            }
            // How many splats are solid is not known.
            method if method.threshold().is_some() => None,
            _ => bin::least_bytes(name, runs, facts, splat)
                .or_else(|| approximate::least_bytes(name, facts, &frame.method, oriented, pixels)),
        },
    }
}

const FRAGMENT: u64 = abuffer::FRAGMENT_BYTES;
const LINK: u64 = linked_list::LINK_BYTES;
