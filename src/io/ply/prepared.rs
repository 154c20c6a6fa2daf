//! What `pellucid prepare` stores in a PLY file: the properties `radius` and `field`, and one comment that says what they
//! are and of which points (docs/prepared-clouds.md).

use serde::{Deserialize, Serialize};

use crate::cloud::{Cloud, Prepared, UpAxis};
use crate::prepare::field::Field;

/// The property that holds F.
pub(super) const FIELD: &str = "field";

/// The first word of the comment.
const WORD: &str = "pellucid-prepared";

/// Version of the format.
const VERSION: u64 = 1;

/// The comment's JSON.
#[derive(Serialize, Deserialize)]
struct Claim {
    version: u64,
    up: Up,
    neighbors: usize,
    radius: Radius,
    field: Field,
    /// [`content`] of the points; empty while it is computed.
    content: String,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Up {
    Y,
    Z,
}

#[derive(Serialize, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Radius {
    /// By Eq. 20.
    Estimated,
    /// As in the source.
    Own,
}

/// The comment of a prepared cloud.
pub(super) fn comment(cloud: &Cloud) -> std::io::Result<Option<String>> {
    let Some(prepared) = &cloud.prepared else { return Ok(None) };
    let mut claim = Claim {
        version: VERSION,
        up: match cloud.up {
            UpAxis::Y => Up::Y,
            UpAxis::Z => Up::Z,
        },
        neighbors: prepared.neighbors,
        radius: if prepared.estimated_radii { Radius::Estimated } else { Radius::Own },
        field: prepared.field.clone(),
        content: String::new(),
    };
    claim.content = content(cloud, &prepared.values, &claim)?;
    Ok(Some(format!("{WORD} {}", serde_json::to_string(&claim)?)))
}

/// Finds the comment and, if the points are those it speaks of, moves the field into [`Cloud::prepared`]; else says why
/// not and drops the field, and radii that are not the points' own.
pub(super) fn recognize(cloud: &mut Cloud, comments: &[(u64, String)]) {
    let ours = |(line, text): &(u64, String)| Some((*line, text.strip_prefix(WORD)?.trim().to_owned()));
    let Some((line, text)) = comments.iter().find_map(ours) else { return };
    let mut claim = match read(&text) {
        Ok(claim) => claim,
        Err(why) => {
            cloud.warnings.push(format!("line {line}: {why}; what `pellucid prepare` stored is not used as such"));
            return;
        }
    };
    let claimed = std::mem::take(&mut claim.content);
    cloud.up = match claim.up {
        Up::Y => UpAxis::Y,
        Up::Z => UpAxis::Z,
    };
    let at = cloud.scalars.iter().position(|(name, _)| name == FIELD);
    let values = at.map(|at| cloud.scalars.remove(at).1).unwrap_or_default();
    let whole = values.len() == cloud.len() && values.iter().all(|value| (0.0..=1.0).contains(value));
    if whole && content(cloud, &values, &claim).is_ok_and(|content| content == claimed) {
        let estimated_radii = claim.radius == Radius::Estimated;
        cloud.prepared = Some(Prepared { neighbors: claim.neighbors, estimated_radii, field: claim.field, values });
        return;
    }
    if claim.radius == Radius::Estimated {
        cloud.radii = None;
    }
    cloud.warnings.push(format!(
        "line {line}: the points were changed since `pellucid prepare`: radii and field are computed anew (prepare them \
         again)"
    ));
}

fn read(text: &str) -> Result<Claim, String> {
    let unreadable = |error: serde_json::Error| format!("the comment `{WORD}` can't be read ({error})");
    let value: serde_json::Value = serde_json::from_str(text).map_err(unreadable)?;
    match value.get("version").and_then(serde_json::Value::as_u64) {
        Some(version) if version > VERSION => {
            return Err(format!("prepared in format {version}, of which this version knows only {VERSION}"));
        }
        Some(VERSION) => {}
        _ => return Err(format!("the comment `{WORD}` names no version of the format")),
    }
    let claim: Claim = serde_json::from_value(value).map_err(unreadable)?;
    if claim.neighbors == 0 || claim.neighbors > 65_535 {
        return Err(format!("the comment `{WORD}` claims {} neighbors", claim.neighbors));
    }
    Ok(claim)
}

/// A hash of what was computed and of what it depends on: the comment itself, positions, normals, radii, field, classes,
/// intensity and scalars, but not colors and opacities, which may be changed.
fn content(cloud: &Cloud, values: &[f32], claim: &Claim) -> std::io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    let mut add = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    add(serde_json::to_string(claim)?.as_bytes());
    // In the byte order of the machine, which is that of the file on all that have Vulkan.
    add(bytemuck::cast_slice(&cloud.positions));
    add(bytemuck::cast_slice(cloud.normals.as_deref().unwrap_or_default()));
    add(bytemuck::cast_slice(cloud.radii.as_deref().unwrap_or_default()));
    add(bytemuck::cast_slice(values));
    add(cloud.classification.as_deref().unwrap_or_default());
    add(bytemuck::cast_slice(cloud.intensity.as_deref().unwrap_or_default()));
    for (_, values) in &cloud.scalars {
        add(bytemuck::cast_slice(values));
    }
    Ok(hasher.finalize().to_hex().to_string())
}
