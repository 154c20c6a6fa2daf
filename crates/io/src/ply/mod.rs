//! PLY files: text and both binary orders, any scalar type, any other elements.
//!
//! Properties of a vertex are known by the names common tools use; its lists and all other elements are skipped.
//!
//! - position: `x y z`; any type, world units.
//! - normal: `nx ny nz`, `normal_x normal_y normal_z`, `normalx normaly normalz`; normalized.
//! - color: `red green blue`, `r g b`, `Rf Gf Bf`, also behind `diffuse_`, `vertex_`, `color_`, `f_`, `scalar_`;
//!   sRGB-encoded: bytes of 255; other types of 1, 255, 1023, 4095 or 65535, by the largest value of the file.
//! - color: `linear_red linear_green linear_blue`; linear.
//! - alpha: `alpha`, `diffuse_alpha`; as colors, but not encoded; ignored if it is 0 everywhere.
//! - radius: `radius`; negative and non-finite values count as 0.
//! - classification: `classification`, `class`, `label`, and these after `scalar_`; integers in 0–255, else a scalar.
//! - intensity: `intensity`, `scalar_intensity`; as stored.
//!
//! Values out of range are clamped; a color that is not a number is 0. Normals and colors need all three properties;
//! otherwise, and for any other name, a property is a scalar column of its own name. A comment marks the additions of
//! `pellucid prepare` (docs/prepared-clouds.md), another one states the vertical (`vertical`). Gaussian splats are
//! recognized by their properties (`splats`, `compressed`).

mod compressed;
mod header;
mod payload;
mod prepared;
mod rows;
mod splats;
mod vertical;
mod write;
mod write_splats;

use pellucid_core::progress::Progress;
use ply_rs_bw::ply::Encoding;

use super::columns::{Column, PointTable, RowLayout};
use super::{Error, InputFile, PROGRESS_STEP, memory};
use compressed::Compressed;
use header::{Element, PlyHeader, PlyType};
use pellucid_core::cloud::Cloud;
pub(super) use prepared::is_prepared;
pub(super) use rows::VertexRows;
use splats::{SplatColumns, SplatPart};
pub(super) use vertical::{stated, step, vertical};
pub use write::{write, write_prepared, write_to};

/// Reads the vertices of a PLY file.
pub(super) fn read(source: InputFile, progress: &Progress) -> Result<Cloud, Error> {
    let (vertices, remarks) = Vertices::find(source)?;
    let mut cloud = match vertices {
        Vertices::Rows(rows) => {
            memory::check(rows.file.path(), rows.count, rows.layout.bytes())?;
            progress.set_length(rows.count);
            rows.parse(0..rows.count, progress)?.0.into_cloud(&rows.layout)
        }
        Vertices::Splats(rows, splats) => splats::read_rows(&rows, &splats, progress)?,
        Vertices::Compressed(splats) => splats.read(progress)?,
        Vertices::Records(records) => records.read(progress)?,
    };
    let comments = &remarks.comments;
    let has_gaussians = cloud.gaussians.is_some();
    if has_gaussians {
        cloud.filter = splats::filter(comments).or(cloud.filter);
    } else {
        find_vertical(&mut cloud);
    }
    cloud.warnings.extend(remarks.missing);
    match stated(comments) {
        Ok(None) => {}
        Ok(Some(up)) => (cloud.up, cloud.up_reason) = (up, None),
        Err(warning) => cloud.warnings.push(warning),
    }
    if !has_gaussians {
        prepared::recognize(&mut cloud, comments);
    }
    Ok(cloud)
}

/// Facts that a header tells of the vertices beside their properties.
pub(super) struct Remarks {
    /// Comments with the numbers of their lines.
    pub comments: Vec<(u64, String)>,
    /// A warning about what points lack to be splats, if they are meant to be some.
    pub missing: Option<String>,
}

/// Tells the vertical of a cloud from its points, where nothing else says it.
pub fn find_vertical(cloud: &mut Cloud) {
    if let Some(bounds) = cloud.bounds() {
        let step = step((cloud.len() + cloud.non_finite) as u64);
        let sample: Vec<_> = cloud.positions.iter().step_by(step).copied().collect();
        (cloud.up, cloud.up_reason) = vertical(&bounds, &sample);
    }
}

/// The vertices of a file whose header is read.
pub(super) enum Vertices {
    /// Rows that several threads read from anywhere.
    Rows(Box<VertexRows>),
    /// Splats that are such rows.
    Splats(Box<VertexRows>, Box<SplatColumns>),
    /// Splats in words and ranges.
    Compressed(Box<Compressed>),
    /// Text and what has lists: one by one.
    Records(Box<Records>),
}

impl Vertices {
    /// Reads the header; also returns what else it says.
    pub fn find(mut source: InputFile) -> Result<(Self, Remarks), Error> {
        let mut header = header::read(&mut source)?;
        let Some(at) = header.elements.iter().position(|e| e.name == "vertex") else {
            let names: Vec<_> = header.elements.iter().map(|e| e.name.as_str()).collect();
            return Err(source.malformed("header", format!("no element `vertex`, only [{}]", names.join(", "))));
        };
        let comments = std::mem::take(&mut header.comments);
        let vertex = &header.elements[at];
        let text = header.encoding == Encoding::Ascii;
        if !text && compressed::are_compressed(vertex) {
            let remarks = Remarks { comments, missing: None };
            return Ok((Self::Compressed(Box::new(Compressed::new(source, header, at))), remarks));
        }
        let scalars = vertex.scalars();
        let layout = RowLayout::new(&scalars).map_err(|missing| Error::MissingProperty {
            path: source.path.clone(),
            missing,
            found: vertex.names(),
        })?;
        check_claim(&source, &header.elements[..=at], header.len, text)?;
        let splats = SplatColumns::find(&scalars).map(Box::new);
        let missing = if splats.is_none() { splats::missing(&scalars) } else { None };
        let are_rows = rows::are_rows(&header, vertex);
        let vertices = match splats {
            Some(splats) if are_rows => Self::Splats(Box::new(VertexRows::find(source, &header, at, layout)?), splats),
            None if are_rows => Self::Rows(Box::new(VertexRows::find(source, &header, at, layout)?)),
            splats => Self::Records(Box::new(Records { source, header, at, splats, layout })),
        };
        Ok((vertices, Remarks { comments, missing }))
    }
}

/// Vertices that are read one by one.
pub(super) struct Records {
    source: InputFile,
    header: PlyHeader,
    at: usize,
    splats: Option<Box<SplatColumns>>,
    layout: RowLayout,
}

impl Records {
    fn read(self, progress: &Progress) -> Result<Cloud, Error> {
        let Self { mut source, header, at, splats, layout } = self;
        let source = &mut source;
        let vertex = &header.elements[at];
        match &splats {
            Some(splats) => splats.check(&source.path, vertex.count)?,
            None => memory::check(&source.path, vertex.count, layout.bytes())?,
        }
        progress.set_length(vertex.count);
        let mut table = PointTable::new(&layout, 0);
        let mut row = Vec::with_capacity(vertex.properties.len());
        let mut part = splats.as_ref().map(|splats| SplatPart::new(splats, 0));
        let mut take = |row: &[f64], index: u64| {
            match &mut part {
                None => table.push(&layout, row),
                Some(part) => part.push(|at| row[at]),
            }
            if (index + 1).is_multiple_of(PROGRESS_STEP) {
                progress.inc(PROGRESS_STEP);
            }
        };
        if header.encoding == Encoding::Ascii {
            let mut lines = payload::Lines::after_header(&header);
            for element in &header.elements[..at] {
                lines.skip(source, element)?;
            }
            for index in 0..vertex.count {
                lines.read(source, vertex, index, &mut row)?;
                take(&row, index);
            }
        } else {
            let binary = payload::Binary { little_endian: header.encoding == Encoding::BinaryLittleEndian };
            for element in &header.elements[..at] {
                binary.skip(source, element)?;
            }
            for index in 0..vertex.count {
                binary.read(source, vertex, index, &mut row)?;
                take(&row, index);
            }
        }
        progress.set_position(vertex.count);
        if let (Some(splats), Some(part)) = (&splats, part) {
            return Ok(SplatPart::finish(splats, vec![part]));
        }
        Ok(table.into_cloud(&layout))
    }
}

/// Compares the claimed number of elements, up to the vertices, with the bytes that follow the header.
fn check_claim(source: &InputFile, elements: &[Element], header_len: u64, text: bool) -> Result<(), Error> {
    let mut left = source.len.saturating_sub(header_len);
    for element in elements {
        // The shortest line has a digit and a separator for each value.
        let least = if text { 2 * element.properties.len() as u64 } else { element.least_bytes() };
        // The last line of a text needs no line end.
        let room = left + u64::from(text);
        if let Some(possible) = room.checked_div(least).filter(|&possible| possible < element.count) {
            return Err(source.truncated(format!(
                "the header announces {} × element `{}` of at least {least} bytes each, but the {left} bytes left hold at \
                 most {possible}",
                element.count, element.name,
            )));
        }
        left -= (least * element.count).min(left);
    }
    Ok(())
}

impl Element {
    /// Bytes of one binary record with all its lists empty.
    fn least_bytes(&self) -> u64 {
        self.properties.iter().map(|p| header::size(p.kind.first())).sum()
    }

    /// The properties that are no lists.
    fn scalars(&self) -> Vec<Column> {
        let scalar = |p: &header::Property| Some(Column::new(&p.name, p.kind.scalar()?.clone()));
        self.properties.iter().filter_map(scalar).collect()
    }

    /// The scalar properties, for messages.
    fn names(&self) -> String {
        let names: Vec<_> = self.properties.iter().filter(|p| p.kind.scalar().is_some()).map(|p| &*p.name).collect();
        format!("[{}]", names.join(", "))
    }
}

impl PlyType {
    /// The type, unless it is a list.
    fn scalar(&self) -> Option<&header::ScalarType> {
        match self {
            Self::Scalar(scalar) => Some(scalar),
            Self::List { .. } => None,
        }
    }

    /// The type of the first value: of a list its count.
    fn first(&self) -> &header::ScalarType {
        match self {
            Self::Scalar(scalar) => scalar,
            Self::List { count, .. } => count,
        }
    }
}
