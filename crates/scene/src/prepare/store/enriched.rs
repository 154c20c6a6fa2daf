//! A store with the values that were found for its points.

use super::source::RegionStore;
use super::values::{Value, Values};
use super::{Field, ValuePlan};
use pellucid_core::cloud::Prepared;
use pellucid_io::Error;
use pellucid_io::store::{Node, Piece, Store, Summary};

/// Source of F.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Fields {
    /// Stored column: the store has it.
    Stored,
    /// Column from the file of values.
    Found,
    /// Column that is made of columns with this range.
    Columns([f64; 2]),
}

/// The store.
#[derive(Debug)]
pub(super) struct Enriched {
    pub source: RegionStore,
    pub plan: ValuePlan,
    pub field: Field,
    pub fields: Fields,
    pub values: Values,
    /// Summary of the store, with the columns that are added.
    pub summary: Summary,
}

impl Store for Enriched {
    fn summary(&self) -> &Summary {
        &self.summary
    }

    fn nodes(&self) -> &[Node] {
        self.source.octree.nodes()
    }

    fn read(&self, node: usize) -> Result<Piece, Error> {
        let Piece { mut cloud, places } = self.source.octree.read(node)?;
        let values = self.values.read(self.source.octree.first_point(node), cloud.len())?;
        let scaled = match self.fields {
            Fields::Stored => None,
            Fields::Found => {
                let spreads: Vec<f64> = values.iter().map(|value| value.spread).collect();
                Some(self.field.scaled(&spreads, self.values.range()))
            }
            Fields::Columns(range) => {
                // The same columns as when the range was found.
                let unscaled = self.field.unscaled(&cloud, || Some(self.source.bounds)).ok().flatten();
                Some(self.field.scaled(&unscaled.unwrap_or_default(), range))
            }
        };
        if let (Some(values), Some(like)) = (scaled, &self.summary.like.prepared) {
            let shadows =
                cloud.prepared.take().and_then(|prepared| prepared.shadows).filter(|_| like.shadows.is_some());
            cloud.prepared = Some(Prepared { values, shadows, ..like.clone() });
        }
        if self.plan.radii {
            cloud.radii = Some(values.iter().map(|Value { radius, .. }| *radius).collect());
        }
        if self.plan.wants.normals {
            cloud.normals = Some(values.iter().map(|Value { normal, .. }| *normal).collect());
        }
        Ok(Piece { cloud, places })
    }
}
