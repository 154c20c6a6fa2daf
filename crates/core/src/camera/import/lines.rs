//! COLMAP's text files.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::{FromStr, SplitAsciiWhitespace};

use super::colmap::{Image, MODELS, intrinsics};
use super::{Intrinsics, read_text};
use crate::camera::path::Error;

/// `CAMERA_ID MODEL WIDTH HEIGHT PARAMS…`, one line each.
pub fn cameras(path: &Path) -> Result<BTreeMap<u32, Intrinsics>, Error> {
    let text = read_text(path)?;
    let mut cameras = BTreeMap::new();
    for (number, line) in entries(&text) {
        let (id, camera) = camera(line).map_err(|problem| wrong(path, number, problem))?;
        if cameras.insert(id, camera).is_some() {
            return Err(wrong(path, number, format!("camera {id} occurs twice")));
        }
    }
    Ok(cameras)
}

fn camera(line: &str) -> Result<(u32, Intrinsics), String> {
    let mut words = line.split_ascii_whitespace();
    let id = next(&mut words, "a camera's number")?;
    let name = words.next().ok_or("a camera's model is missing")?;
    let model = MODELS.iter().position(|(known, ..)| *known == name);
    let model = model.ok_or_else(|| {
        let known: Vec<_> = MODELS.iter().map(|(name, ..)| *name).collect();
        format!("unknown camera model {name}; known: {}", known.join(", "))
    })?;
    let size = [next(&mut words, "a width")?, next(&mut words, "a height")?];
    let parameters = words.map(|word| number(word, "a parameter")).collect::<Result<Vec<f64>, _>>()?;
    Ok((id, intrinsics(model, size, &parameters)?))
}

/// Two lines per image: `IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME`, and the image's points: `X Y POINT3D_ID` for
/// each, possibly none. Some programs leave out the lines of points.
pub fn images(path: &Path) -> Result<Vec<Image>, Error> {
    let text = read_text(path)?;
    let mut images = Vec::new();
    let mut lines = text.lines().enumerate().peekable();
    while let Some((at, line)) = lines.next() {
        if is_entry(line) {
            images.push(image(line).map_err(|problem| wrong(path, at + 1, problem))?);
            lines.next_if(|(_, line)| is_points(line));
        }
    }
    Ok(images)
}

/// A line is one of points if it has triples of numbers alone; that of an image has 10 words or more, one a name.
fn is_points(line: &str) -> bool {
    let words = line.split_ascii_whitespace();
    words.clone().count().is_multiple_of(3) && words.clone().all(|word| word.parse::<f64>().is_ok())
}

fn image(line: &str) -> Result<Image, String> {
    let mut words = line.split_ascii_whitespace();
    let _: u32 = next(&mut words, "an image's number")?;
    let mut numbers = [0.0; 7];
    for (slot, what) in numbers.iter_mut().zip(["QW", "QX", "QY", "QZ", "TX", "TY", "TZ"]) {
        *slot = next(&mut words, what)?;
    }
    let camera = next(&mut words, "the number of the image's camera")?;
    let name = rest(line, 9).ok_or("the image's name is missing")?;
    let [w, x, y, z, tx, ty, tz] = numbers;
    Ok(Image { name: name.as_bytes().to_vec(), rotation: [w, x, y, z], translation: [tx, ty, tz], camera })
}

/// The rest of a line after some words, including its spaces.
fn rest(line: &str, words: usize) -> Option<&str> {
    let mut rest = line.trim();
    for _ in 0..words {
        rest = rest.split_once(|c: char| c.is_ascii_whitespace())?.1.trim_start();
    }
    Some(rest).filter(|rest| !rest.is_empty())
}

/// Lines that hold something, with their number from 1.
fn entries(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().map(|(at, line)| (at + 1, line)).filter(|(_, line)| is_entry(line))
}

fn is_entry(line: &str) -> bool {
    let line = line.trim_start();
    !line.is_empty() && !line.starts_with('#')
}

fn next<T: FromStr>(words: &mut SplitAsciiWhitespace, what: &str) -> Result<T, String> {
    number(words.next().ok_or_else(|| format!("{what} is missing"))?, what)
}

fn number<T: FromStr>(word: &str, what: &str) -> Result<T, String> {
    word.parse().map_err(|_| format!("{word:?} is not {what}"))
}

fn wrong(path: &Path, line: usize, message: String) -> Error {
    Error::Syntax { path: path.to_owned(), line, column: 1, message }
}
