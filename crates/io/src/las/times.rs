//! GPS times of compressed points.
//!
//! A file may interleave four sequences of times, as two scanners do. The library's decoder calls itself for each
//! change between them, as often as a damaged file says, until the stack is full, which ends the process. This one
//! counts the changes.

use std::io::{Cursor, Error, ErrorKind, Read, Result, Seek};

use laz::DecompressionSelection;
use laz::decoders::ArithmeticDecoder;
use laz::decompressors::{IntegerDecompressor, IntegerDecompressorBuilder};
use laz::models::{ArithmeticModel, ArithmeticModelBuilder};
use laz::record::{FieldDecompressor, LayeredFieldDecompressor};

/// Changes of the sequence for one time. Writers make one; with three, each of the four sequences is reached.
const MOST_CHANGES: usize = 3;

/// Codes for the multiples of the last difference: from it up, the difference is a multiple of 500 and more, then
/// negative ones.
const LARGEST_MULTIPLE: u32 = 500;
/// Least multiple.
const LEAST_MULTIPLE: i32 = -10;
/// The first code that is no multiple.
const NO_MULTIPLE: u32 = LARGEST_MULTIPLE + LEAST_MULTIPLE.unsigned_abs() + 1;

/// Extreme multiples in a row after which the difference counts as the new one.
const EXTREMES: u32 = 3;

/// The four sequences of times, as bits of float64, of which differences are taken.
struct Sequences {
    /// 1 in the older compression, which has a code for a time that stays the same; else 0.
    unchanged: u32,
    last: usize,
    next: usize,
    times: [i64; 4],
    diffs: [i32; 4],
    extremes: [u32; 4],
    /// Codes after a difference of 0.
    first_codes: ArithmeticModel,
    /// Codes after other ones.
    codes: ArithmeticModel,
    integers: IntegerDecompressor,
}

impl Sequences {
    fn new(first: i64, unchanged: u32) -> Self {
        Self {
            unchanged,
            last: 0,
            next: 0,
            times: [first, 0, 0, 0],
            diffs: [0; 4],
            extremes: [0; 4],
            first_codes: ArithmeticModelBuilder::new(5 + unchanged).build(),
            codes: ArithmeticModelBuilder::new(NO_MULTIPLE + 4 + unchanged).build(),
            integers: IntegerDecompressorBuilder::new().bits(32).contexts(9).build_initialized(),
        }
    }

    /// The next time.
    fn time<R: Read>(&mut self, decoder: &mut ArithmeticDecoder<R>) -> Result<i64> {
        for _ in 0..=MOST_CHANGES {
            let change = if self.diffs[self.last] == 0 { self.after_none(decoder)? } else { self.after_one(decoder)? };
            match change {
                0 => return Ok(self.times[self.last]),
                change => self.last = (self.last + change as usize) & 3,
            }
        }
        Err(Error::new(ErrorKind::InvalidData, "the GPS times change their sequence without end"))
    }

    /// Decodes a time after a difference of 0, or how far away another sequence is.
    fn after_none<R: Read>(&mut self, decoder: &mut ArithmeticDecoder<R>) -> Result<u32> {
        match decoder.decode_symbol(&mut self.first_codes)?.checked_sub(self.unchanged) {
            None => {}
            Some(0) => {
                let diff = self.integers.decompress(decoder, 0, 0)?;
                self.diffs[self.last] = diff;
                self.extremes[self.last] = 0;
                self.add(diff);
            }
            Some(1) => self.whole(decoder)?,
            Some(code) => return Ok(code - 1),
        }
        Ok(0)
    }

    /// Decodes a time after another difference, or how far away another sequence is.
    fn after_one<R: Read>(&mut self, decoder: &mut ArithmeticDecoder<R>) -> Result<u32> {
        let code = decoder.decode_symbol(&mut self.codes)?;
        if code >= NO_MULTIPLE {
            match (code - NO_MULTIPLE).checked_sub(self.unchanged) {
                None => {}
                Some(0) => self.whole(decoder)?,
                Some(change) => return Ok(change),
            }
            return Ok(0);
        }
        let multiple = if code > LARGEST_MULTIPLE { (LARGEST_MULTIPLE as i32) - code as i32 } else { code as i32 };
        let (context, is_extreme) = match multiple {
            1 => (1, false),
            0 => (7, true),
            2..10 => (2, false),
            10..500 => (3, false),
            500.. => (4, true),
            LEAST_MULTIPLE => (6, true),
            _ => (5, false),
        };
        let last = self.last;
        let diff = self.integers.decompress(decoder, multiple.wrapping_mul(self.diffs[last]), context)?;
        if multiple == 1 {
            self.extremes[last] = 0;
        }
        if is_extreme {
            self.extremes[last] += 1;
            if self.extremes[last] > EXTREMES {
                self.diffs[last] = diff;
                self.extremes[last] = 0;
            }
        }
        self.add(diff);
        Ok(0)
    }

    fn add(&mut self, diff: i32) {
        let time = &mut self.times[self.last];
        *time = time.wrapping_add(diff.into());
    }

    /// Begins a sequence with a time that is stored as it is.
    fn whole<R: Read>(&mut self, decoder: &mut ArithmeticDecoder<R>) -> Result<()> {
        self.next = (self.next + 1) & 3;
        let upper = self.integers.decompress(decoder, (self.times[self.last] >> 32) as i32, 8)?;
        self.last = self.next;
        self.times[self.last] = i64::from(upper) << 32 | i64::from(decoder.read_int()?);
        self.diffs[self.last] = 0;
        self.extremes[self.last] = 0;
        Ok(())
    }
}

/// The times of LAS 1.0 to 1.3, version 2 of their compression.
#[derive(Default)]
pub(super) struct GpsTime(Option<Sequences>);

impl<R: Read> FieldDecompressor<R> for GpsTime {
    fn size_of_field(&self) -> usize {
        size_of::<i64>()
    }

    fn decompress_first(&mut self, src: &mut R, first_point: &mut [u8]) -> Result<()> {
        src.read_exact(first_point)?;
        self.0 = Some(Sequences::new(bits(first_point), 1));
        Ok(())
    }

    fn decompress_with(&mut self, decoder: &mut ArithmeticDecoder<R>, buf: &mut [u8]) -> Result<()> {
        if let Some(sequences) = &mut self.0 {
            buf.copy_from_slice(&sequences.time(decoder)?.to_le_bytes());
        }
        Ok(())
    }
}

/// The bits of a time.
fn bits(bytes: &[u8]) -> i64 {
    bytes.first_chunk().map_or(0, |bytes| i64::from_le_bytes(*bytes))
}

/// Bytes of a point of LAS 1.4 without colors and extra dimensions.
const POINT: usize = 30;
/// Byte with the scanner channel in bits 4 and 5.
const FLAGS: usize = 15;
/// First byte of the time.
const TIME: usize = 22;

/// Layers: that of the channels, returns and coordinates is the first one, that of the times the last.
const LAYERS: usize = 9;
/// Bytes of a layer's size.
const SIZE: usize = 4;

/// Points of LAS 1.4 with times. The library decodes the rest.
///
/// Which points have another time than the one before is known only within the library. So it decodes the coordinates a
/// second time, with a layer of times that ends at once: it fails at each point that has another time, after all else
/// of the point.
#[derive(Default)]
pub(super) struct Timed<D> {
    points: D,
    changes: D,
    /// Sizes of the layers, little-endian.
    sizes: [[u8; SIZE]; LAYERS],
    channel: usize,
    first: i64,
    /// `None` if all points have the same time.
    times: Option<Times>,
}

/// Decoder of the points' times.
struct Times {
    decoder: ArithmeticDecoder<Cursor<Vec<u8>>>,
    channel: usize,
    /// The sequences of each channel that was met, and its last time.
    channels: [Option<(Sequences, i64)>; 4],
}

impl Times {
    fn time(&mut self, channel: usize, is_another: bool) -> Result<i64> {
        // The first time of a channel is the last one of the channel before.
        let before = self.channels[self.channel].as_ref().map_or(0, |(_, last)| *last);
        self.channel = channel;
        let (sequences, last) = self.channels[channel].get_or_insert_with(|| (Sequences::new(before, 0), before));
        if is_another {
            *last = sequences.time(&mut self.decoder)?;
        }
        Ok(*last)
    }
}

impl<R: Read + Seek, D: LayeredFieldDecompressor<Cursor<Vec<u8>>>> LayeredFieldDecompressor<R> for Timed<D> {
    fn size_of_field(&self) -> usize {
        self.points.size_of_field()
    }

    fn set_selection(&mut self, selection: DecompressionSelection) {
        self.points.set_selection(selection.skip_gps_time());
        self.changes.set_selection(DecompressionSelection::base().decompress_gps_time());
    }

    fn init_first_point(&mut self, src: &mut R, first_point: &mut [u8], context: &mut usize) -> Result<()> {
        src.read_exact(first_point)?;
        let whole = first_point.to_vec();
        self.changes.init_first_point(&mut Cursor::new(whole.clone()), first_point, &mut 0)?;
        self.points.init_first_point(&mut Cursor::new(whole), first_point, context)?;
        (self.first, self.channel) = (bits(&first_point[TIME..]), channel(first_point));
        Ok(())
    }

    fn decompress_field_with(&mut self, current_point: &mut [u8], context: &mut usize) -> Result<()> {
        self.points.decompress_field_with(current_point, context)?;
        let Some(times) = &mut self.times else { return Ok(()) };
        let is_another = self.changes.decompress_field_with(&mut [0; POINT], &mut 0).is_err();
        let time = times.time(channel(current_point), is_another)?;
        current_point[TIME..TIME + size_of::<i64>()].copy_from_slice(&time.to_le_bytes());
        Ok(())
    }

    fn read_layers_sizes(&mut self, src: &mut R) -> Result<()> {
        src.read_exact(self.sizes.as_flattened_mut())?;
        self.points.read_layers_sizes(&mut Cursor::new(self.sizes.as_flattened().to_vec()))?;
        let mut sizes = [[0; SIZE]; LAYERS];
        sizes[0] = self.sizes[0];
        // The bytes that a decoder reads before the first symbol.
        sizes[LAYERS - 1] = (SIZE as u32).to_le_bytes();
        self.changes.read_layers_sizes(&mut Cursor::new(sizes.as_flattened().to_vec()))
    }

    /// Reads the layers. The sizes were compared with the file's before.
    fn read_layers(&mut self, src: &mut R) -> Result<()> {
        let lengths = self.sizes.map(|size| u32::from_le_bytes(size) as usize);
        let mut layers = vec![0; lengths.iter().sum()];
        src.read_exact(&mut layers)?;
        if lengths[LAYERS - 1] > 0 {
            let changes = [&layers[..lengths[0]], &[0; SIZE]].concat();
            self.changes.read_layers(&mut Cursor::new(changes))?;
            let times = layers.split_off(layers.len() - lengths[LAYERS - 1]);
            let mut decoder = ArithmeticDecoder::new(Cursor::new(times));
            decoder.read_init_bytes()?;
            let mut channels = [const { None }; 4];
            channels[self.channel] = Some((Sequences::new(self.first, 0), self.first));
            self.times = Some(Times { decoder, channel: self.channel, channels });
        }
        // The library passes over the layer of times, which may be beyond the end.
        self.points.read_layers(&mut Cursor::new(layers))
    }
}

fn channel(point: &[u8]) -> usize {
    usize::from(point[FLAGS] >> 4 & 3)
}

#[cfg(test)]
mod tests {
    use laz::encoders::ArithmeticEncoder;

    use super::*;

    #[test]
    fn changes_of_the_sequence_have_an_end() {
        for unchanged in [0, 1] {
            // The last code of the first kind changes to the sequence three further on.
            let mut model = ArithmeticModelBuilder::new(5 + unchanged).with_compression(true).build();
            let mut encoder = ArithmeticEncoder::new(Cursor::new(Vec::new()));
            for _ in 0..1_000_000 {
                encoder.encode_symbol(&mut model, 4 + unchanged).unwrap();
            }
            encoder.done().unwrap();
            let bytes = encoder.into_inner().into_inner();
            assert!(bytes.len() < 1000, "{}: a small file", bytes.len());
            let mut decoder = ArithmeticDecoder::new(Cursor::new(bytes));
            decoder.read_init_bytes().unwrap();
            let error = Sequences::new(7, unchanged).time(&mut decoder).unwrap_err().to_string();
            assert!(error.contains("without end"), "{error}");
        }
    }
}
