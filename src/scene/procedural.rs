//! The built-in scenes (stub).

use crate::cloud::Cloud;

/// Stub.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Stub.
    #[error("no built-in scene {0:?}")]
    Unknown(String),
}

/// Stub.
pub struct Generated {
    /// Stub.
    pub clouds: Vec<(String, Cloud)>,
    /// Stub.
    pub scene_toml: String,
}

/// Stub.
pub struct Parameter {
    /// Stub.
    pub name: &'static str,
    /// Stub.
    pub default: f64,
    /// Stub.
    pub min: f64,
    /// Stub.
    pub max: f64,
    /// Stub.
    pub summary: &'static str,
}

/// Stub.
pub struct Builtin {
    /// Stub.
    pub name: &'static str,
    /// Stub.
    pub summary: &'static str,
    /// Stub.
    pub parameters: &'static [Parameter],
}

/// Stub.
pub const BUILTINS: &[Builtin] = &[Builtin {
    name: "garden",
    summary: "a stub",
    parameters: &[Parameter { name: "points", default: 3.0, min: 3.0, max: 9.0, summary: "points" }],
}];

/// Stub.
pub fn build(name: &str, _parameters: &[(String, f64)], _seed: u64) -> Result<Generated, Error> {
    if name != "garden" {
        return Err(Error::Unknown(name.to_owned()));
    }
    let cloud = Cloud { positions: vec![glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y], ..Cloud::default() };
    Ok(Generated {
        clouds: vec![("garden.ply".into(), cloud)],
        scene_toml: "[[cloud]]\npath = \"garden.ply\"\nopacity = 0.3\n".into(),
    })
}
