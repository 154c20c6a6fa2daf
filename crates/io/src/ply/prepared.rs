//! Data that `pellucid prepare` stores in a PLY file: the properties `radius`, `field` and perhaps `lit`, and one
//! comment that describes them and identifies the points (docs/prepared-clouds.md).

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::prepared::check_claim;
use pellucid_core::cloud::crs::Crs;
use pellucid_core::cloud::field::Field;
use pellucid_core::cloud::shadow_texture::{Casting, ShadowTexture};
use pellucid_core::cloud::{Cloud, Prepared, UpAxis};

/// The property that holds F.
pub(super) const FIELD: &str = "field";

/// The property that holds m, the last one.
pub(super) const LIT: &str = "lit";

/// The first word of the comment.
const WORD: &str = "pellucid-prepared";

/// Version of the format.
const VERSION: u64 = 1;

/// The comment's JSON.
#[derive(Serialize, Deserialize)]
struct Claim {
    version: u64,
    up: UpAxis,
    neighbors: usize,
    /// Omitted where there is none: files that were prepared before there were caps have none.
    #[serde(default, skip_serializing_if = "is_none")]
    radius_cap: f32,
    radius: Radius,
    field: Field,
    /// [`content`] of the points; empty while it is computed.
    content: String,
    /// The description of `lit`; omitted while `content` is computed, since older readers don't know it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    shadows: Option<ShadowClaim>,
    /// The coordinate reference system of the source; omitted while `content` is computed, as `shadows` is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    crs: Option<Crs>,
}

/// The comment's description of `lit`.
#[derive(Serialize, Deserialize)]
struct ShadowClaim {
    #[serde(flatten)]
    casting: Casting,
    /// [`shadow_content`]; empty while it is computed.
    content: String,
}

/// True for a cap of 0, which is none.
fn is_none(cap: &f32) -> bool {
    *cap == 0.0
}

#[derive(Serialize, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Radius {
    /// Estimated by Eq. 20.
    Estimated,
    /// Taken from the source.
    Own,
}

/// Returns the comment of a prepared cloud.
pub(super) fn comment(cloud: &Cloud) -> std::io::Result<Option<String>> {
    let Some(prepared) = &cloud.prepared else { return Ok(None) };
    let mut claim = Claim {
        version: VERSION,
        up: cloud.up,
        neighbors: prepared.neighbors,
        radius_cap: prepared.radius_cap,
        radius: if prepared.estimated_radii { Radius::Estimated } else { Radius::Own },
        field: prepared.field.clone(),
        content: String::new(),
        shadows: None,
        crs: None,
    };
    let lit = prepared.shadows.as_ref().map(|shadows| shadows.lit.as_slice());
    claim.content = content(cloud, &prepared.values, lit, &claim)?;
    if let Some(texture) = &prepared.shadows {
        let mut shadows = ShadowClaim { casting: texture.casting, content: String::new() };
        shadows.content = shadow_content(&shadows, &claim.content)?;
        claim.shadows = Some(shadows);
    }
    claim.crs = cloud.crs.as_deref().cloned();
    Ok(Some(format!("{WORD} {}", serde_json::to_string(&claim)?)))
}

/// Returns `true` if `pellucid prepare` wrote the file: its data belong to all of its points together.
pub(crate) fn is_prepared(comments: &[(u64, String)]) -> bool {
    comments.iter().any(|(_, text)| text.starts_with(WORD))
}

/// Finds the comment and, if the points match it, moves the field into [`Cloud::prepared`]. Otherwise adds a warning
/// and drops the field, and also the radii unless they are the points' own.
pub(super) fn recognize(cloud: &mut Cloud, comments: &[(u64, String)]) {
    let ours = |(line, text): &(u64, String)| Some((*line, text.strip_prefix(WORD)?.trim().to_owned()));
    let Some((line, text)) = comments.iter().find_map(ours) else { return };
    let mut claim = match read(&text) {
        Ok(claim) => claim,
        Err(why) => {
            cloud.warnings.push(format!("line {line}: {why}; the values stored by `pellucid prepare` are ignored"));
            return;
        }
    };
    let (claimed, shadows) = (std::mem::take(&mut claim.content), claim.shadows.take());
    cloud.crs = claim.crs.take().map(|crs| Arc::new(crs.checked()));
    cloud.up = claim.up;
    cloud.up_reason = None;
    let at = cloud.scalars.iter().position(|(name, _)| name == FIELD);
    let values = at.map(|at| cloud.scalars.remove(at).1).unwrap_or_default();
    let whole = values.len() == cloud.len() && values.iter().all(|value| (0.0..=1.0).contains(value));
    // `lit` is among the scalars there.
    let unchanged = whole && content(cloud, &values, None, &claim).is_ok_and(|content| content == claimed);
    let at = cloud.scalars.iter().rposition(|(name, _)| name == LIT).filter(|_| shadows.is_some());
    let lit = at.map(|at| cloud.scalars.remove(at).1).unwrap_or_default();
    if unchanged {
        let shadows = shadows.and_then(|shadows| {
            let texture = texture(shadows, lit, cloud.len(), &claimed);
            if texture.is_none() {
                cloud
                    .warnings
                    .push(format!("line {line}: the comment about `lit` was changed; shadows are cast again"));
            }
            texture
        });
        let (neighbors, radius_cap) = (claim.neighbors, claim.radius_cap);
        let estimated_radii = claim.radius == Radius::Estimated;
        cloud.prepared = Some(Prepared { neighbors, radius_cap, estimated_radii, field: claim.field, values, shadows });
        return;
    }
    if claim.radius == Radius::Estimated {
        cloud.radii = None;
    }
    cloud.warnings.push(format!(
        "line {line}: the points changed after `pellucid prepare`; radii and field are computed again (prepare the file \
         again)"
    ));
}

/// The shadow texture of `lit`, if its values match the comment.
fn texture(mut claim: ShadowClaim, lit: Vec<f32>, len: usize, content: &str) -> Option<ShadowTexture> {
    let claimed = std::mem::take(&mut claim.content);
    let whole = lit.len() == len && lit.iter().all(|m| (0.0..=1.0).contains(m));
    let same = whole && shadow_content(&claim, content).is_ok_and(|content| content == claimed);
    same.then_some(ShadowTexture { casting: claim.casting, lit })
}

fn read(text: &str) -> Result<Claim, String> {
    let unreadable = |error: serde_json::Error| format!("the comment `{WORD}` can't be read ({error})");
    let value: serde_json::Value = serde_json::from_str(text).map_err(unreadable)?;
    match value.get("version").and_then(serde_json::Value::as_u64) {
        Some(version) if version > VERSION => {
            return Err(format!("it was prepared in format {version}, but this program reads only format {VERSION}"));
        }
        Some(VERSION) => {}
        _ => return Err(format!("the comment `{WORD}` names no version of the format")),
    }
    let claim: Claim = serde_json::from_value(value).map_err(unreadable)?;
    check_claim(claim.neighbors, claim.radius_cap).map_err(|cause| format!("the comment `{WORD}` {cause}"))?;
    Ok(claim)
}

/// A hash of the computed data and everything it depends on: the comment itself, positions, normals, radii, field,
/// classes, intensity and scalars, including `lit` as the last one. Colors and opacities are excluded, since they may
/// change.
fn content(cloud: &Cloud, values: &[f32], lit: Option<&[f32]>, claim: &Claim) -> std::io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    let mut add = |bytes: &[u8]| {
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(bytes);
    };
    add(serde_json::to_string(claim)?.as_bytes());
    // In the machine's byte order, which is the file's on all machines with Vulkan.
    add(bytemuck::cast_slice(&cloud.positions));
    add(bytemuck::cast_slice(cloud.normals.as_deref().unwrap_or_default()));
    add(bytemuck::cast_slice(cloud.radii.as_deref().unwrap_or_default()));
    add(bytemuck::cast_slice(values));
    add(cloud.classification.as_deref().unwrap_or_default());
    add(bytemuck::cast_slice(cloud.intensity.as_deref().unwrap_or_default()));
    for values in cloud.scalars.iter().map(|(_, values)| values.as_slice()).chain(lit) {
        add(bytemuck::cast_slice(values));
    }
    Ok(hasher.finalize().to_hex().to_string())
}

/// A hash of the comment's description of `lit` and, through the hash of all points, of `lit` itself.
fn shadow_content(claim: &ShadowClaim, content: &str) -> std::io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    for text in [&*serde_json::to_string(claim)?, content] {
        hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
    }
    Ok(hasher.finalize().to_hex().to_string())
}
