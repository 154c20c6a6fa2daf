//! Parts of clouds: some of the points of one, and several one behind the other.

use bytemuck::Pod;

use super::gaussians::Gaussians;
use super::shadow_texture::ShadowTexture;
use super::{Cloud, Prepared};
use crate::parallel;

/// The values at these places; of a column that isn't there none.
fn pick<T: Pod + Send + Sync>(column: &[T], places: &[u32]) -> Vec<T> {
    parallel::map(places.len(), |i| column[places[i] as usize])
}

impl Cloud {
    /// Returns the points at these places, in that order, with all that belongs to them.
    #[must_use]
    pub fn subset(&self, places: &[u32]) -> Self {
        let prepared = self.prepared.as_ref().map(|prepared| Prepared {
            values: pick(&prepared.values, places),
            shadows: prepared
                .shadows
                .as_ref()
                .map(|shadows| ShadowTexture { casting: shadows.casting, lit: pick(&shadows.lit, places) }),
            field: prepared.field.clone(),
            ..*prepared
        });
        Self {
            positions: pick(&self.positions, places),
            colors: self.colors.as_ref().map(|colors| pick(colors, places)),
            alphas: self.alphas.as_ref().map(|alphas| pick(alphas, places)),
            normals: self.normals.as_ref().map(|normals| pick(normals, places)),
            radii: self.radii.as_ref().map(|radii| pick(radii, places)),
            gaussians: self.gaussians.as_ref().map(|all| all.picked(places.len(), |i| places[i] as usize)),
            filter: self.filter,
            classification: self.classification.as_ref().map(|codes| pick(codes, places)),
            intensity: self.intensity.as_ref().map(|values| pick(values, places)),
            scalars: self.scalars.iter().map(|(name, values)| (name.clone(), pick(values, places))).collect(),
            non_finite: self.non_finite,
            withheld: self.withheld,
            up: self.up,
            up_reason: self.up_reason,
            crs: self.crs.clone(),
            up_is_convention: self.up_is_convention,
            sensor: self.sensor,
            prepared,
            warnings: self.warnings.clone(),
        }
    }

    /// Puts the points of a cloud with the same columns behind these.
    ///
    /// # Panics
    /// The columns are others: nobody appends a part of one cloud to a part of another.
    pub fn append(&mut self, more: Self) {
        fn join<T>(column: &mut Option<Vec<T>>, more: Option<Vec<T>>) {
            assert_eq!(column.is_some(), more.is_some(), "parts of a cloud have the same columns");
            if let (Some(column), Some(more)) = (column, more) {
                column.extend(more);
            }
        }
        self.gaussians = Gaussians::joined((self.gaussians.take(), self.len()), (more.gaussians, more.positions.len()));
        self.positions.extend(more.positions);
        join(&mut self.colors, more.colors);
        join(&mut self.alphas, more.alphas);
        join(&mut self.normals, more.normals);
        join(&mut self.radii, more.radii);
        join(&mut self.classification, more.classification);
        join(&mut self.intensity, more.intensity);
        assert_eq!(self.scalars.len(), more.scalars.len(), "parts of a cloud have the same columns");
        for ((name, values), (other, more)) in self.scalars.iter_mut().zip(more.scalars) {
            assert_eq!(*name, other, "parts of a cloud have the same columns");
            values.extend(more);
        }
        assert_eq!(self.prepared.is_some(), more.prepared.is_some(), "parts of a cloud have the same columns");
        if let (Some(prepared), Some(more)) = (&mut self.prepared, more.prepared) {
            prepared.values.extend(more.values);
            assert_eq!(prepared.shadows.is_some(), more.shadows.is_some(), "parts of a cloud have the same columns");
            if let (Some(shadows), Some(more)) = (&mut prepared.shadows, more.shadows) {
                shadows.lit.extend(more.lit);
            }
        }
        self.non_finite += more.non_finite;
        self.withheld += more.withheld;
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Quat, Vec3};

    use super::*;
    use crate::cloud::field::Field;
    use crate::cloud::gaussians::{ColorCoding, Gaussians};

    fn cloud() -> Cloud {
        Cloud {
            positions: [1.0, 2.0, 3.0].map(DVec3::splat).to_vec(),
            colors: Some([0.1, 0.2, 0.3].map(Vec3::splat).to_vec()),
            alphas: Some(vec![0.5, 0.6, 0.7]),
            normals: Some(vec![Vec3::X, Vec3::Y, Vec3::Z]),
            radii: Some(vec![4.0, 5.0, 6.0]),
            gaussians: Some(Gaussians {
                extents: [1.0, 2.0, 3.0].map(Vec3::splat).to_vec(),
                rotations: [0.1, 0.2, 0.3].map(Quat::from_rotation_x).to_vec(),
                bases: [0.4, 0.5, 0.6].map(Vec3::splat).to_vec(),
                coding: ColorCoding::Each(vec![true, false, true]),
                degree: 1,
                harmonics: (0..9_u8).map(|i| Vec3::splat(i.into())).collect(),
            }),
            classification: Some(vec![7, 8, 9]),
            intensity: Some(vec![10.0, 11.0, 12.0]),
            scalars: vec![("echo".to_owned(), vec![13.0, 14.0, 15.0])],
            prepared: Some(Prepared {
                neighbors: 24,
                radius_cap: 4.0,
                estimated_radii: true,
                field: Field::Intensity,
                values: vec![0.0, 0.5, 1.0],
                shadows: None,
            }),
            ..Cloud::default()
        }
    }

    #[test]
    fn parts_put_together_are_the_cloud() {
        let whole = cloud();
        let mut joined = whole.subset(&[0]);
        joined.append(whole.subset(&[1, 2]));
        assert_eq!(joined, whole);
        let turned = whole.subset(&[2, 1, 0]);
        assert_eq!(turned.subset(&[2, 1, 0]), whole);
        assert_eq!(turned.positions[0], DVec3::splat(3.0));
        let nothing = whole.subset(&[]);
        assert!(nothing.is_empty() && nothing.colors == Some(Vec::new()) && nothing.scalars[0].1.is_empty());
    }
}
