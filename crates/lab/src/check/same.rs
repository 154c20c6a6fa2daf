//! Compares two images to the bit, and locates differences.

use std::fmt;

use pellucid_core::image::Image;

/// The first value in which two images differ, and how many pixels do.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// Column and row; `None` if the images are not of one size, or one lacks what the other has.
    pub pixel: Option<[u32; 2]>,
    /// `R`, `G`, `B`, `A`, `Z`, `depth.median`, `depth.mean`, `fragments`, `layers`, `stderr.R` and so on, as in an
    /// EXR.
    pub channel: &'static str,
    /// The bits in the two.
    pub bits: [u32; 2],
    /// Pixels that differ in anything.
    pub pixels: usize,
    /// The number of pixels.
    pub of: usize,
}

impl fmt::Display for Difference {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pixel, channel, bits: [a, b], pixels, of } = self;
        let Some([x, y]) = pixel else { return write!(out, "{channel}: {a} and {b} values") };
        let number = |bits: &u32| match *channel {
            "fragments" | "layers" => bits.to_string(),
            _ => format!("{:e} ({bits:08x})", f32::from_bits(*bits)),
        };
        write!(out, "pixel ({x}, {y}), {channel}: {} and {}; {pixels} of {of} pixels differ", number(a), number(b))
    }
}

const COLORS: [&str; 4] = ["R", "G", "B", "A"];
const ERRORS: [&str; 3] = ["stderr.R", "stderr.G", "stderr.B"];

/// Every channel of an image: its name and the bits of its pixels.
fn channels(image: &Image) -> Vec<(&'static str, Vec<u32>)> {
    let mut all: Vec<(&'static str, Vec<u32>)> = Vec::new();
    for (i, name) in COLORS.into_iter().enumerate() {
        all.push((name, image.rgba.iter().map(|pixel| pixel[i].to_bits()).collect()));
    }
    all.push(("Z", image.depth.iter().map(|z| z.to_bits()).collect()));
    for (name, depths) in [("depth.median", &image.depth_median), ("depth.mean", &image.depth_mean)] {
        all.push((name, depths.iter().flatten().map(|z| z.to_bits()).collect()));
    }
    all.push(("fragments", image.fragments.clone().unwrap_or_default()));
    all.push(("layers", image.layers.clone().unwrap_or_default()));
    for (i, name) in ERRORS.into_iter().enumerate() {
        all.push((name, image.stderr.iter().flatten().map(|pixel| pixel[i].to_bits()).collect()));
    }
    all
}

/// Compares all that two images hold bit by bit: color, depths, list lengths, layers, standard errors. `None`: they are
/// the same.
pub fn difference(a: &Image, b: &Image) -> Option<Difference> {
    let (first, second) = (channels(a), channels(b));
    let pairs = || first.iter().zip(&second);
    if let Some(((channel, x), (_, y))) = pairs().find(|((_, x), (_, y))| x.len() != y.len()) {
        let bits = [x.len() as u32, y.len() as u32];
        return Some(Difference { pixel: None, channel, bits, pixels: x.len(), of: x.len() });
    }
    let differs = |i: &usize| pairs().any(|((_, x), (_, y))| x.get(*i) != y.get(*i));
    let wrong: Vec<usize> = (0..a.rgba.len()).filter(differs).collect();
    let place = *wrong.first()?;
    let ((channel, x), (_, y)) = pairs().find(|((_, x), (_, y))| x.get(place) != y.get(place))?;
    let pixel = Some([place as u32 % a.width.max(1), place as u32 / a.width.max(1)]);
    Some(Difference { pixel, channel, bits: [x[place], y[place]], pixels: wrong.len(), of: a.rgba.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> Image {
        let value = |i: u32| i as f32 / 7.0;
        Image {
            width: 5,
            height: 3,
            rgba: (0..15).map(|i| [value(i), value(i + 1), -0.0, f32::NAN]).collect(),
            bytes: None,
            depth: (0..15).map(|i| if i == 3 { f32::INFINITY } else { value(i) }).collect(),
            depth_median: None,
            depth_mean: Some((0..15).map(value).collect()),
            samples: 1,
            fragments: Some((0..15).collect()),
            layers: None,
            stderr: Some((0..15).map(|i| [value(i); 3]).collect()),
        }
    }

    #[test]
    fn an_image_equals_itself() {
        assert_eq!(difference(&image(), &image()), None);
    }

    #[test]
    fn one_bit_is_found_wherever_it_is() {
        let flip = |value: &mut f32| *value = f32::from_bits(value.to_bits() ^ 1);
        type Change = fn(&mut Image, usize, fn(&mut f32));
        let changes: [(&str, Change); 8] = [
            ("R", |image, i, flip| flip(&mut image.rgba[i][0])),
            ("B", |image, i, flip| flip(&mut image.rgba[i][2])),
            ("A", |image, i, flip| flip(&mut image.rgba[i][3])),
            ("Z", |image, i, flip| flip(&mut image.depth[i])),
            ("depth.mean", |image, i, flip| flip(&mut image.depth_mean.as_mut().expect("there")[i])),
            ("fragments", |image, i, _| image.fragments.as_mut().expect("there")[i] ^= 1),
            ("stderr.R", |image, i, flip| flip(&mut image.stderr.as_mut().expect("there")[i][0])),
            ("stderr.B", |image, i, flip| flip(&mut image.stderr.as_mut().expect("there")[i][2])),
        ];
        for (channel, change) in changes {
            for place in 0..15 {
                let mut other = image();
                change(&mut other, place, flip);
                let found = difference(&image(), &other).expect("a difference");
                let pixel = Some([place as u32 % 5, place as u32 / 5]);
                assert_eq!((found.pixel, found.channel, found.pixels, found.of), (pixel, channel, 1, 15), "{found}");
                assert_eq!((found.bits[0] ^ found.bits[1]).count_ones(), 1);
                let [x, y] = [place % 5, place / 5];
                let text = found.to_string();
                assert!(text.starts_with(&format!("pixel ({x}, {y}), {channel}: ")), "{text}");
                assert!(text.ends_with("1 of 15 pixels differ"), "{text}");
            }
        }
    }

    #[test]
    fn zeros_of_two_signs_differ_and_so_does_what_one_lacks() {
        let mut other = image();
        other.rgba[7][2] = 0.0;
        let found = difference(&image(), &other).expect("a difference");
        assert_eq!((found.pixel, found.channel, found.bits), (Some([2, 1]), "B", [1 << 31, 0]));
        let other = Image { stderr: None, ..image() };
        let found = difference(&image(), &other).expect("a difference");
        assert_eq!((found.pixel, found.to_string().as_str()), (None, "stderr.R: 15 and 0 values"));
    }
}
