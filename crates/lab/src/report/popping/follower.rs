//! Follows the error of one method from frame to frame.

use pellucid_core::image::LinearImage;
use pellucid_core::metrics;

use super::{Candidate, Curve, FrameError};

/// The frames of a method so far.
#[derive(Debug, Clone, Default)]
pub struct Follower {
    /// The error of the last frame, pixel by pixel.
    before: Option<Vec<[f32; 3]>>,
    frames: Vec<FrameError>,
    /// RMSE of the changes where the camera only rolls.
    rolled: Vec<f64>,
}

impl Follower {
    /// Takes the next frame and its exact image, both in linear light, and returns its figures.
    ///
    /// With exact frames X and those of the method M, the error is E = M − X and its change D = Eᵢ − Eᵢ₋₁. The RMSE is
    /// that of D. FLIP compares X + D with X, of the later frame: the frame as it would be if the change were its only
    /// error.
    ///
    /// # Panics
    /// The images differ in size, or from those before.
    pub fn add(&mut self, exact: &LinearImage, image: &LinearImage) -> FrameError {
        let error = errors(exact, image);
        let mut found = FrameError {
            frame: self.frames.len() as u32,
            error: metrics::rmse(&exact.pixels, &image.pixels),
            rmse: None,
            flip: None,
        };
        if let Some(before) = &self.before {
            assert_eq!(before.len(), error.len(), "all frames of a path are equally large");
            let change: Vec<[f32; 3]> = pairs(before, &error).map(|(a, b)| each(a, b, |a, b| b - a)).collect();
            let pixels = pairs(&exact.pixels, &change).map(|(x, d)| each(x, d, |x, d| x + d)).collect();
            // Against zeros, so that X takes no digits from a small change.
            found.rmse = Some(metrics::rmse(&vec![[0.0; 3]; change.len()], &change));
            found.flip = Some(metrics::flip(exact, &LinearImage { pixels, ..*exact }));
        }
        self.before = Some(error);
        self.frames.push(found);
        found
    }

    /// Takes a frame that follows the last one instead of the next, by a camera that only rolls, and keeps the RMSE of
    /// the change of the error to it.
    pub fn add_rolled(&mut self, exact: &LinearImage, image: &LinearImage) {
        if let Some(before) = &self.before {
            let error = errors(exact, image);
            self.rolled.push(metrics::rmse(before, &error));
        }
    }

    /// The curve of a method.
    pub fn curve(self, candidate: &Candidate) -> Curve {
        let mean = self.rolled.iter().sum::<f64>() / self.rolled.len() as f64;
        let rolled_rmse = (!self.rolled.is_empty()).then_some(mean);
        Curve { rolled_rmse, ..Curve::new(candidate, self.frames) }
    }
}

/// M − X. Values that are not finite and equal have no error.
fn errors(exact: &LinearImage, image: &LinearImage) -> Vec<[f32; 3]> {
    assert_eq!(
        (exact.width, exact.height),
        (image.width, image.height),
        "a frame and its exact image are equally large"
    );
    let same = |a: f32, b: f32| a == b || (a.is_nan() && b.is_nan());
    pairs(&exact.pixels, &image.pixels).map(|(x, m)| each(x, m, |x, m| if same(x, m) { 0.0 } else { m - x })).collect()
}

fn pairs<'a>(a: &'a [[f32; 3]], b: &'a [[f32; 3]]) -> impl Iterator<Item = ([f32; 3], [f32; 3])> {
    a.iter().copied().zip(b.iter().copied())
}

fn each(a: [f32; 3], b: [f32; 3], of: impl Fn(f32, f32) -> f32) -> [f32; 3] {
    std::array::from_fn(|channel| of(a[channel], b[channel]))
}

#[cfg(test)]
mod tests {
    use pellucid_scene::{Discs, Method};

    use super::*;

    fn image(values: [f32; 4]) -> LinearImage {
        LinearImage { width: 2, height: 2, pixels: values.map(|value| [value; 3]).to_vec() }
    }

    fn curve(frames: &[([f32; 4], [f32; 4])]) -> Curve {
        let mut follower = Follower::default();
        frames.iter().for_each(|(exact, found)| _ = follower.add(&image(*exact), &image(*found)));
        follower.curve(&Candidate { method: Method::Sorted(Discs::default()), setting: String::new() })
    }

    #[test]
    fn an_error_that_stays_does_not_pop() {
        // The scene moves, and with it what is drawn: always too bright by 1/4.
        let found = curve(&[
            ([0.0, 0.25, 0.5, 0.5], [0.25, 0.5, 0.75, 0.75]),
            ([0.5, 0.0, 0.25, 0.5], [0.75, 0.25, 0.5, 0.75]),
            ([0.5, 0.5, 0.0, 0.25], [0.75, 0.75, 0.25, 0.5]),
        ]);
        assert_eq!((found.mean_error, found.mean_rmse, found.worst_rmse), (0.25, 0.0, 0.0), "{found:?}");
        assert_eq!((found.mean_flip, found.worst_flip, found.frames[0].rmse), (0.0, 0.0, None), "{found:?}");
        assert_eq!(found.frames.iter().map(|frame| frame.frame).collect::<Vec<_>>(), [0, 1, 2]);
    }

    #[test]
    fn an_error_that_jumps_does() {
        // One of four pixels is off by 1/2 in one frame alone: it comes and goes.
        let exact = [0.25; 4];
        let off = [0.75, 0.25, 0.25, 0.25];
        let found = curve(&[(exact, exact), (exact, off), (exact, exact), (exact, exact)]);
        let changes: Vec<_> = found.frames.iter().map(|frame| frame.rmse).collect();
        assert_eq!(changes, [None, Some(0.25), Some(0.25), Some(0.0)]);
        assert_eq!((found.worst_rmse, found.worst_frame, found.mean_error), (0.25, 1, 0.0625));
        assert!((found.mean_rmse - 0.5 / 3.0).abs() < 1e-15 && found.worst_flip > 0.05, "{found:?}");
    }

    #[test]
    fn an_error_that_changes_its_place_counts_twice() {
        // Both frames have the same RMSE; the change has it at two pixels.
        let exact = [0.5; 4];
        let found = curve(&[(exact, [1.0, 0.5, 0.5, 0.5]), (exact, [0.5, 1.0, 0.5, 0.5])]);
        assert_eq!((found.frames[0].error, found.frames[1].error), (0.25, 0.25));
        assert!((found.worst_rmse - 0.125f64.sqrt()).abs() < 1e-15, "{found:?}");
        // The change is measured by itself, however bright the frame is.
        let bright = curve(&[([1e6; 4], [1e6; 4]), ([1e6; 4], [1e6 + 0.5, 1e6, 1e6, 1e6])]);
        assert_eq!(bright.worst_rmse, 0.25);
    }

    #[test]
    fn a_camera_that_rolls_is_apart_from_the_path() {
        let mut follower = Follower::default();
        let exact = [0.25; 4];
        // Nothing is before the first frame.
        follower.add_rolled(&image(exact), &image([1.0; 4]));
        follower.add(&image(exact), &image(exact));
        follower.add_rolled(&image(exact), &image([0.75, 0.25, 0.25, 0.25]));
        follower.add(&image(exact), &image(exact));
        let found = follower.curve(&Candidate { method: Method::Sorted(Discs::default()), setting: String::new() });
        assert_eq!((found.rolled_rmse, found.mean_rmse, found.frames.len()), (Some(0.25), 0.0, 2));
        assert_eq!(curve(&[(exact, exact), (exact, exact)]).rolled_rmse, None);
    }

    #[test]
    fn errors_that_are_not_numbers_do_not_pass_for_steady() {
        let nan = [f32::NAN, 0.0, 0.0, 0.0];
        assert_eq!(curve(&[(nan, nan), (nan, nan)]).worst_rmse, 0.0);
        let found = curve(&[([0.0; 4], [0.0; 4]), ([0.0; 4], nan)]);
        assert_eq!((found.worst_rmse, found.worst_flip), (f64::INFINITY, 1.0));
    }
}
