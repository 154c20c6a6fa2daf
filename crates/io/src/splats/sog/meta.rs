//! `meta.json` of SOG splats.

use serde::Deserialize;
use serde_json::Value;

use super::super::check_count;
use super::META;
use super::files::Files;
use crate::Error;
use pellucid_core::cloud::filter::Filter;
use pellucid_core::cloud::gaussians::{MAX_DEGREE, coefficients};

/// The version that is read.
const VERSION: u64 = 2;

/// Entries of a table, one for each value of a byte.
const ENTRIES: usize = 256;

/// The largest palette: its entries have numbers of 16 bits.
const MOST_ENTRIES: u32 = 1 << 16;

/// Meaning of the pictures.
#[derive(Debug, Deserialize)]
pub(super) struct Meta {
    pub count: u64,
    pub means: Means,
    pub scales: Coded,
    pub quats: Quats,
    pub sh0: Coded,
    #[serde(rename = "shN")]
    pub harmonics: Option<Harmonics>,
    #[serde(default)]
    antialias: bool,
    model: Option<String>,
}

/// Positions: their range, as logarithms, and the pictures of the low and of the high bytes.
#[derive(Debug, Deserialize)]
pub(super) struct Means {
    pub mins: [f64; 3],
    pub maxs: [f64; 3],
    pub files: [String; 2],
}

#[derive(Debug, Deserialize)]
pub(super) struct Quats {
    pub files: [String; 1],
}

/// A picture whose bytes are numbers of a table.
#[derive(Debug, Deserialize)]
pub(super) struct Coded {
    pub codebook: Codebook,
    pub files: [String; 1],
}

/// Harmonics: the picture of a palette, and that of the entry of each splat.
#[derive(Debug, Deserialize)]
pub(super) struct Harmonics {
    /// Entries of the palette.
    pub count: u32,
    /// The degree.
    pub bands: u32,
    pub codebook: Codebook,
    pub files: [String; 2],
}

/// The numbers that bytes stand for.
#[derive(Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct Codebook(Vec<f64>);

impl Codebook {
    /// Returns the number of a byte; NaN beyond the table, so that a splat with it is left out.
    pub fn number(&self, byte: u8) -> f64 {
        self.0.get(usize::from(byte)).copied().unwrap_or(f64::NAN)
    }
}

impl Meta {
    /// Reads and checks it.
    pub fn read(files: &Files) -> Result<Self, Error> {
        let bytes = files.read(META)?;
        let wrong = |cause: String| files.malformed(META, cause);
        let value: Value = serde_json::from_slice(&bytes).map_err(|e| wrong(format!("not JSON: {e}")))?;
        match value.get("version").and_then(Value::as_u64) {
            Some(VERSION) => {}
            Some(other) => return Err(wrong(format!("SOG version {other}, expected {VERSION}"))),
            None if value.get("means").is_some() => {
                return Err(wrong(
                    "no `version`: SOG 1 is not supported; convert it with a newer version of its tool, which writes SOG \
                     2".into(),
                ));
            }
            None => {
                return Err(wrong(
                    "there is neither `version` nor `means`, so this does not describe SOG splats".into(),
                ));
            }
        }
        let meta: Self = serde_json::from_value(value).map_err(|e| wrong(e.to_string()))?;
        meta.check(files)?;
        Ok(meta)
    }

    fn check(&self, files: &Files) -> Result<(), Error> {
        let wrong = |cause: String| Err(files.malformed(META, cause));
        let none = Codebook(Vec::new());
        let harmonics = self.harmonics.as_ref();
        let tables = [&self.scales.codebook, &self.sh0.codebook, harmonics.map_or(&none, |some| &some.codebook)];
        for (table, name) in tables.into_iter().zip(["scales", "sh0", "shN"]) {
            let needed = name != "shN" || self.degree() > 0;
            if table.0.len() > ENTRIES || table.0.is_empty() && needed {
                return wrong(format!("`{name}.codebook` has {} numbers, expected 1 to {ENTRIES}", table.0.len()));
            }
        }
        if self.degree() > MAX_DEGREE {
            return wrong(format!("`shN.bands` is {}, expected at most {MAX_DEGREE}", self.degree()));
        }
        if let Some(harmonics) = harmonics.filter(|_| self.degree() > 0)
            && !(1..=MOST_ENTRIES).contains(&harmonics.count)
        {
            return wrong(format!("`shN.count` is {}, expected 1 to {MOST_ENTRIES}", harmonics.count));
        }
        // Of a folder, the pictures say more; they are checked one by one.
        let packed = matches!(files, Files::Archive { .. }).then(|| files.file().len());
        check_count(files.file(), META, self.count, self.degree(), packed)
    }

    /// Returns the degree of the harmonics.
    pub fn degree(&self) -> u32 {
        self.harmonics.as_ref().map_or(0, |harmonics| harmonics.bands)
    }

    /// Returns the number of coefficients of a splat from degree 1 on.
    pub fn coefficients(&self) -> usize {
        coefficients(self.degree())
    }

    /// Returns the filter that splats are for.
    pub fn filter(&self) -> Option<Filter> {
        let named = self.model.as_deref().and_then(Filter::named);
        named.or_else(|| self.antialias.then_some(Filter::Mip))
    }
}
