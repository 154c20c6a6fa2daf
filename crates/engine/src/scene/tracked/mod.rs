//! The points of a scene that is edited: they know where they came from, so that settings which leave them where they are cost
//! no more than the columns that they change.
//!
//! [`arrange`](super::arrange) orders points by position first. Colors, opacities, radii and fields decide only between points
//! of equal position, so when they change, each point keeps its place but for those that share theirs with others.

mod known;
mod origins;

use std::sync::Arc;

use crate::progress::Progress;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

pub use known::Known;

use super::assemble::{self, color, opacity, radius, request};
use super::error::Error;
use super::settings::{CloudSettings, Scene};
use crate::cloud::Cloud;
use crate::points::{Changes, Points};
use crate::prepare::Arranged;
use crate::prepare::ensembles::{self, Trace};
use crate::prepare::order;
use crate::prepare::ties::Ties;
use known::{FieldKey, field_key};
use origins::Origins;

/// What [`arrange`](super::arrange) makes of a scene, and how to make of it, in place, what it makes of another one. Beside the
/// points it takes 4 bytes for each point that was dealt and 8 for each that shares its position with another.
#[derive(Debug, Clone)]
pub struct Tracked {
    arranged: Arranged,
    stand: Stand,
    looks: Vec<Look>,
    /// Of points that were dealt; the others have theirs in [`Points::file_order`].
    dealt: Vec<u32>,
    ties: Ties,
    origins: Origins,
}

/// What the positions of points and their order depend on; numbers by their bits, as the order goes by them.
#[derive(Debug, Clone, PartialEq)]
struct Stand {
    dealt: bool,
    /// Scale and translation.
    clouds: Vec<(u64, [u64; 3])>,
}

impl Stand {
    fn of(scene: &Scene) -> Self {
        let bits = |translate: DVec3| translate.to_array().map(f64::to_bits);
        let clouds = scene.clouds.iter().map(|cloud| (cloud.scale.to_bits(), bits(cloud.translate)));
        Self { dealt: scene.method.is_dealt(), clouds: clouds.collect() }
    }
}

/// What the other columns of a cloud's points depend on; numbers by their bits.
#[derive(Debug, Clone, PartialEq)]
struct Look {
    color: Option<[u32; 3]>,
    opacity: u32,
    /// Given radius, factor, and K if radii are asked for.
    radius: (Option<u32>, u32, Option<usize>),
    /// If it is asked for.
    field: Option<FieldKey>,
}

fn bits_of(color: Vec3) -> [u32; 3] {
    color.to_array().map(f32::to_bits)
}

/// A cloud as a scene shows it.
#[derive(Clone, Copy)]
struct Seen<'a> {
    settings: &'a CloudSettings,
    cloud: &'a Cloud,
    /// Where the settings have none: memory is visited in another order than it lies in.
    colors: Option<&'a [Vec3]>,
    /// As colors.
    radii: Option<&'a [f32]>,
    fields: Option<&'a [f32]>,
}

impl Seen<'_> {
    fn color(&self, i: usize) -> Vec3 {
        color(self.settings, self.colors.map(|colors| colors[i]))
    }

    fn opacity(&self, i: usize) -> f32 {
        opacity(self.settings, self.cloud.alphas.as_ref().map(|alphas| alphas[i]))
    }

    fn radius(&self, i: usize) -> f32 {
        radius(self.settings, self.radii.map(|radii| radii[i]))
    }

    fn field(&self, i: usize) -> f32 {
        self.fields.map_or(0.0, |fields| fields[i])
    }

    /// All points, and which are left if some aren't finite any more.
    fn points(&self) -> (Points, Option<Vec<bool>>) {
        let count = self.cloud.len();
        let all = || (0..count).into_par_iter();
        let mut points = Points {
            positions: self.cloud.positions.par_iter().map(|p| assemble::placed(self.settings, *p)).collect(),
            colors: all().map(|i| self.color(i)).collect(),
            opacities: all().map(|i| self.opacity(i)).collect(),
            radii: all().map(|i| self.radius(i)).collect(),
            normals: self.cloud.normals.clone(),
            file_order: Vec::new(),
            fields: self.fields.map_or_else(Vec::new, <[f32]>::to_vec),
        };
        let keep = assemble::drop_non_finite(&mut points);
        (points, keep)
    }
}

/// Finds what a scene needs to know of its clouds' points: how they look.
fn learn(scene: &Scene, clouds: &[Cloud], known: &mut [Known], progress: &Progress) -> Result<Vec<Look>, Error> {
    let method = &scene.method;
    let each = scene.clouds.iter().zip(clouds).zip(known);
    let look = |((settings, cloud), known): ((&CloudSettings, &Cloud), &mut Known)| {
        let request = request(settings, method.needs_radii(), method.needs_field());
        let found = known.learn(cloud, &request, progress);
        found.map_err(|source| Error::Field { path: settings.path.clone(), source })?;
        let neighbors = request.radii.then(|| request.neighbors_of(cloud));
        Ok(Look {
            color: settings.color.map(bits_of),
            opacity: settings.opacity.to_bits(),
            radius: (settings.radius.map(f32::to_bits), settings.radius_factor.to_bits(), neighbors),
            field: request.fields.then(|| field_key(cloud, &request)),
        })
    };
    each.map(look).collect()
}

/// The clouds as a scene shows them whose looks were learned.
fn seen<'a>(scene: &'a Scene, clouds: &'a [Cloud], known: &'a [Known], looks: &[Look]) -> Vec<Seen<'a>> {
    let each = scene.clouds.iter().zip(clouds).zip(known).zip(looks);
    each.map(|(((settings, cloud), known), look)| {
        let own = if look.radius.2.is_some() { known.radii() } else { cloud.radii.as_deref() };
        let radii = own.filter(|_| settings.radius.is_none());
        let colors = cloud.colors.as_deref().filter(|_| settings.color.is_none());
        let fields = if look.field.is_some() { known.fields() } else { None };
        Seen { settings, cloud, colors, radii, fields }
    })
    .collect()
}

impl Tracked {
    /// The points of a scene: what [`arrange`](super::arrange) makes of it. `known` holds as many as there are clouds, and what
    /// was found before.
    ///
    /// # Errors
    /// No point is left, or a cloud lacks what its field is made of.
    pub fn new(
        scene: &Scene,
        clouds: &[Cloud],
        known: &mut [Known],
        seed: u64,
        progress: &Progress,
    ) -> Result<Self, Error> {
        let looks = learn(scene, clouds, known, progress)?;
        let (mut placed, mut origins) = (Vec::new(), Origins::default());
        for seen in seen(scene, clouds, known, &looks) {
            let (points, keep) = seen.points();
            origins.push(points.len(), keep.as_deref());
            placed.push(points);
        }
        let stand = Stand::of(scene);
        progress.reset();
        let (arranged, trace) = if stand.dealt {
            progress.set_message("dealing points to ensembles");
            let mut trace = Trace::default();
            let dealt = ensembles::deal_traced(placed, seed, progress, Some(&mut trace));
            (Arranged::Dealt(dealt), trace)
        } else {
            progress.set_message("putting points into order");
            let mut points = Points::default();
            placed.into_iter().for_each(|cloud| points.append(cloud));
            let points = order::canonical(points);
            let ties = Ties::of(&points.positions);
            (Arranged::Canonical(points), Trace { origins: Vec::new(), ties })
        };
        if arranged.points().is_empty() {
            return Err(assemble::no_points(scene));
        }
        Ok(Self { arranged, stand, looks, dealt: trace.origins, ties: trace.ties, origins })
    }

    /// The points as they are arranged.
    pub fn arranged(&self) -> &Arranged {
        &self.arranged
    }

    /// All points, in either order.
    pub fn points(&self) -> &Points {
        self.arranged.points()
    }

    /// Makes of the points what [`arrange`](super::arrange) makes of another scene of the same clouds, in place. `None`, and all
    /// stays as it was, if they would be elsewhere: then they must be arranged anew. A list that was dealt is copied if somebody
    /// shares it.
    ///
    /// # Errors
    /// A cloud lacks what its field is made of; all stays as it was.
    pub fn follow(
        &mut self,
        scene: &Scene,
        clouds: &[Cloud],
        known: &mut [Known],
        progress: &Progress,
    ) -> Result<Option<Changes>, Error> {
        if Stand::of(scene) != self.stand {
            return Ok(None);
        }
        let looks = learn(scene, clouds, known, progress)?;
        if looks == self.looks {
            return Ok(Some(Changes::default()));
        }
        let seen = seen(scene, clouds, known, &looks);
        let Self { arranged, dealt, ties, origins, .. } = self;
        let points = match arranged {
            Arranged::Canonical(points) => points,
            Arranged::Dealt(dealt) => Arc::make_mut(&mut dealt.points),
        };
        let mut order = std::mem::take(if self.stand.dealt { dealt } else { &mut points.file_order });
        let mut changes = Repaint { origins, order: &order, seen: &seen, was: &self.looks, is: &looks }.all(points);
        changes.order = changes.any() && ties.settle(points, &mut order);
        *(if self.stand.dealt { dealt } else { &mut points.file_order }) = order;
        if let (Arranged::Dealt(dealt), true) = (arranged, changes.opacities) {
            dealt.renew_opacities();
        }
        self.looks = looks;
        Ok(Some(changes))
    }
}

/// Columns of points that look otherwise.
struct Repaint<'a> {
    origins: &'a Origins,
    /// Of each place the number of its point.
    order: &'a [u32],
    seen: &'a [Seen<'a>],
    was: &'a [Look],
    is: &'a [Look],
}

impl<'a> Repaint<'a> {
    /// Gives all columns their values; which ones have others than before.
    fn all(&self, points: &mut Points) -> Changes {
        let colors = self.changed(|look| look.color);
        let opacities = self.changed(|look| look.opacity);
        let radii = self.changed(|look| look.radius);
        Changes {
            colors: self.column(&mut points.colors, &colors, Seen::color, bits_of),
            opacities: self.column(&mut points.opacities, &opacities, Seen::opacity, f32::to_bits),
            radii: self.column(&mut points.radii, &radii, Seen::radius, f32::to_bits),
            fields: self.fields(&mut points.fields),
            order: false,
        }
    }

    /// F comes and goes with the method, of all clouds together.
    fn fields(&self, fields: &mut Vec<f32>) -> bool {
        let wanted = self.is.iter().all(|look| look.field.is_some());
        let toggled = wanted == fields.is_empty();
        match (wanted, toggled) {
            (true, true) => *fields = vec![0.0; self.order.len()],
            (false, true) => *fields = Vec::new(),
            _ => {}
        }
        let changed = self.changed(|look| look.field.clone());
        (wanted && self.column(fields, &changed, Seen::field, f32::to_bits)) || toggled
    }

    /// Which clouds look otherwise in some regard.
    fn changed<K: PartialEq>(&self, regard: impl Fn(&Look) -> K) -> Vec<bool> {
        self.was.iter().zip(self.is).map(|(was, is)| regard(was) != regard(is)).collect()
    }

    /// Gives a column the values of the clouds that changed; whether any is another one.
    fn column<T: Copy + Send, K: PartialEq>(
        &self,
        column: &mut [T],
        changed: &[bool],
        value: impl Fn(&Seen<'a>, usize) -> T + Sync,
        bits: impl Fn(T) -> K + Sync,
    ) -> bool {
        if !changed.contains(&true) {
            return false;
        }
        let each = column.par_iter_mut().zip(self.order).map(|(to, number)| {
            let (cloud, i) = self.origins.of(*number);
            if !changed[cloud] {
                return false;
            }
            let before = std::mem::replace(to, value(&self.seen[cloud], i));
            bits(before) != bits(*to)
        });
        each.reduce(|| false, |a, b| a | b)
    }
}
