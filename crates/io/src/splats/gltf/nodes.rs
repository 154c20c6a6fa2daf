//! The primitives of splats in a scene, and how their nodes place them.

use glam::{DMat3, DMat4, DQuat, DVec3};

use super::document::{Document, Node, PrimitiveOf};

/// Largest difference of a transform from one that keeps angles, relative to its scale.
const TOLERANCE: f64 = 1e-4;

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
    pub scale: f64,
    pub rotation: DQuat,
    pub translation: DVec3,
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
        let off = (unit.transpose() * unit - DMat3::IDENTITY).to_cols_array();
        if off.iter().any(|off| off.abs() > TOLERANCE) || unit.determinant() < 0.0 {
            return Err(
                "it mirrors splats, or scales them differently along its axes, which is not supported; apply it to the splats first"
                    .to_owned(),
            );
        }
        let translation = matrix.w_axis.truncate();
        Ok(Self { scale, rotation: DQuat::from_mat3(&unit).normalize(), translation })
    }

    /// Returns the position that a point moves to.
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.rotation * (point * self.scale) + self.translation
    }
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
        for scale in [[1.0, 1.0, -1.0], [1.0, 1.0, 1.1], [0.0; 3], [f64::INFINITY; 3]] {
            assert!(Transform::of(matrix(&Node { scale: Some(scale), ..Node::default() })).is_err(), "{scale:?}");
        }
        assert!(Transform::of(matrix(&Node { rotation: Some([0.0; 4]), ..Node::default() })).is_err());
    }
}
