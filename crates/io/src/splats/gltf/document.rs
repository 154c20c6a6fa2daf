//! The JSON of a glTF file, as far as splats need it, and the chunks of the binary form.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Map, Value};

use super::{EXTENSION, MAGIC};
use crate::number::word;
use crate::{Error, SharedFile};

/// Types of the chunks that are read.
const JSON: u32 = u32::from_le_bytes(*b"JSON");
const BIN: u32 = u32::from_le_bytes(*b"BIN\0");

/// Extensions that a file may require.
const KNOWN: [&str; 2] = [EXTENSION, "KHR_mesh_quantization"];

#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Document {
    pub scene: Option<usize>,
    pub scenes: Vec<Scene>,
    pub nodes: Vec<Node>,
    pub meshes: Vec<Mesh>,
    pub accessors: Vec<Accessor>,
    pub buffer_views: Vec<BufferView>,
    pub buffers: Vec<Buffer>,
    extensions_required: Vec<String>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct Node {
    pub mesh: Option<usize>,
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Mesh {
    pub primitives: Vec<PrimitiveOf>,
}

/// A primitive of a mesh.
#[derive(Debug, Deserialize)]
pub(super) struct PrimitiveOf {
    pub attributes: BTreeMap<String, usize>,
    pub mode: Option<u64>,
    #[serde(default)]
    pub extensions: Map<String, Value>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<Value>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: u64,
}

impl PrimitiveOf {
    /// Returns what the extension says, of a primitive of splats.
    pub fn splats(&self) -> Option<&Value> {
        self.extensions.get(EXTENSION)
    }
}

impl Document {
    /// Parses the text, or says what is wrong with it.
    pub fn parse(text: &[u8]) -> Result<Self, String> {
        serde_json::from_slice(text).map_err(|e| e.to_string())
    }

    /// Checks that all is known that must be.
    pub fn check(&self) -> Result<(), String> {
        match self.extensions_required.iter().find(|name| !KNOWN.contains(&name.as_str())) {
            Some(name) if name.contains("compression") => {
                Err(format!("the file needs {name}, which is not supported; write the file without compression"))
            }
            Some(name) => Err(format!(
                "the file requires {name}, which is not supported; if its splats are right without it, move the name to \
                 extensionsUsed alone"
            )),
            None => Ok(()),
        }
    }
}

/// Returns the text of a file, and the bytes behind it in a binary one.
pub(super) fn chunks<'a>(file: &SharedFile, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), Error> {
    if !bytes.starts_with(MAGIC) {
        return Ok((bytes, None));
    }
    let (version, len) = (word(bytes, 4), word(bytes, 8) as usize);
    if bytes.len() < 12 || len > bytes.len() {
        return Err(file.truncated(format!("{} bytes, but the header announces {len}", bytes.len())));
    }
    if version != 2 {
        return Err(file.malformed("byte 4", format!("glTF version {version}, expected 2")));
    }
    let (kind, text, rest) = chunk(file, bytes, 12)?;
    if kind != JSON {
        return Err(file.malformed("byte 16", "the first chunk is not JSON"));
    }
    if rest + 8 > bytes.len() {
        return Ok((text, None));
    }
    let (kind, binary, _) = chunk(file, bytes, rest)?;
    Ok((text, (kind == BIN).then_some(binary)))
}

/// Type and content of the chunk at a byte, and the byte behind it.
fn chunk<'a>(file: &SharedFile, bytes: &'a [u8], at: usize) -> Result<(u32, &'a [u8], usize), Error> {
    let (len, kind, start) = (word(bytes, at) as usize, word(bytes, at + 4), at + 8);
    match bytes.get(start..).and_then(|rest| rest.get(..len)) {
        Some(content) => Ok((kind, content, start + len)),
        None => {
            Err(file
                .truncated(format!("a chunk has {len} bytes from byte {start} on, but the file has {}", bytes.len())))
        }
    }
}
