//! GIF: plays everywhere, in 256 colors.

use std::io::{self, Write};

use ::gif::{DisposalMethod, Encoder, Frame, Repeat};

use super::interrupted;
use super::palette::Palette;
use super::stills::Stills;

/// Writes an animation, which plays for ever if the path is closed, else once.
pub fn write(out: impl Write, stills: &Stills<'_>, fps: u32, closed: bool, step: &dyn Fn()) -> io::Result<()> {
    let size = stills.size();
    let [width, height] =
        size.map(|side| u16::try_from(side).map_err(|_| io::Error::other("a GIF has at most 65535 pixels a side")));
    let (width, height) = (width?, height?);
    let mut palette = Palette::of(stills)?;
    let mut encoder = Encoder::new(out, width, height, &palette.bytes()).map_err(io::Error::other)?;
    if closed {
        encoder.set_repeat(Repeat::Infinite).map_err(io::Error::other)?;
    }
    let mut before: Option<Vec<u8>> = None;
    for (number, still) in stills.iter().enumerate() {
        interrupted()?;
        let indices = palette.indices(&still?.bytes, usize::from(width));
        let [left, top, right, bottom] = match &before {
            Some(before) => changed(before, &indices, usize::from(width)),
            None => [0, 0, usize::from(width), usize::from(height)],
        };
        let rows = indices.chunks_exact(usize::from(width)).take(bottom).skip(top);
        let buffer: Vec<u8> = rows.flat_map(|row| &row[left..right]).copied().collect();
        let frame = Frame {
            delay: delay(number, fps),
            dispose: DisposalMethod::Keep,
            left: left as u16,
            top: top as u16,
            width: (right - left) as u16,
            height: (bottom - top) as u16,
            buffer: buffer.into(),
            ..Frame::default()
        };
        encoder.write_frame(&frame).map_err(io::Error::other)?;
        before = Some(indices);
        step();
    }
    // Dropped, it would keep the errors of its last bytes to itself.
    encoder.into_inner().map(drop).map_err(io::Error::other)
}

/// Hundredths of a second of a frame: whole ones, so that the frames together have the right length.
fn delay(number: usize, fps: u32) -> u16 {
    let fps = u64::from(fps);
    let end = |number: u64| (200 * number / fps).div_ceil(2);
    let number = number as u64;
    (end(number + 1) - end(number)) as u16
}

/// Returns left, top, right and bottom of the pixels that differ, at least one pixel.
fn changed(before: &[u8], after: &[u8], width: usize) -> [usize; 4] {
    let mut found = [width, usize::MAX, 0, 0];
    for (number, (old, new)) in before.chunks_exact(width).zip(after.chunks_exact(width)).enumerate() {
        let differs = |column: &usize| old[*column] != new[*column];
        let (Some(first), Some(last)) = ((0..width).find(differs), (0..width).rfind(differs)) else { continue };
        found = [found[0].min(first), found[1].min(number), found[2].max(last + 1), number + 1];
    }
    if found[3] == 0 { [0, 0, 1, 1] } else { found }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_add_up() {
        for fps in [1, 7, 12, 24, 25, 30, 50] {
            let sum: u32 = (0..fps as usize * 3).map(|number| u32::from(delay(number, fps))).sum();
            assert_eq!(sum, 300, "{fps}");
        }
        assert_eq!([0, 1, 2].map(|number| delay(number, 30)), [3, 4, 3]);
    }

    #[test]
    fn only_what_changes_is_stored() {
        assert_eq!(changed(&[0; 12], &[0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0], 4), [0, 1, 2, 3]);
        assert_eq!(changed(&[0; 12], &[0; 12], 4), [0, 0, 1, 1]);
    }
}
