//! SPZ 1 to 4, by Niantic: planes of bytes, one for each attribute.
//!
//! Up to version 3 header and planes are one gzip stream; in version 4 ([`streams`]) the header is plain and each plane
//! is a Zstandard stream. The planes are the same: positions, opacities, colors, scales, rotations, harmonics. The axes
//! of SPZ are right, up, back, unless an extension ([`extensions`]) names others; those of other splats are right,
//! down, front ([`frame`]). Splats get the latter.

mod extensions;
mod frame;
mod planes;
mod streams;

use std::io::Read;

use flate2::bufread::MultiGzDecoder;

use super::{Splats, all_bytes, check_count};
use crate::number::word;
use crate::{Error, InputFile, SharedFile};
use extensions::Extensions;
use pellucid_core::cloud::filter::Filter;
use pellucid_core::cloud::gaussians::MAX_DEGREE;
use pellucid_core::cloud::{Cloud, UpAxis};
use pellucid_core::progress::Progress;
use planes::Planes;

/// First bytes of the header.
pub(super) const MAGIC: &[u8] = b"NGSP";

/// First bytes of a gzip stream.
pub(super) const GZIP: &[u8] = b"\x1f\x8b";

/// Bytes of the header up to version 3, and of what version 4 has in common with it.
const HEADER: usize = 16;

/// Flags of the header.
const ANTIALIASED: u8 = 1;
const EXTENSIONS: u8 = 2;

/// The largest number of fractional bits of a position, which has 24 bits.
const MOST_FRACTION: u8 = 24;

/// Contents of the header.
#[derive(Debug, Clone, Copy)]
struct Header {
    version: u32,
    count: u64,
    degree: u32,
    /// Positions are multiples of 2 to the power of minus this.
    fraction: u8,
    flags: u8,
}

/// The parts of a file.
struct Content {
    header: Header,
    planes: Planes,
    /// Records of extensions.
    records: Vec<u8>,
}

pub(super) fn read(source: InputFile, progress: &Progress) -> Result<Cloud, Error> {
    let (file, bytes) = all_bytes(source)?;
    let Content { header, mut planes, records } = if bytes.starts_with(GZIP) {
        unzipped(&file, &bytes)?
    } else {
        let header = Header::parse(&file, &bytes)?;
        if header.version < 4 { plain(&file, &bytes, header)? } else { streams::read(&file, &bytes, header)? }
    };
    let has_extensions = header.flags & EXTENSIONS != 0;
    let extensions = if has_extensions { extensions::read(&records) } else { Ok(Extensions::default()) };
    let Extensions { frame, warnings } = extensions.map_err(|cause| file.malformed("extensions", cause))?;
    planes.frame = frame;
    let splats =
        Splats::gather(header.count as usize, header.degree, progress, |at, harmonics| planes.splat(at, harmonics));
    let mut cloud = splats.finish(UpAxis::NegativeY);
    cloud.filter = (header.flags & ANTIALIASED != 0).then_some(Filter::Mip);
    cloud.warnings.extend(warnings);
    Ok(cloud)
}

/// Planes that stand behind their header as they are.
fn plain(file: &SharedFile, bytes: &[u8], header: Header) -> Result<Content, Error> {
    header.check(file, None)?;
    let planes = Planes::cut(&header, &bytes[HEADER..]);
    let planes = planes.map_err(|lacking| file.truncated(format!("{lacking} of {} splats", header.count)))?;
    let end = HEADER as u64 + planes::lengths(&header).iter().sum::<u64>();
    let records = bytes.get(end as usize..).unwrap_or_default().to_vec();
    Ok(Content { header, planes, records })
}

/// The header and the planes of a gzip stream. No more of it is unpacked than the header announces.
fn unzipped(file: &SharedFile, bytes: &[u8]) -> Result<Content, Error> {
    let mut stream = MultiGzDecoder::new(bytes);
    let mut take = |most: u64| {
        let mut some = Vec::new();
        let read = stream.by_ref().take(most).read_to_end(&mut some);
        read.map(|_| some).map_err(|e| file.malformed("gzip stream", e.to_string()))
    };
    let start = take(HEADER as u64)?;
    if !start.starts_with(MAGIC) {
        let found = String::from_utf8_lossy(&start[..start.len().min(8)]).into_owned();
        let cause =
            format!("expected `NGSP` of an SPZ file in the gzip stream, found {found:?}; unpack other files first");
        return Err(file.malformed("byte 0", cause));
    }
    let header = Header::parse(file, &start)?;
    if header.version > 3 {
        let cause = format!("version {} in a gzip stream, expected 1, 2 or 3", header.version);
        return Err(file.malformed("byte 4 of the gzip stream", cause));
    }
    header.check(file, Some(bytes.len() as u64))?;
    let content = take(planes::lengths(&header).iter().sum())?;
    // Extensions may follow. If nothing does, or all of them are read, the checksum is compared.
    let records = take(if header.flags & EXTENSIONS != 0 { extensions::MOST_BYTES } else { 1 })?;
    let planes = Planes::cut(&header, &content);
    let planes = planes.map_err(|lacking| file.truncated(format!("{lacking} of {} splats", header.count)))?;
    Ok(Content { header, planes, records })
}

impl Header {
    fn parse(file: &SharedFile, bytes: &[u8]) -> Result<Self, Error> {
        if bytes.len() < HEADER {
            return Err(
                file.truncated(format!("the file has {} bytes, but the header alone has {HEADER}", bytes.len()))
            );
        }
        let header = Self {
            version: word(bytes, 4),
            count: word(bytes, 8).into(),
            degree: bytes[12].into(),
            fraction: bytes[13],
            flags: bytes[14],
        };
        let wrong = |at: u64, cause: String| Err(file.malformed(format!("byte {at} of the header"), cause));
        match header {
            Self { version: 0 | 5.., .. } => wrong(4, format!("SPZ version {}, expected 1 to 4", header.version)),
            Self { degree, .. } if degree > MAX_DEGREE => {
                wrong(12, format!("harmonics of degree {degree}, expected at most {MAX_DEGREE}"))
            }
            Self { fraction, .. } if fraction > MOST_FRACTION => {
                wrong(13, format!("{fraction} fractional bits of positions, expected at most {MOST_FRACTION}"))
            }
            header => Ok(header),
        }
    }

    /// Checks the number of splats, which so many packed bytes are to hold.
    fn check(&self, file: &SharedFile, packed: Option<u64>) -> Result<(), Error> {
        check_count(file, "byte 8 of the header", self.count, self.degree, packed)
    }
}
