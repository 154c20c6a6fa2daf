//! The samples of a pixel, from those of its list.

use crate::methods::abuffer::{LOCAL_LENGTH, Taken};
use crate::methods::soft::Solids;
use crate::output::deep::{Sample, State, tidy};
use pellucid_core::parallel;

/// Pixels that are worked on together.
const PIXELS: usize = 1024;

/// Samples of a list that are part of an image, and the order that they need.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    pub state: State,
    /// So many of the nearest; all with 0.
    pub layers: u32,
    /// A list ends before the sample that would leave less of the light than this.
    pub stop: f32,
}

/// Returns lengths and samples of a band's pixels, with the solid points behind them.
pub(super) fn pixels(taken: &Taken<'_>, solids: Option<&Solids>, wanted: Wanted) -> (Vec<u32>, Vec<Sample>) {
    let count = taken.offsets.len() - 1;
    let parts = parallel::gather(count.div_ceil(PIXELS), |part| {
        let (mut lengths, mut samples) = (Vec::new(), Vec::new());
        for pixel in part * PIXELS..count.min((part + 1) * PIXELS) {
            let range = taken.offsets[pixel]..taken.offsets[pixel + 1];
            let listed = taken.colors[range.clone()].iter().zip(&taken.depths[range]);
            let there = listed.filter(|(rgba, _)| rgba[3] >= 0.0);
            let list = there.map(|(rgba, [depth, back])| Sample { rgba: *rgba, depth: *depth, back: *back });
            let mut list = wanted.of(list.collect());
            list.extend(solids.and_then(|solids| solid(solids, pixel)));
            lengths.push(list.len() as u32);
            samples.append(&mut list);
        }
        (lengths, samples)
    });
    let (lengths, samples): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
    (lengths.concat(), samples.concat())
}

/// The solid point of a pixel.
fn solid(solids: &Solids, pixel: usize) -> Option<Sample> {
    let (rgba, depth) = (solids.colors[pixel], solids.depths[pixel]);
    (depth < f32::INFINITY).then_some(Sample { rgba, depth, back: depth })
}

impl Wanted {
    /// The samples of a list in the order of blending.
    fn of(self, mut list: Vec<Sample>) -> Vec<Sample> {
        if self.layers > 0 {
            list.truncate(self.layers as usize);
        }
        if self.stop > 0.0 {
            list.truncate(before_end(&list, self.stop));
        }
        match self.state {
            State::Tidy => tidy(&mut list),
            // Of bodies that begin together the shorter one comes first; others stay in the order of blending.
            State::Sorted => {
                list.sort_by(|a, b| a.depth.total_cmp(&b.depth).then(a.back.total_cmp(&b.back)));
            }
        }
        list
    }
}

/// Returns the number of samples that a list has before its end (shaders/shared/early_end.wgsl): by the same float32
/// sums, of long lists run by run, so that both decide alike.
fn before_end(list: &[Sample], stop: f32) -> usize {
    let run = LOCAL_LENGTH as usize;
    let opacity = |sum: f32, sample: &Sample| sum + (1.0 - sum) * sample.rgba[3];
    let mut front = 0f32;
    for (first, part) in (0..).step_by(run).zip(list.chunks(run)) {
        let whole = part.iter().fold(0.0, opacity);
        let next = front + (1.0 - front) * whole;
        if 1.0 - next < stop {
            let mut sum = 0f32;
            let ends = part.iter().position(|sample| {
                sum = opacity(sum, sample);
                1.0 - (front + (1.0 - front) * sum) < stop
            });
            return first + ends.unwrap_or(part.len());
        }
        front = next;
    }
    list.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(depth: f32, back: f32, alpha: f32) -> Sample {
        Sample { rgba: [alpha; 4], depth, back }
    }

    #[test]
    fn lists_end_before_the_sample_that_leaves_too_little() {
        let list: Vec<_> = (0..20).map(|i| sample(i as f32, i as f32, 0.5)).collect();
        // After n samples 2⁻ⁿ is left: with the fourth less than 0.1.
        assert_eq!(before_end(&list, 0.1), 3);
        assert_eq!(before_end(&list, 1e-7), 20);
        assert_eq!(before_end(&[], 0.1), 0);
        let faint: Vec<_> = (0..1000).map(|i| sample(i as f32, i as f32, 0.01)).collect();
        // 0.99ⁿ < 0.01 from n = 459 on, in the second run.
        assert_eq!(before_end(&faint, 0.01), 458);
    }

    #[test]
    fn only_the_first_layers_and_in_the_order_of_depths() {
        let list = vec![sample(1.0, 5.0, 0.1), sample(1.0, 2.0, 0.2), sample(3.0, 4.0, 0.3)];
        let wanted = Wanted { state: State::Sorted, layers: 0, stop: 0.0 };
        assert_eq!(wanted.of(list.clone()), [list[1], list[0], list[2]]);
        assert_eq!(Wanted { layers: 1, ..wanted }.of(list.clone()), [list[0]], "the nearest in the order of blending");
    }

    #[test]
    fn what_is_not_there_is_left_out_and_solids_come_last() {
        let colors = [[0.1; 4], [0.0, 0.0, 0.0, -1.0], [0.2; 4]];
        let depths = [[1.0, 2.0], [2.0, 2.0], [3.0, 3.0]];
        let taken = Taken { pixels: [0, 3], offsets: vec![0, 2, 2, 3], colors: &colors, depths: &depths };
        let solids = Solids { colors: vec![[1.0; 4]; 3], depths: vec![9.0, f32::INFINITY, 9.0] };
        let wanted = Wanted { state: State::Tidy, layers: 0, stop: 0.0 };
        let solid = Sample { rgba: [1.0; 4], depth: 9.0, back: 9.0 };
        let [first, last] = [sample(1.0, 2.0, 0.1), sample(3.0, 3.0, 0.2)];
        assert_eq!(pixels(&taken, Some(&solids), wanted), (vec![2, 0, 2], vec![first, solid, last, solid]));
        assert_eq!(pixels(&taken, None, wanted), (vec![1, 0, 1], vec![first, last]));
    }
}
