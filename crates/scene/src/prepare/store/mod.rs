//! Radii, normals and fields of clouds that memory doesn't hold: the same bits as [`find`](super::find) computes for
//! the whole cloud.
//!
//! The points are made a store first. Then one region of space after the other is looked at with what is around it. A
//! point's values are kept if all that they depend on is there: its K nearest neighbors and, for the cap and for the
//! field, theirs. Ranks are those of the whole cloud, so that sums have the same order. What is left is found point by
//! point in balls, which may be as large as the cloud but hold few points. At last the store is written anew with the
//! values.

mod enriched;
mod regions;
mod solve;
mod source;
mod values;

use std::path::{Path, PathBuf};

use super::Request;
use super::surface::Wants;
use enriched::{Enriched, Fields};
use pellucid_core::cloud::field::{self, Field};
use pellucid_core::cloud::{Cloud, Prepared};
use pellucid_core::progress::Progress;
use pellucid_io as io;
use pellucid_io::store::build::{self, Built, Settings};
use pellucid_io::store::{Octree, Store, Summary};
use regions::{Region, regions};
use solve::Solver;
use source::RegionStore;
use values::{Value, Values};

/// Name of the file that says what a finished store of points without values is made of, and what was said of it.
const MARKER: &str = "made.json";

/// Bytes that finding the neighbors of a point takes, and for each neighbor.
const BYTES_OF_POINT: u64 = 300;
/// See [`BYTES_OF_POINT`].
const BYTES_OF_NEIGHBOR: u64 = 4;

/// Share of the memory that holds nodes: one in this many.
const HELD: u64 = 8;

/// Reason why a store can't be prepared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Error {
    /// Files can't be read or written.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The cloud lacks what its field is made of.
    #[error("{}: {source}", path.display())]
    Field { path: PathBuf, source: field::Error },
}

/// Data that is computed of each point, in addition to the radius.
#[derive(Debug, Clone, PartialEq)]
struct ValuePlan {
    /// K of a cloud with so many points.
    k: usize,
    cap: f32,
    /// `true` if radii are computed; else the points have their own.
    radii: bool,
    wants: Wants,
}

/// Writes some clouds as one store with radii and the field of [`Request::field`], and with normals if they are asked
/// for, as [`prepared`](super::prepared) does for a cloud in memory. Positions count as the store has them. Shadows of
/// a prepared input stay unless normals are asked for. Settings and the rest as in [`build`](build::build); a run that
/// ended early goes on where it was when points were put into nodes, and computes values anew. Of Gaussian splats
/// nothing is computed.
///
/// # Errors
/// Returns the errors of [`build`](build::build), and an error if the clouds lack the property of the field.
pub fn prepare(
    inputs: &[Box<dyn Store>],
    folder: &Path,
    request: &Request,
    settings: &Settings,
    progress: &Progress,
) -> Result<Built, Error> {
    build::check_target(folder)?;
    if inputs.iter().any(|input| input.summary().like.gaussians.is_some()) {
        return Ok(build::build(inputs, folder, settings, progress)?);
    }
    let raw = beside(folder);
    let raw_built = points(inputs, &raw, settings, progress)?;
    let octree = Octree::open(&raw)?;
    let enriched = compute(octree, folder, request, settings, progress).inspect_err(|error| {
        if matches!(error, Error::Field { .. }) {
            // Nothing to go on with.
            let _ = std::fs::remove_dir_all(&raw);
        }
    })?;
    let built = build::build(&[Box::new(enriched) as Box<dyn Store>], folder, settings, progress)?;
    std::fs::remove_dir_all(&raw).map_err(|source| io::Error::Write { path: raw, source })?;
    let (rounding, notes) = (raw_built.rounding.max(built.rounding), [raw_built.notes, built.notes].concat());
    Ok(Built { rounding, notes, ..built })
}

/// The folder of the points without values.
fn beside(folder: &Path) -> PathBuf {
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    pellucid_core::atomic::folder(folder).join(format!(".{name}.pellucid-points"))
}

/// Makes the store of points without values, unless an earlier run made the same one.
fn points(inputs: &[Box<dyn Store>], raw: &Path, settings: &Settings, progress: &Progress) -> Result<Built, io::Error> {
    let key = build::key(inputs, settings);
    let marker = raw.join(MARKER);
    let made = || serde_json::from_slice::<(String, Built)>(&std::fs::read(&marker).ok()?).ok();
    if let Some((_, built)) = made().filter(|(known, _)| *known == key) {
        return Ok(built);
    }
    let built = build::build(inputs, raw, settings, progress)?;
    let text = serde_json::to_vec(&(key, &built)).map_err(std::io::Error::from);
    let written =
        text.and_then(|text| pellucid_core::atomic::write(&marker, |out| std::io::Write::write_all(out, &text)));
    written.map_err(|source| io::Error::Write { path: marker, source })?;
    Ok(built)
}

/// Finds the values of all points.
fn compute(
    octree: Octree,
    folder: &Path,
    request: &Request,
    settings: &Settings,
    progress: &Progress,
) -> Result<Enriched, Error> {
    let summary = octree.summary().clone();
    let like = &summary.like;
    let (neighbors, cap) = (request.neighbors_of(like), request.radius_cap_of(like));
    let field = request.field_of(like);
    let is_stored = request.stored_field(like).is_some();
    let radii = request.stored_radii(like).is_none();
    let fields = !is_stored && field == Field::Uncertainty;
    let wants = Wants { radii: true, uncapped: false, normals: request.normals, fields, last: true };
    let k = usize::try_from(summary.points - 1).unwrap_or(usize::MAX).min(neighbors);
    let plan = ValuePlan { k, cap, radii, wants };
    let source = RegionStore::new(octree, settings.host_memory / HELD);
    let from_columns = !is_stored && field != Field::Uncertainty;
    progress.set_message("looking at the points");
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    let mut failure = None;
    let see = |cloud: &Cloud| {
        let unscaled = field.unscaled(cloud, || Some(source.bounds)).map(Option::unwrap_or_default);
        unscaled.map(field::range)
    };
    let regions = regions(
        &source,
        region_points(settings, k),
        progress,
        |cloud| from_columns.then(|| see(cloud)),
        |seen| match seen {
            Some(Ok([least, most])) => range = [range[0].min(least), range[1].max(most)],
            Some(Err(error)) => failure = Some(error),
            None => {}
        },
    )?;
    if let Some(error) = failure {
        return Err(Error::Field { path: folder.to_path_buf(), source: error });
    }
    let values = Values::new(pellucid_core::atomic::folder(folder), &plan)?;
    solve(&source, &plan, &regions, &values, progress)?;
    let fields = match field {
        _ if is_stored => Fields::Stored,
        Field::Uncertainty => Fields::Found,
        _ => Fields::Columns(range),
    };
    let summary = enriched_summary(&summary, request, &plan);
    Ok(Enriched { source, plan, field, fields, values, summary })
}

/// Points that are looked at together, with those around them.
fn region_points(settings: &Settings, k: usize) -> u64 {
    // As for a cloud in memory, and as many points again around a region.
    let each = 2 * (BYTES_OF_POINT + BYTES_OF_NEIGHBOR * k as u64);
    ((settings.host_memory - settings.host_memory / HELD) / each).max(1)
}

/// Finds the values of all regions.
fn solve(
    source: &RegionStore,
    plan: &ValuePlan,
    regions: &[Region],
    values: &Values,
    progress: &Progress,
) -> Result<(), Error> {
    if !plan.radii && !plan.wants.normals && !plan.wants.fields {
        return Ok(());
    }
    progress.set_message("finding neighbors");
    progress.reset();
    progress.set_length(regions.len() as u64);
    if plan.k == 0 {
        // A single point.
        let normal =
            source.octree.read(0)?.cloud.normals.and_then(|normals| normals.first().copied()).unwrap_or_default();
        return Ok(values.write(vec![(0, Value { normal, ..Value::default() })])?);
    }
    let solver = Solver { source, plan };
    for region in regions {
        progress.check().map_err(|_| io::Error::Cancelled { path: source.octree.summary().path.clone() })?;
        solver.region(*region, values)?;
        progress.inc(1);
    }
    Ok(())
}

/// Returns what is known of the store with the values.
fn enriched_summary(summary: &Summary, request: &Request, plan: &ValuePlan) -> Summary {
    let mut summary = summary.clone();
    let like = &mut summary.like;
    let shadows = like.prepared.as_ref().and_then(|prepared| prepared.shadows.clone()).filter(|_| !request.normals);
    let prepared = Prepared {
        neighbors: request.neighbors_of(like),
        radius_cap: plan.cap,
        estimated_radii: like.own_radii().is_none(),
        field: request.field_of(like),
        values: Vec::new(),
        shadows,
    };
    like.prepared = Some(prepared);
    like.radii = Some(Vec::new());
    if plan.wants.normals {
        like.normals = Some(Vec::new());
    }
    summary
}
