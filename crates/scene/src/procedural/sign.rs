//! `sign`: lettering and a checker on a sign, scanned with noise (Schütz and Wimmer, Figs. 5 and 7): detail as fine as
//! the points, that splats tear where they cover each other.

use glam::{DVec2, DVec3};

use super::builder::{CloudBuilder, Rgb};
use super::random::Random;
use super::{Error, Generated};

/// Half the sign's width and height; it lies in the plane z = 0.
const HALF: DVec2 = DVec2::new(1.2, 0.8);
/// The text, with the position of each line's lower left corner.
const LINES: [(&str, DVec2); 3] = [
    ("PELLUCID", DVec2::new(-1.13, 0.34)),
    ("POINTS YOU SEE THROUGH", DVec2::new(-1.13, 0.14)),
    ("CLOUDS OF POINTS CUT ON A SIGN", DVec2::new(-1.13, -0.02)),
];
/// Width of a line, whose letters are as tall as their number allows.
const LINE: f64 = 2.26;
/// Columns from one letter to the next, rows of one.
const ADVANCE: f64 = 6.0;
const ROWS: f64 = 7.0;
/// The checker's upper edge and the side of its squares, four of each side by side, from coarse to as fine as letters.
const CHECKER_TOP: f64 = -0.12;
const SQUARES: [f64; 4] = [0.08, 0.04, 0.02, 0.01];

const PAPER: Rgb = [240, 236, 224];
const INK: Rgb = [24, 34, 58];
const RED: Rgb = [190, 40, 36];

pub(super) fn generate([points, noise]: [f64; 2], seed: u64) -> Result<Generated, Error> {
    let points = points as usize;
    let spacing = (4.0 * HALF.x * HALF.y / points as f64).sqrt();
    let [columns, rows] = (2.0 * HALF / spacing).to_array().map(|n| n.ceil() as usize);
    let mut random = Random::new(seed);
    let mut builder = CloudBuilder::with_capacity(columns * rows)?;
    for row in 0..rows {
        for column in 0..columns {
            // Anywhere in its cell: no row shows.
            let cell = DVec2::new(column as f64 + random.unit(), row as f64 + random.unit());
            let place = -HALF + cell * (2.0 * HALF / DVec2::new(columns as f64, rows as f64));
            builder.point(place.extend(noise * spacing * random.gauss()), paint(place));
            builder.normal(DVec3::Z);
        }
    }
    // A point anywhere in each cell leaves gaps of up to two cells.
    let radius = (1.2 * spacing) as f32;
    let scene_toml = format!(
        r#"# A sign with lettering after Schütz and Wimmer, Figs. 5 and 7: {columns} x {rows} points.
[image]
size = [1200, 800]
background = [0.2, 0.3, 0.4]

[camera]
eye = [0.7, -0.4, 2.3]
target = [0.07, 0.02, 0.0]
up = [0.0, 1.0, 0.0]
fov_y = 45.0

[[cloud]]
path = "sign.ply"
radius = {radius:?}

[method]
name = "paraboloid"
"#
    );
    Ok(Generated { clouds: vec![("sign.ply".to_owned(), builder.finish())], scene_toml })
}

/// The color at a position of the sign.
fn paint(place: DVec2) -> Rgb {
    let margin = (HALF - place.abs()).min_element();
    if margin < 0.03 {
        return RED;
    }
    if LINES.iter().any(|(text, corner)| is_inked(text, place - corner)) || is_dark(place) { INK } else { PAPER }
}

/// Returns `true` if a line of text covers a position relative to its lower left corner.
fn is_inked(text: &str, place: DVec2) -> bool {
    // Columns and rows of the letters' grid, rows from the top.
    let unit = LINE / (ADVANCE * text.len() as f64);
    let (column, row) = (place.x / unit, ROWS - place.y / unit);
    if column < 0.0 || !(0.0..ROWS).contains(&row) {
        return false;
    }
    let letter = text.as_bytes().get((column / ADVANCE) as usize).copied().unwrap_or(b' ');
    let within = (column % ADVANCE) as u32;
    within < 5 && glyph(letter)[row as usize] >> (4 - within) & 1 == 1
}

/// Returns `true` if a position lies on a dark square of one of the checkers.
fn is_dark(place: DVec2) -> bool {
    let width = LINE / SQUARES.len() as f64;
    let along = place.x + 0.5 * LINE;
    if along < 0.0 || place.y > CHECKER_TOP || place.y < CHECKER_TOP - 0.56 {
        return false;
    }
    let (which, within) = ((along / width) as usize, along % width);
    let Some(side) = SQUARES.get(which).filter(|_| within < 0.96 * width) else { return false };
    ((within / side) as i64 + ((CHECKER_TOP - place.y) / side) as i64) % 2 == 0
}

/// Rows of a letter from the top, five columns each, the leftmost in the highest bit.
fn glyph(letter: u8) -> [u8; 7] {
    match letter {
        b'A' => [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
        b'C' => [0b01110, 0b10001, 0b10000, 0b10000, 0b10000, 0b10001, 0b01110],
        b'D' => [0b11110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b11110],
        b'E' => [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111],
        b'F' => [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000],
        b'G' => [0b01110, 0b10001, 0b10000, 0b10111, 0b10001, 0b10001, 0b01111],
        b'H' => [0b10001, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],
        b'I' => [0b01110, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],
        b'L' => [0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111],
        b'N' => [0b10001, 0b11001, 0b10101, 0b10011, 0b10001, 0b10001, 0b10001],
        b'O' => [0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
        b'P' => [0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000],
        b'R' => [0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001],
        b'S' => [0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110],
        b'T' => [0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100],
        b'U' => [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],
        b'Y' => [0b10001, 0b10001, 0b01010, 0b00100, 0b00100, 0b00100, 0b00100],
        _ => [0; 7],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_has_a_glyph() {
        for letter in LINES.iter().flat_map(|(text, _)| text.bytes()) {
            assert_eq!(glyph(letter) == [0; 7], letter == b' ', "{}", char::from(letter));
        }
    }

    #[test]
    fn letters_stand_where_they_should() {
        // The first line's L, third letter: its stem at the left, its foot at the bottom, nothing at the upper right.
        let unit = LINE / (ADVANCE * 8.0);
        let at = |column: f64, row: f64| is_inked("PELLUCID", DVec2::new(column, ROWS - row) * unit);
        assert!(at(12.5, 0.5) && at(12.5, 6.5) && at(16.5, 6.5) && !at(16.5, 0.5) && !at(17.5, 6.5));
        assert!(!at(-0.5, 3.0) && !at(12.5, 7.5) && !at(12.5, -0.5) && !at(48.5, 3.0));
    }
}
