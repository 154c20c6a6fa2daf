//! Deep OpenEXR: for each pixel a list of samples with a depth each, written line by line.
//!
//! One part of type `deepscanline`, after OpenEXR's "File Layout"; what samples mean is in its "Interpreting Deep
//! Pixels". A chunk is one line. Lines are written as they come, and the table of their places and the length of the
//! longest list once all of them are there, so that no more than the lines in work is ever held.

mod block;
mod header;
mod tidy;

use std::io::{self, Seek, SeekFrom, Write};

pub use tidy::tidy;

use block::Line;
use pellucid_core::camera::Camera;
use pellucid_core::parallel;

/// A sample of a pixel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Sample {
    /// Linear red, green and blue times opacity, and the opacity, in [0, 1].
    pub rgba: [f32; 4],
    /// Depth at which the sample begins, along the viewing axis.
    pub depth: f32,
    /// Depth at which the sample ends: the same for a surface.
    pub back: f32,
}

/// Order of the samples of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Samples ordered by depth, no two at the same one, volumes split where others begin or end.
    Tidy,
    /// Samples ordered by depth, each as it was found.
    Sorted,
}

/// The numbers of color and opacity. Depths are always float32.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbers {
    /// 32 bits.
    Float,
    /// 16 bits, to the nearest; what is beyond 65504 becomes 65504.
    Half,
}

/// Packing of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Packing {
    /// ZIPS compression, without loss.
    Zips,
    /// Not at all.
    Raw,
}

/// Contents of a file except its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct DeepLayout {
    /// Columns and rows, at least 1 each.
    pub size: [u32; 2],
    /// Order of the samples.
    pub state: State,
    /// `true` if the header tells the order, as OpenEXR's attribute `deepImageState`. Its Python module refuses files
    /// that have it (3.5.3).
    pub tells_state: bool,
    /// The numbers of color and opacity.
    pub numbers: Numbers,
    /// Packing of lines.
    pub packing: Packing,
    /// `true` if samples have a length: with a channel `ZBack`.
    pub volumes: bool,
    /// Names and values.
    pub metadata: Vec<(String, String)>,
    /// The camera of OpenEXR's standard attributes `worldToCamera` and `worldToNDC`, if there was one.
    pub camera: Option<Camera>,
}

impl DeepLayout {
    /// Bytes of a sample before it is packed.
    pub fn sample_bytes(&self) -> u64 {
        let color = if self.numbers == Numbers::Half { 2 } else { 4 };
        4 * color + if self.volumes { 8 } else { 4 }
    }

    /// Returns bytes of a file with so many samples at most: lines that packing doesn't make smaller are written as
    /// they are.
    ///
    /// # Errors
    /// Metadata that no header can hold.
    pub fn most_bytes(&self, samples: u64) -> io::Result<u64> {
        let [width, height] = self.size.map(u64::from);
        let head = header::bytes(self)?.bytes.len() as u64;
        let lines = height * (8 + block::HEAD_BYTES + 4 * width);
        Ok((head + lines).saturating_add(samples.saturating_mul(self.sample_bytes())))
    }
}

/// The counts of a written file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Written {
    /// Samples of all pixels.
    pub samples: u64,
    /// Samples of the pixel that has most.
    pub longest: u32,
    /// Bytes of the file.
    pub bytes: u64,
}

/// Writes a file whose pixels come row by row.
pub struct Writer<'a, W> {
    out: W,
    layout: &'a DeepLayout,
    /// Offset of the length of the longest list; the table of lines follows.
    longest_at: u64,
    table_at: u64,
    table: Vec<u64>,
    /// Offset of the next line.
    at: u64,
    written: Written,
    /// Pixels of lines that are not complete.
    lengths: Vec<u32>,
    samples: Vec<Sample>,
}

impl<'a, W: Write + Seek> Writer<'a, W> {
    /// Writes the header.
    ///
    /// # Errors
    /// Returns the errors of the system, and an error for output that one can't go back in, and metadata that no header
    /// can hold.
    pub fn begin(mut out: W, layout: &'a DeepLayout) -> io::Result<Self> {
        out.stream_position().map_err(|_| invalid("a deep EXR can't go to a pipe; name a file"))?;
        let header = header::bytes(layout)?;
        out.write_all(&header.bytes)?;
        let lines = layout.size[1] as usize;
        let table_at = header.bytes.len() as u64;
        // Their places are not known yet.
        (0..lines).try_for_each(|_| out.write_all(&[0; 8]))?;
        Ok(Self {
            out,
            layout,
            longest_at: header.longest_at,
            table_at,
            table: Vec::new(),
            at: table_at + 8 * lines as u64,
            written: Written { samples: 0, longest: 0, bytes: 0 },
            lengths: Vec::new(),
            samples: Vec::new(),
        })
    }

    /// Takes the next pixels: how many samples each has, and all their samples.
    ///
    /// # Errors
    /// Returns the errors of the system, and an error for more pixels than the image has, another number of samples
    /// than the lengths say, and a line of 2 GiB or more, which OpenEXR does not read.
    pub fn push(&mut self, lengths: &[u32], samples: &[Sample]) -> io::Result<()> {
        if lengths.iter().map(|n| u64::from(*n)).sum::<u64>() != samples.len() as u64 {
            return Err(invalid("the lengths of lists are not those of the samples"));
        }
        self.lengths.extend_from_slice(lengths);
        self.samples.extend_from_slice(samples);
        let width = self.layout.size[0] as usize;
        let first = self.table.len();
        let complete = self.lengths.len() / width;
        if self.lengths.len() > (self.layout.size[1] as usize - first) * width {
            return Err(invalid("more pixels than the image has"));
        }
        let mut rest = self.samples.as_slice();
        let mut lines = Vec::with_capacity(complete);
        for (y, lengths) in (first as u32..).zip(self.lengths.chunks_exact(width)) {
            let (samples, others) = rest.split_at(lengths.iter().map(|n| *n as usize).sum());
            lines.push(Line { y, lengths, samples });
            rest = others;
        }
        for chunk in parallel::try_map_each(&lines, |line| line.encode(self.layout))? {
            self.out.write_all(&chunk)?;
            self.table.push(self.at);
            self.at += chunk.len() as u64;
        }
        let taken = self.samples.len() - rest.len();
        let longest = lengths.iter().copied().max().unwrap_or(0);
        self.written.longest = self.written.longest.max(longest);
        self.written.samples += samples.len() as u64;
        self.samples.drain(..taken);
        self.lengths.drain(..complete * width);
        Ok(())
    }

    /// Writes what stands before the lines.
    ///
    /// # Errors
    /// Returns the errors of the system, and an error for lines that are missing.
    pub fn finish(mut self) -> io::Result<Written> {
        if self.table.len() != self.layout.size[1] as usize || !self.lengths.is_empty() {
            return Err(invalid("fewer pixels than the image has"));
        }
        let longest = i32::try_from(self.written.longest).map_err(|_| invalid("a pixel has more than 2^31 samples"))?;
        self.out.seek(SeekFrom::Start(self.longest_at))?;
        self.out.write_all(&longest.to_le_bytes())?;
        self.out.seek(SeekFrom::Start(self.table_at))?;
        self.table.iter().try_for_each(|at| self.out.write_all(&at.to_le_bytes()))?;
        self.out.flush()?;
        Ok(Written { bytes: self.at, ..self.written })
    }
}

fn invalid(reason: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, reason.into())
}
