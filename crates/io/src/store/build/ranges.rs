//! Ranges of what a store holds.

use glam::Vec3;

use super::super::octree::attributes::{AttributeLayout, Role};
use super::super::octree::integers;
use super::super::octree::nodes::NodeExtent;
use pellucid_core::cloud::field::range;
use pellucid_core::cloud::gaussians::reach;

/// Least and largest value of each number of a record, those of positions on the grid.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ranges(pub Vec<[f64; 2]>);

impl Ranges {
    pub fn new(layout: &AttributeLayout) -> Self {
        let numbers = layout.attributes.iter().map(|attribute| attribute.elements).sum();
        Self(vec![[f64::INFINITY, f64::NEG_INFINITY]; numbers])
    }

    pub fn add(&mut self, other: &Self) {
        for ([least, most], other) in self.0.iter_mut().zip(&other.0) {
            *least = least.min(other[0]);
            *most = most.max(other[1]);
        }
    }

    pub fn by_attribute<'a>(&'a self, layout: &'a AttributeLayout) -> impl Iterator<Item = &'a [[f64; 2]]> {
        let mut rest = self.0.as_slice();
        layout.attributes.iter().map(move |attribute| {
            let (own, others) = rest.split_at(attribute.elements);
            rest = others;
            own
        })
    }

    /// Returns those of some records, and the box and largest radius or reach of their points; `None` without points.
    /// The offset is 0.
    pub fn of(layout: &AttributeLayout, records: &[u8]) -> (Self, Option<NodeExtent>) {
        let mut ranges = Self::new(layout);
        if records.is_empty() {
            return (ranges, None);
        }
        let mut corners = [[i32::MAX; 3], [i32::MIN; 3]];
        for record in records.chunks_exact(layout.stride) {
            let at = integers(record);
            for axis in 0..3 {
                corners[0][axis] = corners[0][axis].min(at[axis]);
                corners[1][axis] = corners[1][axis].max(at[axis]);
            }
        }
        let mut number = 0;
        let mut largest_radius = None;
        for attribute in &layout.attributes {
            for element in 0..attribute.elements {
                let ends = match attribute.role {
                    Role::Position => corners.map(|corner| f64::from(corner[element])),
                    _ => {
                        let at = attribute.at + element * (attribute.bytes / attribute.elements);
                        let each = records.chunks_exact(layout.stride).map(|record| attribute.kind.read(&record[at..]));
                        range(each)
                    }
                };
                let radius = match attribute.role {
                    Role::Radius => Some(ends[1].max(0.0) as f32),
                    Role::Extents => Some(reach(Vec3::splat(ends[1].max(0.0) as f32))),
                    _ => None,
                };
                largest_radius = [largest_radius, radius].into_iter().flatten().reduce(f32::max);
                ranges.0[number] = ends;
                number += 1;
            }
        }
        (ranges, Some(NodeExtent { offset: 0, largest_radius, corners }))
    }
}
