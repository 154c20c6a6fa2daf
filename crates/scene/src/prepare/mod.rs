//! Data computed once per cloud: radii, normals, the scalar field, the order of its points, and their orders along the
//! axes.

mod arranged;
pub mod axes;
pub mod dealt_file;
mod density;
pub mod ensembles;
mod keyed;
pub mod layer_distance;
mod morton;
mod neighbors;
mod normal;
pub mod order;
pub mod outliers;
pub mod radius;
pub mod sampled;
pub mod store;
pub mod surface;
mod temporary;
#[doc(hidden)]
pub mod ties;

use glam::Vec3;

pub use arranged::{Arranged, Supplied};
use pellucid_core::cloud::field::{self, Field};
use pellucid_core::cloud::{Bounds, Cloud, Prepared};
use pellucid_core::parallel;
use pellucid_core::points::as_estimated;
use pellucid_core::progress::Progress;

/// Default K of Eq. 20 and 21.
pub const DEFAULT_NEIGHBORS: usize = 24;

/// The data to compute for each point of a cloud.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Request {
    /// K; by default that of a prepared file, else [`DEFAULT_NEIGHBORS`].
    pub neighbors: Option<usize>,
    /// The cap of radii; by default that of a prepared file, else [`radius::DEFAULT_CAP`].
    pub radius_cap: Option<f32>,
    /// The definition of F, in the file's coordinates; by default that of a prepared file, else uncertainty.
    pub field: Option<Field>,
    /// Outliers that get F = 1.
    pub soft_outliers: Option<outliers::Rule>,
    /// Outliers that are to be dropped.
    pub dropped_outliers: Option<outliers::Rule>,
    /// `true` if radii are wanted.
    pub radii: bool,
    /// `true` if radii of Eq. 20 without its cap are wanted, whatever radii the file has.
    pub uncapped: bool,
    /// `true` if F is wanted.
    pub fields: bool,
    /// `true` if normals are wanted, estimated where the file has none.
    pub normals: bool,
    /// Normals that shading needs.
    pub shading: Option<ShadingNormals>,
}

impl Request {
    /// Asks for nothing that makes discs of points, if they are Gaussians, which have shapes of their own.
    pub(crate) fn forgo_shapes(&mut self, are_gaussians: bool) {
        if are_gaussians {
            (self.radii, self.uncapped, self.normals, self.shading) = (false, false, false, None);
        }
    }
}

/// Normals that are estimated for shading, where the file has none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShadingNormals {
    /// All.
    All,
    /// Uncertainty of points about a surface, not of foliage.
    Planar,
}

/// The computed data, in the order of the cloud; only the requested parts.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointData {
    /// The file's own radii, else those of Eq. 20, in the file's units.
    pub radii: Option<Vec<f32>>,
    /// Radii of Eq. 20 without its cap, in the file's units.
    pub uncapped: Option<Vec<f32>>,
    /// F in [0, 1].
    pub fields: Option<Vec<f32>>,
    /// Unit normals, zero for points without one.
    pub normals: Option<Vec<Vec3>>,
    /// Normals as [`Points::normals`](pellucid_core::points::Points::normals) has them.
    pub shading: Option<Vec<Vec3>>,
    /// Marks the points that are to be dropped.
    pub dropped: Option<Vec<bool>>,
}

/// The properties that determine estimated radii: K, and the bits of the cap.
pub type RadiusKey = (usize, u32);

/// The properties that determine a field.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldKey {
    definition: Field,
    /// Key of the radii that the uncertainty is made from.
    radii: Option<RadiusKey>,
    /// Outliers that get F = 1.
    soft: Option<outliers::Rule>,
}

impl Request {
    /// Returns what the radii of this cloud depend on.
    pub fn radius_key(&self, cloud: &Cloud) -> RadiusKey {
        (self.neighbors_of(cloud), self.radius_cap_of(cloud).to_bits())
    }

    /// Returns what F of this cloud depends on.
    pub fn field_key(&self, cloud: &Cloud) -> FieldKey {
        let definition = self.field_of(cloud);
        let radii = (definition == Field::Uncertainty).then(|| self.radius_key(cloud));
        FieldKey { definition, radii, soft: self.soft_outliers }
    }

    /// Returns `true` if neighbors may have to be found for it.
    pub fn needs_neighbors(&self) -> bool {
        let parts = [self.radii, self.uncapped, self.fields, self.normals];
        parts.contains(&true) || self.shading.is_some() || self.dropped_outliers.is_some()
    }

    /// Returns the cap of radii for this cloud.
    pub fn radius_cap_of(&self, cloud: &Cloud) -> f32 {
        let prepared = cloud.prepared.as_ref().map(|prepared| prepared.radius_cap);
        self.radius_cap.or(prepared).unwrap_or(radius::DEFAULT_CAP)
    }

    /// K for this cloud.
    pub fn neighbors_of(&self, cloud: &Cloud) -> usize {
        let prepared = cloud.prepared.as_ref().map(|prepared| prepared.neighbors);
        self.neighbors.or(prepared).unwrap_or(DEFAULT_NEIGHBORS)
    }

    /// Returns `true` if normals are wanted that the cloud lacks.
    pub(crate) fn lacks_normals(&self, cloud: &Cloud) -> bool {
        let wanted = self.normals || self.shading.is_some();
        wanted && cloud.normals.as_ref().is_none_or(|normals| normals.contains(&Vec3::ZERO))
    }

    /// Returns the definition of F for this cloud.
    pub fn field_of(&self, cloud: &Cloud) -> Field {
        let prepared = cloud.prepared.as_ref().map(|prepared| &prepared.field);
        self.field.as_ref().or(prepared).cloned().unwrap_or_default()
    }

    /// The radii that the file has and that serve.
    fn stored_radii<'a>(&self, cloud: &'a Cloud) -> Option<&'a [f32]> {
        let radii = cloud.radii.as_deref();
        radii.filter(|_| !cloud.prepared.as_ref().is_some_and(|p| p.estimated_radii && !self.has_radii_of(cloud, p)))
    }

    /// Returns `true` if radii were prepared as this request wants them.
    fn has_radii_of(&self, cloud: &Cloud, prepared: &Prepared) -> bool {
        prepared.neighbors == self.neighbors_of(cloud) && prepared.radius_cap == self.radius_cap_of(cloud)
    }

    /// The field that the file has, if it is the one that is wanted.
    fn stored_field<'a>(&self, cloud: &'a Cloud) -> Option<&'a [f32]> {
        let prepared = cloud.prepared.as_ref()?;
        let same_radii = prepared.field != Field::Uncertainty || self.has_radii_of(cloud, prepared);
        (prepared.field == self.field_of(cloud) && same_radii).then_some(&prepared.values)
    }

    /// Returns in words what has to be found from neighbors or from the whole cloud. `like` has the columns of the
    /// cloud. Normals to shade by don't count.
    #[doc(hidden)]
    pub fn missing(&self, like: &Cloud) -> Option<&'static str> {
        if self.uncapped {
            Some("the distances to neighbors that `surface_opacity` follows from")
        } else if self.soft_outliers.is_some() || self.dropped_outliers.is_some() {
            Some("the outliers")
        } else if self.radii && self.stored_radii(like).is_none() {
            Some("radii")
        } else if self.fields && self.stored_field(like).is_none() && self.field_of(like) == Field::Uncertainty {
            Some("the field \"uncertainty\"")
        } else {
            None
        }
    }

    /// Returns the field of which the range must be known.
    pub(crate) fn unscaled_field(&self, like: &Cloud) -> Option<Field> {
        (self.fields && self.stored_field(like).is_none()).then(|| self.field_of(like))
    }

    /// Returns warnings about prepared data that this request can't use, one sentence each.
    pub fn notes(&self, cloud: &Cloud) -> Vec<String> {
        let Some(prepared) = &cloud.prepared else { return Vec::new() };
        let difference = self.difference(cloud, prepared);
        let mut notes = Vec::new();
        if self.radii && cloud.radii.is_some() && self.stored_radii(cloud).is_none() {
            notes.push(format!("prepared with {difference}; radii are computed again"));
        }
        if self.fields && self.stored_field(cloud).is_none() {
            let (field, asked) = (&prepared.field, self.field_of(cloud));
            notes.push(if *field == asked {
                format!("prepared with {difference}; the field is computed again")
            } else {
                format!("prepared for field {:?} instead of {:?}; computed again", field.name(), asked.name())
            });
        }
        notes
    }

    /// Returns how a file was prepared and how it is wanted, as a phrase.
    fn difference(&self, cloud: &Cloud, prepared: &Prepared) -> String {
        let (neighbors, cap) = (self.neighbors_of(cloud), self.radius_cap_of(cloud));
        if prepared.neighbors != neighbors {
            return format!("{} neighbors, not {neighbors}", prepared.neighbors);
        }
        format!("radius_cap {}, not {cap}", prepared.radius_cap)
    }
}

/// Computes the requested data; radii, normals and uncertainty share one pass over the neighbors, outliers have one of
/// their own. Data in a prepared file is reused.
///
/// # Errors
/// The cloud lacks the property of its field.
pub fn find(cloud: &Cloud, request: &Request, progress: &Progress) -> Result<PointData, field::Error> {
    let (k, cap) = (request.neighbors_of(cloud), request.radius_cap_of(cloud));
    let mut radii = request.stored_radii(cloud).filter(|_| request.radii).map(<[f32]>::to_vec);
    let mut fields = request.stored_field(cloud).filter(|_| request.fields).map(<[f32]>::to_vec);
    let mut normals = cloud.normals.clone().filter(|_| request.normals);
    if request.fields && fields.is_none() {
        fields = request.field_of(cloud).values(cloud)?;
    }
    let lacks_fields = request.fields && fields.is_none();
    let (mut shading, mut uncapped) = (None, None);
    if request.lacks_normals(cloud) || lacks_fields {
        let wants = surface::Wants {
            radii: request.radii && radii.is_none(),
            uncapped: request.uncapped,
            normals: true,
            fields: lacks_fields,
            last: false,
        };
        let mut surface = surface::look(&cloud.positions, cloud.normals.as_deref(), (k, cap), wants, progress);
        radii = radii.or(Some(surface.radii).filter(|_| request.radii));
        uncapped = Some(surface.uncapped).filter(|_| request.uncapped);
        fields = fields.or(Some(surface.fields).filter(|_| request.fields));
        normals = request.normals.then(|| surface.normals.clone());
        shading = request.shading.map(|which| {
            to_shade_by(&mut surface.normals, cloud.normals.as_deref(), which, &surface.planar);
            surface.normals
        });
    }
    if (request.radii && radii.is_none()) || (request.uncapped && uncapped.is_none()) {
        let found = radius::both(&cloud.positions, k, cap, progress);
        radii = radii.or(Some(found.capped).filter(|_| request.radii));
        uncapped = Some(found.uncapped).filter(|_| request.uncapped);
    }
    if let (Some(fields), Some(rule)) = (&mut fields, request.soft_outliers) {
        let marks = outliers::find(&cloud.positions, rule, progress);
        fields.iter_mut().zip(marks).filter(|(_, mark)| *mark).for_each(|(field, _)| *field = 1.0);
    }
    let dropped = request.dropped_outliers.map(|rule| outliers::find(&cloud.positions, rule, progress));
    Ok(PointData { radii, uncapped, fields, normals, shading, dropped })
}

/// Returns the requested data that the points of a part of a cloud have with them; nothing is found from neighbors.
/// `bounds` and `range` are those of the whole cloud, the range that of what F is made of.
///
/// # Errors
/// The cloud lacks the property of its field.
pub(crate) fn of_part(
    cloud: &Cloud,
    request: &Request,
    bounds: Bounds,
    range: [f64; 2],
) -> Result<PointData, field::Error> {
    let radii = request.stored_radii(cloud).filter(|_| request.radii).map(<[f32]>::to_vec);
    let mut fields = request.stored_field(cloud).filter(|_| request.fields).map(<[f32]>::to_vec);
    if request.fields && fields.is_none() {
        let field = request.field_of(cloud);
        fields = field.unscaled(cloud, || Some(bounds))?.map(|values| field.scaled(&values, range));
    }
    Ok(PointData { radii, fields, ..PointData::default() })
}

/// Turns normals, some of them estimated where the `own` ones are missing, into those that are wanted.
fn to_shade_by(normals: &mut [Vec3], own: Option<&[Vec3]>, which: ShadingNormals, planar: &[bool]) {
    parallel::for_each_mut(normals, |i, normal| {
        if own.is_none_or(|own| own[i] == Vec3::ZERO) {
            let is_wanted = which == ShadingNormals::All || planar[i];
            *normal = if is_wanted { as_estimated(*normal) } else { Vec3::ZERO };
        }
    });
}

/// Returns the cloud with radii and field, and with normals if they are asked for, ready for
/// [`write_prepared`](pellucid_io::ply::write_prepared). A shadow texture that it has stays, unless normals are others.
///
/// # Errors
/// Returns an error if the cloud lacks the columns that its field is made of.
pub fn prepared(mut cloud: Cloud, request: &Request, progress: &Progress) -> Result<Cloud, field::Error> {
    // Marks of outliers aren't stored: whoever reads the file may ask for others.
    let request = Request { radii: true, fields: true, soft_outliers: None, ..request.clone() };
    let found = find(&cloud, &request, progress)?;
    // Shadows depend on normals.
    let same_normals = found.normals.is_none() || found.normals == cloud.normals;
    let shadows = cloud.prepared.as_mut().and_then(|prepared| prepared.shadows.take()).filter(|_| same_normals);
    cloud.prepared = Some(Prepared {
        neighbors: request.neighbors_of(&cloud),
        radius_cap: request.radius_cap_of(&cloud),
        estimated_radii: cloud.own_radii().is_none(),
        field: request.field_of(&cloud),
        values: found.fields.unwrap_or_default(),
        shadows,
    });
    cloud.radii = found.radii;
    // Normals that are all zero are dropped, as for a file.
    cloud.normals = found.normals.or(cloud.normals).filter(|normals| normals.iter().any(|n| *n != Vec3::ZERO));
    Ok(cloud)
}
