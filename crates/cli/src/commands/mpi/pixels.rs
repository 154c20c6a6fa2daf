//! Parts of an image from rank to rank.

use bytemuck::{Pod, cast_slice_mut};
use pellucid_core::image::Image;
use pellucid_engine::passes::bands::Window;

use super::ranks::Ranks;

/// Values of one kind for all pixels, as bytes.
struct Plane<'a> {
    bytes: &'a mut [u8],
    /// Bytes of a row.
    row: usize,
    /// Bytes of a pixel.
    pixel: usize,
}

impl Plane<'_> {
    /// The bytes of a region's row.
    fn row(&mut self, [x0, _, x1, _]: Window, y: u32) -> &mut [u8] {
        let start = y as usize * self.row;
        &mut self.bytes[start + x0 as usize * self.pixel..start + x1 as usize * self.pixel]
    }

    /// The bytes of a region, if they are one piece.
    fn whole(&mut self, [x0, y0, x1, y1]: Window) -> Option<&mut [u8]> {
        let is_wide = x0 == 0 && x1 as usize * self.pixel == self.row;
        is_wide.then(|| &mut self.bytes[y0 as usize * self.row..y1 as usize * self.row])
    }

    fn send(&mut self, window: Window, ranks: &Ranks) {
        if let Some(bytes) = self.whole(window) {
            return ranks.send_exactly(0, bytes);
        }
        let rows: Vec<u8> = (window[1]..window[3]).flat_map(|y| self.row(window, y).to_vec()).collect();
        ranks.send_exactly(0, &rows);
    }

    fn receive(&mut self, window: Window, from: usize, ranks: &Ranks) {
        if let Some(bytes) = self.whole(window) {
            return ranks.receive_exactly(from, bytes);
        }
        let [x0, y0, x1, y1] = window;
        let width = (x1 - x0) as usize * self.pixel;
        let mut rows = vec![0; width * (y1 - y0) as usize];
        ranks.receive_exactly(from, &mut rows);
        (y0..y1).zip(rows.chunks_exact(width)).for_each(|(y, row)| self.row(window, y).copy_from_slice(row));
    }
}

/// The values of an image, kind by kind.
fn planes(image: &mut Image) -> Vec<Plane<'_>> {
    fn of<T: Pod>(values: &mut [T], width: u32) -> Plane<'_> {
        let pixel = size_of::<T>();
        Plane { bytes: cast_slice_mut(values), row: width as usize * pixel, pixel }
    }
    let Image { width, rgba, depth, depth_median, depth_mean, fragments, layers, stderr, .. } = image;
    let width = *width;
    let mut all = vec![of(rgba, width), of(depth, width)];
    all.extend([depth_median, depth_mean].into_iter().flatten().map(|values| of(values, width)));
    all.extend([fragments, layers].into_iter().flatten().map(|values| of(values, width)));
    all.extend(stderr.iter_mut().map(|values| of(values, width)));
    all
}

/// Sends the pixels of a region to the first rank.
pub fn send(image: &mut Image, window: Window, ranks: &Ranks) {
    planes(image).iter_mut().for_each(|plane| plane.send(window, ranks));
}

/// Takes the pixels of a region that a rank sends, whose image has the same kinds of values.
pub fn receive(image: &mut Image, window: Window, from: usize, ranks: &Ranks) {
    planes(image).iter_mut().for_each(|plane| plane.receive(window, from, ranks));
}

/// Copies the pixels of a region into an image of the same size and kinds of values.
pub fn copy(into: &mut Image, from: &mut Image, window: Window) {
    for (into, from) in planes(into).iter_mut().zip(&mut planes(from)) {
        (window[1]..window[3]).for_each(|y| into.row(window, y).copy_from_slice(from.row(window, y)));
    }
}

/// Returns true for each optional channel that an image has: median and mean depth, fragments, layers, standard error.
pub fn kinds(image: &Image) -> Vec<bool> {
    let Image { depth_median, depth_mean, fragments, layers, stderr, .. } = image;
    vec![depth_median.is_some(), depth_mean.is_some(), fragments.is_some(), layers.is_some(), stderr.is_some()]
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
            bytes: None,
            depth: values(2.0),
            depth_median: None,
            depth_mean: Some(values(3.0)),
            samples: 1,
            fragments: Some((0..12).collect()),
            layers: None,
            stderr: Some(vec![[seed; 3]; 12]),
        }
    }

    #[test]
    fn a_window_is_copied_and_nothing_else() {
        let (mut from, mut to) = (image(1.0), image(100.0));
        copy(&mut to, &mut from, [1, 1, 3, 3]);
        let copied: Vec<usize> = (0..12).filter(|at| to.rgba[*at] == from.rgba[*at]).collect();
        assert_eq!(copied, [4, 5, 7, 8]);
        assert_eq!((to.depth[3], to.depth[4]), (106.0, from.depth[4]));
        assert_eq!((to.depth_mean.unwrap()[5], to.stderr.unwrap()[6]), (from.depth_mean.unwrap()[5], [100.0; 3]));
    }
}
