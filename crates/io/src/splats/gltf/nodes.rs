//! The primitives of splats in a scene, and how their nodes place them.

use glam::{DMat3, DMat4, DQuat, DVec3};

use super::document::{Document, Node, PrimitiveOf};

/// Largest difference of a transform from one that keeps angles, relative to its scale.
const TOLERANCE: f64 = 1e-4;

/// Smallest determinant of a transform relative to that of its mean scale.
const FLATTEST: f64 = 1e-9;

/// The `mode` of points.
const POINTS: u64 = 0;

/// The `mode` of a primitive that has none: triangles.
const TRIANGLES: u64 = 4;

/// A primitive of splats at a place.
pub(super) struct Placed<'a> {
    pub mesh: usize,
    /// Index of the primitive in the mesh.
    pub number: usize,
    pub primitive: &'a PrimitiveOf,
    pub transform: Transform,
}

/// A turn and a scale, then a move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Transform {
    scale: f64,
    /// The turn; of a stretch the rotation that is closest to it.
    pub rotation: DQuat,
    /// Both in one, where scales differ along axes.
    stretch: Option<DMat3>,
    translation: DVec3,
}

/// A place in the file, and what is wrong there.
type Wrong = (String, String);

/// Returns all primitives of splats in the scene, and the number of other primitives.
pub(super) fn find(document: &Document) -> Result<(Vec<Placed<'_>>, usize), Wrong> {
    let (mut placed, mut others) = (Vec::new(), 0);
    let mut seen = vec![false; document.nodes.len()];
    let mut waiting: Vec<(usize, DMat4)> = roots(document)?.into_iter().map(|node| (node, DMat4::IDENTITY)).collect();
    waiting.reverse();
    while let Some((number, above)) = waiting.pop() {
        let place = || format!("node {number}");
        let node = document.nodes.get(number).ok_or_else(|| (place(), "there is no such node".to_owned()))?;
        if std::mem::replace(&mut seen[number], true) {
            return Err((place(), "it belongs to two nodes, or to itself".to_owned()));
        }
        let world = above * matrix(node);
        waiting.extend(node.children.iter().rev().map(|child| (*child, world)));
        let Some(mesh) = node.mesh else { continue };
        let Some(of) = document.meshes.get(mesh) else { return Err((place(), format!("there is no mesh {mesh}"))) };
        for (at, primitive) in of.primitives.iter().enumerate() {
            if primitive.splats().is_none() {
                others += 1;
                continue;
            }
            let mode = primitive.mode.unwrap_or(TRIANGLES);
            if mode != POINTS {
                let cause = format!("splats of mode {mode}, expected {POINTS}: points");
                return Err((format!("mesh {mesh}, primitive {at}"), cause));
            }
            let transform = Transform::of(world).map_err(|cause| (place(), cause))?;
            placed.push(Placed { mesh, number: at, primitive, transform });
        }
    }
    Ok((placed, others))
}

/// The nodes of the scene that have no other above them; without scenes, of the file.
fn roots(document: &Document) -> Result<Vec<usize>, Wrong> {
    let number = document.scene.unwrap_or(0);
    match document.scenes.get(number) {
        Some(scene) => Ok(scene.nodes.clone()),
        None if document.scene.is_some() => Err(("scene".to_owned(), format!("there is no scene {number}"))),
        None => {
            let mut is_root = vec![true; document.nodes.len()];
            let children = document.nodes.iter().flat_map(|node| &node.children);
            children.for_each(|child| is_root.iter_mut().skip(*child).take(1).for_each(|root| *root = false));
            Ok((0..is_root.len()).filter(|at| is_root[*at]).collect())
        }
    }
}

fn matrix(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix);
    }
    let rotation = DMat4::from_mat3(turned(node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0])));
    let scale = DMat4::from_mat3(DMat3::from_diagonal(node.scale.unwrap_or([1.0; 3]).into()));
    DMat4::from_translation(node.translation.unwrap_or([0.0; 3]).into()) * rotation * scale
}

/// The matrix of a quaternion of any length; of one without a direction it is not finite.
fn turned(quaternion: [f64; 4]) -> DMat3 {
    let [x, y, z, w] = quaternion;
    let twice = 2.0 / (x * x + y * y + z * z + w * w);
    let row = |a: f64, b: f64, c: f64| DVec3::new(a, b, c) * twice;
    let columns = [
        row(-(y * y + z * z), x * y + w * z, x * z - w * y),
        row(x * y - w * z, -(x * x + z * z), y * z + w * x),
        row(x * z + w * y, y * z - w * x, -(x * x + y * y)),
    ];
    DMat3::from_cols(columns[0] + DVec3::X, columns[1] + DVec3::Y, columns[2] + DVec3::Z)
}

impl Transform {
    /// The parts of a matrix, or why splats can't follow it.
    fn of(matrix: DMat4) -> Result<Self, String> {
        let linear = DMat3::from_mat4(matrix);
        let lengths = [linear.x_axis.length(), linear.y_axis.length(), linear.z_axis.length()];
        let scale = lengths.iter().sum::<f64>() / 3.0;
        if !(matrix.is_finite() && scale > 0.0) {
            return Err("its transform is not finite, or shrinks everything to a point".to_owned());
        }
        let unit = linear * (1.0 / scale);
        if unit.determinant() < FLATTEST {
            return Err(
                "it mirrors or flattens splats, which is not supported; apply it to the splats first".to_owned()
            );
        }
        let off = (unit.transpose() * unit - DMat3::IDENTITY).to_cols_array();
        let stretch = off.iter().any(|off| off.abs() > TOLERANCE).then_some(linear);
        let rotation = if stretch.is_some() { closest_rotation(unit) } else { unit };
        let translation = matrix.w_axis.truncate();
        Ok(Self { scale, rotation: DQuat::from_mat3(&rotation).normalize(), stretch, translation })
    }

    /// Returns the position that a point moves to.
    pub fn point(&self, point: DVec3) -> DVec3 {
        match &self.stretch {
            Some(stretch) => *stretch * point + self.translation,
            None => self.rotation * (point * self.scale) + self.translation,
        }
    }

    /// Returns the extents and the rotation that a splat of these has then.
    pub fn shape(&self, extents: DVec3, rotation: DQuat) -> (DVec3, DQuat) {
        match &self.stretch {
            Some(stretch) => {
                let turned = turned(rotation.to_array());
                ellipsoid(*stretch * turned * DMat3::from_diagonal(extents))
            }
            None => (extents * self.scale, self.rotation * rotation),
        }
    }

    /// Returns `true` if scales differ along axes.
    pub fn stretches(&self) -> bool {
        self.stretch.is_some()
    }
}

/// The rotation that is closest to a matrix of positive determinant: the mean of it and its inverse transpose, again
/// and again (Higham 1986).
fn closest_rotation(matrix: DMat3) -> DMat3 {
    // Each step halves large and small singular values, and then doubles the digits.
    (0..60).fold(matrix, |matrix, _| (matrix + matrix.inverse().transpose()) * 0.5)
}

/// The half axes of the ellipsoid that a matrix makes of the unit sphere, and the rotation to them: pairs of columns
/// are turned into each other until all are at right angles (Hestenes 1958).
fn ellipsoid(mut matrix: DMat3) -> (DVec3, DQuat) {
    for _ in 0..30 {
        for [p, q] in [[0, 1], [0, 2], [1, 2]] {
            let (a, b) = (matrix.col(p), matrix.col(q));
            let product = a.dot(b);
            if product.abs() <= 1e-16 * a.length() * b.length() {
                continue;
            }
            let zeta = (b.length_squared() - a.length_squared()) / (2.0 * product);
            let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
            let cosine = 1.0 / tangent.hypot(1.0);
            *matrix.col_mut(p) = cosine * (a - tangent * b);
            *matrix.col_mut(q) = cosine * (b + tangent * a);
        }
    }
    let extents = DVec3::new(matrix.x_axis.length(), matrix.y_axis.length(), matrix.z_axis.length());
    // Along an axis without extent any direction will do that fits.
    let mut axes = [0, 1, 2].map(|at| matrix.col(at).try_normalize());
    for at in 0..3 {
        let [next, last] = [(at + 1) % 3, (at + 2) % 3];
        axes[at] = axes[at].or_else(|| match (axes[next], axes[last]) {
            (Some(next), Some(last)) => Some(next.cross(last)),
            (Some(one), None) | (None, Some(one)) => Some(one.any_orthonormal_vector()),
            (None, None) => Some(DVec3::X),
        });
    }
    let [x, y, z] = axes.map(|axis| axis.unwrap_or(DVec3::X));
    let z = if x.cross(y).dot(z) < 0.0 { -z } else { z };
    (extents, DQuat::from_mat3(&DMat3::from_cols(x, y, z)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_place_what_is_below_them() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let turn =
            Node { rotation: Some([0.0, 0.0, half * 3.0, half * 3.0]), scale: Some([2.0; 3]), ..Node::default() };
        let moved = Node { translation: Some([1.0, 0.0, 0.0]), ..Node::default() };
        let transform = Transform::of(matrix(&turn) * matrix(&moved)).unwrap();
        // A quarter turn about z takes x to y.
        assert!(transform.point(DVec3::ZERO).distance(DVec3::new(0.0, 2.0, 0.0)) < 1e-12);
        assert!((transform.scale - 2.0).abs() < 1e-12);
        for scale in [[1.0, 1.0, -1.0], [1.0, 1.0, 0.0], [0.0; 3], [f64::INFINITY; 3]] {
            assert!(Transform::of(matrix(&Node { scale: Some(scale), ..Node::default() })).is_err(), "{scale:?}");
        }
        assert!(Transform::of(matrix(&Node { rotation: Some([0.0; 4]), ..Node::default() })).is_err());
    }

    #[test]
    fn stretched_splats_are_the_stretched_ellipsoids() {
        let of = |scale: [f64; 3]| Transform::of(matrix(&Node { scale: Some(scale), ..Node::default() })).unwrap();
        // Along the axes extents are multiplied one by one.
        let (extents, rotation) = of([2.0, 1.0, 0.5]).shape(DVec3::new(1.0, 2.0, 4.0), DQuat::IDENTITY);
        assert_eq!((extents, rotation), (DVec3::splat(2.0), DQuat::IDENTITY));
        assert_eq!(of([2.0, 1.0, 0.5]).point(DVec3::ONE), DVec3::new(2.0, 1.0, 0.5));
        assert!(!of([2.0; 3]).stretches() && of([2.0, 2.0, 2.1]).stretches());
        // A turned node above a stretched one; splats of three, two and one extents.
        let turn = DQuat::from_xyzw(0.3, -0.5, 0.1, 0.8).normalize();
        let above = Node { rotation: Some(turn.to_array()), ..Node::default() };
        let stretch = Node { scale: Some([3.0, 0.25, 1.5]), ..Node::default() };
        let transform = Transform::of(matrix(&above) * matrix(&stretch)).unwrap();
        // Without a shear the closest rotation is the turn.
        assert!(transform.rotation.dot(turn).abs() > 1.0 - 1e-12);
        let own = DQuat::from_xyzw(-0.2, 0.4, 0.7, 0.1).normalize();
        for extents in [DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 0.5, 0.0), DVec3::new(0.0, 2.0, 0.0)] {
            let covariance = |matrix: DMat3, extents: DVec3| {
                let axes = matrix * DMat3::from_diagonal(extents);
                axes * axes.transpose()
            };
            let linear = DMat3::from_quat(turn) * DMat3::from_diagonal(DVec3::new(3.0, 0.25, 1.5));
            let expected = covariance(linear * DMat3::from_quat(own), extents);
            let (found, rotation) = transform.shape(extents, own);
            assert!(rotation.is_normalized(), "{rotation}");
            let off = covariance(DMat3::from_quat(rotation), found) - expected;
            assert!(off.to_cols_array().iter().all(|off| off.abs() < 1e-12), "{extents}: {off}");
        }
    }
}
