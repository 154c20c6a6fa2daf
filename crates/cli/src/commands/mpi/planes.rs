//! Rows of an image as bytes, and back.

use bytemuck::{Pod, cast_slice, cast_slice_mut};
use pellucid_engine::image::Image;

/// All values of some rows, one kind after the other.
pub fn packed(image: &mut Image, rows: [u32; 2]) -> Vec<u8> {
    let mut bytes = Vec::new();
    each(image, rows, |values| bytes.extend_from_slice(values));
    bytes
}

/// Puts them back; `None` if there are too few or too many.
pub fn unpack(image: &mut Image, rows: [u32; 2], bytes: &[u8]) -> Option<()> {
    let mut rest = Some(bytes);
    each(image, rows, |values| {
        rest = rest.and_then(|bytes| {
            let (own, others) = bytes.split_at_checked(values.len())?;
            values.copy_from_slice(own);
            Some(others)
        });
    });
    rest.filter(|rest| rest.is_empty()).map(drop)
}

/// The bytes of each kind of value that an image has, of some rows.
fn each(image: &mut Image, rows: [u32; 2], mut take: impl FnMut(&mut [u8])) {
    let [first, last] = rows.map(|row| row as usize * image.width as usize);
    fn of<T: Pod>(values: &mut [T], pixels: [usize; 2], take: &mut impl FnMut(&mut [u8])) {
        if let Some(values) = values.get_mut(pixels[0]..pixels[1]) {
            take(cast_slice_mut(values));
        }
    }
    let pixels = [first, last];
    let Image { rgba, depth, depth_median, depth_mean, fragments, layers, stderr, .. } = image;
    of(rgba, pixels, &mut take);
    of(depth, pixels, &mut take);
    for values in [depth_median, depth_mean].into_iter().flatten() {
        of(values, pixels, &mut take);
    }
    for values in [fragments, layers].into_iter().flatten() {
        of(values, pixels, &mut take);
    }
    for values in stderr.iter_mut() {
        of(values, pixels, &mut take);
    }
}

/// Numbers as bytes.
pub fn bytes_of<T: Pod>(values: &[T]) -> Vec<u8> {
    cast_slice(values).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(seed: f32) -> Image {
        let values = |factor: f32| (0..12).map(|i| seed + factor * i as f32).collect::<Vec<_>>();
        Image {
            width: 3,
            height: 4,
            rgba: values(1.0).iter().map(|v| [*v; 4]).collect(),
            depth: values(2.0),
            depth_median: None,
            depth_mean: Some(values(3.0)),
            fragments: Some((0..12).collect()),
            layers: None,
            stderr: Some(vec![[seed; 3]; 12]),
        }
    }

    #[test]
    fn rows_come_back_and_others_stay() {
        let (mut from, mut to) = (image(1.0), image(100.0));
        let bytes = packed(&mut from, [1, 3]);
        assert_eq!(bytes.len(), 6 * (16 + 4 + 4 + 4 + 12));
        unpack(&mut to, [1, 3], &bytes).unwrap();
        assert_eq!(
            (to.rgba[2], to.rgba[3], to.rgba[8], to.rgba[9]),
            ([102.0; 4], from.rgba[3], from.rgba[8], [109.0; 4])
        );
        assert_eq!(to.stderr.as_ref().unwrap()[5], [1.0; 3]);
        assert!(unpack(&mut to, [1, 3], &bytes[1..]).is_none());
        assert!(unpack(&mut to, [1, 2], &bytes).is_none());
    }
}
