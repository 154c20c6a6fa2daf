//! Random samples of a frame that are drawn in parts, perhaps by different processes: what each part hands over, put
//! together to the sums of all samples, from which the image follows with the bytes of a frame drawn at once.
//!
//! A part holds planes of 32-bit words for the whole image, row by row, whatever windows it was drawn in. Ensembles
//! (`spbr`) have whole numbers, which parts add; float32 sums (`stochastic`) depend on the order of additions, so that
//! each batch of samples stays by itself until all are there.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;

use serde::{Deserialize, Serialize, Serializer};
use serde_bytes::{ByteBuf, Bytes};

use super::{Facts, Frame, FrameProfile, PartError, engine_of};
use crate::image::MAX_SIDE;
use crate::passes::bands::Window;
use crate::random::STRATUM;

/// Most strata that go through the splats together.
pub const MOST_STRATA: u32 = 4;

/// Sums that the random samples of a pixel leave before they are resolved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Sums {
    /// Whole numbers over ensembles.
    Ensembles,
    /// Float32 numbers of each batch of samples.
    Samples,
    /// Float32 numbers of each batch of samples, and the exact A, which corrects them.
    Corrected,
}

impl Sums {
    /// Returns the number of samples between two places where they may be cut.
    pub fn step(self) -> u32 {
        match self {
            Self::Ensembles => 1,
            Self::Samples | Self::Corrected => MOST_STRATA * STRATUM,
        }
    }
}

/// Steps at which the random samples of a frame may be cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct SampleSteps {
    /// All samples of a pixel, or ensembles; at least 1.
    pub total: u32,
    /// Parts begin at multiples of it, and end there or at [`Self::total`].
    pub step: u32,
}

impl SampleSteps {
    /// Returns `true` if a part may have these samples; none of them is allowed, too.
    pub fn allows(&self, samples: &Range<u32>) -> bool {
        let is_cut = |at: u32| at == self.total || at.is_multiple_of(self.step);
        samples.start <= samples.end && samples.end <= self.total && is_cut(samples.start) && is_cut(samples.end)
    }
}

impl Frame {
    /// Returns the steps at which the samples of the frame may be cut into parts; `None` where they can't be: of
    /// methods that draw no random ones, and of frames with [`Frame::max_error`], whose number of samples follows from
    /// the image.
    pub fn sample_steps(&self) -> Option<SampleSteps> {
        PartLayout::of(self).map(|layout| layout.steps)
    }
}

/// The part of a frame that was drawn, with what it took.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnPart {
    /// The sums of its samples.
    pub part: SamplePart,
    /// The times of the passes.
    pub profile: FrameProfile,
    /// The counts; samples, ensembles and points drawn are those of the part.
    pub facts: Facts,
}

/// Words for each pixel that a part may hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Plane {
    /// Colors of ensembles: sums of green, red, number and blue, and the complement of the nearest depth's key. Five
    /// words.
    Colors,
    /// Squares of ensembles: sums for red, green and blue, low and high word of each. Six words.
    Squares,
    /// Nearest depth of the samples, float32. One word.
    Depth,
    /// The exact A, float32; with the first sample. One word.
    Exact,
    /// Lengths of lists; with the first sample. One word.
    Lengths,
    /// Four float32 sums of the batch from sample `before` on: of all of it, or of its stratum `number` − 1. Four
    /// words.
    Batch {
        /// Samples before those of the batch.
        before: u32,
        /// Number of the sum.
        number: u32,
    },
}

impl Plane {
    /// Words of a pixel.
    pub fn words(self) -> usize {
        match self {
            Self::Colors => 5,
            Self::Squares => 6,
            Self::Depth | Self::Exact | Self::Lengths => 1,
            Self::Batch { .. } => 4,
        }
    }

    /// The word of pixels where nothing is.
    fn nothing(self) -> u32 {
        if self == Self::Depth { f32::INFINITY.to_bits() } else { 0 }
    }

    /// Adds the words of other samples. Of the last planes only one part has any: the one with the samples that they
    /// are of.
    fn add(self, to: &mut [u32], from: &[u32]) {
        let pairs = to.iter_mut().zip(from);
        match self {
            Self::Colors => {
                for (to, from) in to.chunks_exact_mut(5).zip(from.chunks_exact(5)) {
                    to[..4].iter_mut().zip(from).for_each(|(a, b)| *a = a.wrapping_add(*b));
                    to[4] = to[4].max(from[4]);
                }
            }
            Self::Squares => {
                for (to, from) in to.chunks_exact_mut(2).zip(from.chunks_exact(2)) {
                    let [a, b] = [&*to, from].map(|w| u64::from(w[1]) << 32 | u64::from(w[0]));
                    let sum = a.wrapping_add(b);
                    (to[0], to[1]) = (sum as u32, (sum >> 32) as u32);
                }
            }
            Self::Depth => pairs.for_each(|(a, b)| *a = f32::from_bits(*a).min(f32::from_bits(*b)).to_bits()),
            Self::Exact | Self::Lengths | Self::Batch { .. } => {}
        }
    }
}

/// Contents of the parts of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct PartLayout {
    size: [u32; 2],
    steps: SampleSteps,
    sums: Sums,
    /// `true` if the standard error is asked for.
    spread: bool,
    /// `true` if lengths of lists are asked for, and the method has some.
    lengths: bool,
}

impl PartLayout {
    /// Returns the layout of the parts of a frame; `None` if its samples can't be drawn in parts.
    pub fn of(frame: &Frame) -> Option<Self> {
        let engine = engine_of(&frame.method);
        let (total, sums) = engine.samples(frame).zip(engine.sums())?;
        let lengths = frame.fragments && sums != Sums::Ensembles;
        let (spread, step) = (frame.wants_spread(), sums.step());
        let steps = SampleSteps { total, step };
        frame.max_error.is_none().then_some(Self { size: frame.size, steps, sums, spread, lengths })
    }

    pub fn steps(&self) -> SampleSteps {
        self.steps
    }

    fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Returns the bytes of a part with these samples.
    pub fn bytes(self, samples: Range<u32>) -> u64 {
        4 * self.pixels() as u64 * self.planes(samples).map(|plane| plane.words() as u64).sum::<u64>()
    }

    /// The planes of parts with these samples.
    fn planes(self, samples: Range<u32>) -> impl Iterator<Item = Plane> {
        let (some, first) = (!samples.is_empty(), !samples.is_empty() && samples.start == 0);
        let sampled = self.sums != Sums::Ensembles;
        let beside = [
            (Plane::Colors, some && !sampled),
            (Plane::Squares, some && !sampled && self.spread),
            (Plane::Depth, some && sampled),
            (Plane::Exact, first && self.sums == Sums::Corrected),
            (Plane::Lengths, first && self.lengths),
        ];
        let batches = if sampled { samples } else { 0..0 };
        let end = batches.end;
        let sums = move |before: u32| {
            let strata = if self.spread { (end - before).min(self.steps.step).div_ceil(STRATUM) } else { 0 };
            (0..=strata).map(move |number| Plane::Batch { before, number })
        };
        let batches = batches.step_by(self.steps.step as usize).flat_map(sums);
        beside.into_iter().filter(|(_, is_there)| *is_there).map(|(plane, _)| plane).chain(batches)
    }

    /// True of a layout that a frame may have.
    fn is_possible(&self) -> bool {
        let SampleSteps { total, step } = self.steps;
        let has_size = self.size.iter().all(|side| (1..=MAX_SIDE).contains(side));
        has_size && total > 0 && step == self.sums.step() && !(self.lengths && self.sums == Sums::Ensembles)
    }
}

/// Sums of some random samples of each pixel of a frame, on the host: those of [`Renderer::draw_part`], to be put
/// together by [`Self::add`] in any order, and resolved by [`Renderer::resolve_parts`].
///
/// Bytes per pixel: of ensembles 20, with standard errors 44, however many of them; of samples 16 for each 16 of them
/// and 4, with standard errors 80 for each 16, and with the first sample 4 for alpha correction and 4 for lengths of
/// lists.
///
/// [`Renderer::draw_part`]: super::Renderer::draw_part
/// [`Renderer::resolve_parts`]: super::Renderer::resolve_parts
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Sent")]
pub struct SamplePart {
    layout: PartLayout,
    /// Ranges of samples, in ascending order; they neither touch nor are empty.
    samples: Vec<Range<u32>>,
    planes: BTreeMap<Plane, Vec<u32>>,
}

/// A part on its way: which planes it has follows from its samples. `B` is the bytes of a plane.
#[derive(Serialize, Deserialize)]
struct Sent<B = ByteBuf> {
    layout: PartLayout,
    samples: Vec<Range<u32>>,
    planes: Vec<B>,
}

impl Serialize for SamplePart {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { layout, samples, planes } = self;
        Sent {
            layout: *layout,
            samples: samples.clone(),
            planes: planes.values().map(|words| Bytes::new(bytemuck::cast_slice(words))).collect(),
        }
        .serialize(serializer)
    }
}

impl TryFrom<Sent> for SamplePart {
    type Error = PartError;

    fn try_from(Sent { layout, samples, planes: sent }: Sent) -> Result<Self, PartError> {
        if !layout.is_possible() {
            return Err(PartError::Damaged("a layout without sense"));
        }
        let are_ranges = samples.iter().all(|range| !range.is_empty() && layout.steps.allows(range));
        if !are_ranges || samples.windows(2).any(|pair| pair[0].end >= pair[1].start) {
            return Err(PartError::Damaged("ranges of samples without sense"));
        }
        // Planes are counted no further than they were sent.
        let mut planes = BTreeMap::new();
        for plane in samples.iter().flat_map(|range| layout.planes(range.clone())) {
            planes.insert(plane, Vec::new());
            if planes.len() > sent.len() {
                break;
            }
        }
        let fits = |(plane, bytes): (&Plane, &ByteBuf)| bytes.len() == 4 * layout.pixels() * plane.words();
        if planes.len() != sent.len() || !planes.keys().zip(&sent).all(fits) {
            return Err(PartError::Damaged("other planes than those of its samples"));
        }
        for (words, bytes) in planes.values_mut().zip(sent) {
            *words = bytemuck::pod_collect_to_vec(&bytes);
        }
        Ok(Self { layout, samples, planes })
    }
}

impl SamplePart {
    /// Returns a part in which each pixel has samples that show nothing.
    pub(crate) fn new(layout: PartLayout, samples: Range<u32>) -> Self {
        let filled = |plane: Plane| (plane, vec![plane.nothing(); layout.pixels() * plane.words()]);
        let planes = layout.planes(samples.clone()).map(filled).collect();
        let samples = if samples.is_empty() { Vec::new() } else { vec![samples] };
        Self { layout, samples, planes }
    }

    /// Returns the columns and rows of the image.
    pub fn size(&self) -> [u32; 2] {
        self.layout.size
    }

    /// Returns the samples of a pixel, or the ensembles, that it has: ranges in ascending order that neither touch nor
    /// are empty.
    pub fn samples(&self) -> &[Range<u32>] {
        &self.samples
    }

    /// Adds other samples of the same frame. In whatever order parts are added, the sum is the same. That camera, seed
    /// and points are the same is up to the caller.
    ///
    /// # Errors
    /// Returns an error if the other part is of a frame with another method, size, number of samples or other channels,
    /// or if some of the samples are there already. Then nothing was added.
    pub fn add(&mut self, other: Self) -> Result<(), PartError> {
        if self.layout != other.layout {
            return Err(PartError::Different);
        }
        let all = united(&self.samples, &other.samples)?;
        for (plane, words) in other.planes {
            match self.planes.entry(plane) {
                Entry::Vacant(place) => {
                    place.insert(words);
                }
                Entry::Occupied(mut place) => plane.add(place.get_mut(), &words),
            }
        }
        self.samples = all;
        Ok(())
    }

    /// The samples are those of a whole frame.
    pub(crate) fn check(&self, frame: &Frame) -> Result<(), PartError> {
        if PartLayout::of(frame) != Some(self.layout) {
            return Err(PartError::Different);
        }
        let total = self.layout.steps.total;
        let first = self.samples.first().map_or(0, |range| if range.start == 0 { range.end } else { 0 });
        if first < total { Err(PartError::Missing { first, total }) } else { Ok(()) }
    }

    /// Puts the words of a window's pixels, in its order, in their place.
    pub(crate) fn place(&mut self, plane: Plane, window: Window, words: &[u32]) {
        let Some(all) = self.planes.get_mut(&plane) else { return };
        for (row, words) in rows(self.layout.size, plane, window).zip(words.chunks(row_words(plane, window))) {
            all[row].copy_from_slice(words);
        }
    }

    /// Returns the words of a window's pixels, in its order.
    pub(crate) fn window(&self, plane: Plane, window: Window) -> Vec<u32> {
        let all = self.planes.get(&plane).map_or(&[][..], Vec::as_slice);
        rows(self.layout.size, plane, window).flat_map(|row| all.get(row).unwrap_or_default()).copied().collect()
    }

    /// Returns the words of all pixels, if it has some of this plane.
    pub(crate) fn all(&self, plane: Plane) -> Option<&[u32]> {
        self.planes.get(&plane).map(Vec::as_slice)
    }
}

/// Returns where the rows of a window stand in a plane.
fn rows(size: [u32; 2], plane: Plane, [x0, y0, x1, y1]: Window) -> impl Iterator<Item = Range<usize>> {
    let at = move |x: u32, y: u32| (y as usize * size[0] as usize + x as usize) * plane.words();
    (y0..y1).map(move |y| at(x0, y)..at(x1, y))
}

fn row_words(plane: Plane, [x0, _, x1, _]: Window) -> usize {
    (x1 - x0) as usize * plane.words()
}

/// The samples of both, unless some are in both.
fn united(a: &[Range<u32>], b: &[Range<u32>]) -> Result<Vec<Range<u32>>, PartError> {
    let mut all = [a, b].concat();
    all.sort_unstable_by_key(|range| range.start);
    let mut found: Vec<Range<u32>> = Vec::with_capacity(all.len());
    for range in all {
        match found.last_mut() {
            Some(last) if range.start < last.end => {
                return Err(PartError::Twice { start: range.start, end: last.end.min(range.end) });
            }
            Some(last) if range.start == last.end => last.end = range.end,
            _ => found.push(range),
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [3, 2];

    fn layout(sums: Sums, total: u32) -> PartLayout {
        let steps = SampleSteps { total, step: sums.step() };
        PartLayout { size: SIZE, steps, sums, spread: true, lengths: sums != Sums::Ensembles }
    }

    /// A part whose words follow from where they are.
    fn part(sums: Sums, total: u32, samples: Range<u32>) -> SamplePart {
        let mut part = SamplePart::new(layout(sums, total), samples.clone());
        for (place, (plane, words)) in part.planes.iter_mut().enumerate() {
            for (at, word) in words.iter_mut().enumerate() {
                let value = samples.start.wrapping_mul(0x9e37_79b9).wrapping_add((at * 977 + place * 131) as u32);
                *word = if *plane == Plane::Depth { (value as f32).to_bits() } else { value };
            }
        }
        part
    }

    fn sum(parts: &[SamplePart]) -> SamplePart {
        let mut all = parts[0].clone();
        parts[1..].iter().for_each(|part| all.add(part.clone()).expect("disjoint"));
        all
    }

    #[test]
    fn the_order_of_parts_does_not_matter() {
        for sums in [Sums::Ensembles, Sums::Samples, Sums::Corrected] {
            let parts = [0..32, 32..32, 64..70, 32..64].map(|samples| part(sums, 70, samples));
            let first = sum(&parts);
            for order in [[1, 0, 2, 3], [3, 2, 1, 0], [2, 3, 0, 1], [0, 3, 1, 2]] {
                assert_eq!(sum(&order.map(|i| parts[i].clone())), first);
            }
            let [a, b] = [&parts[..2], &parts[2..]].map(sum);
            assert_eq!(sum(&[b, a]), first);
            assert_eq!(first.samples(), std::slice::from_ref(&(0..70)));
        }
    }

    #[test]
    fn whole_numbers_are_added_with_their_carry_and_the_nearest_depth_stays() {
        let mut squares = [u32::MAX, 1, 5, 0, 0, 9];
        Plane::Squares.add(&mut squares, &[1, 2, 3, 4, 7, 0]);
        assert_eq!(squares, [0, 4, 8, 4, 7, 9]);
        let mut colors = [1, 2, 3, 4, 50, 1, 1, 1, 1, 1];
        Plane::Colors.add(&mut colors, &[10, 20, 30, 40, 5, 0, 0, 0, 0, 2]);
        assert_eq!(colors, [11, 22, 33, 44, 50, 1, 1, 1, 1, 2]);
        let mut depths = [2.0, f32::INFINITY, -1.0].map(f32::to_bits);
        Plane::Depth.add(&mut depths, &[3.0, 1.0, -2.0].map(f32::to_bits));
        assert_eq!(depths.map(f32::from_bits), [2.0, 1.0, -2.0]);
    }

    #[test]
    fn parts_arrive_as_they_were_sent_and_damaged_ones_are_refused() {
        let sent = |SamplePart { layout, samples, planes }: &SamplePart| {
            let bytes = |words: &Vec<u32>| ByteBuf::from(bytemuck::cast_slice(words));
            Sent { layout: *layout, samples: samples.clone(), planes: planes.values().map(bytes).collect() }
        };
        let arrived = |part: &SamplePart| SamplePart::try_from(sent(part));
        for sums in [Sums::Ensembles, Sums::Samples, Sums::Corrected] {
            for samples in [0..0, 0..16, 16..48, 48..70, 0..70] {
                let part = part(sums, 70, samples);
                assert_eq!(arrived(&part).as_ref(), Ok(&part));
                let refused = |damage: &dyn Fn(&mut Sent)| {
                    let mut sent = sent(&part);
                    damage(&mut sent);
                    assert!(matches!(SamplePart::try_from(sent), Err(PartError::Damaged(_))), "{sums:?}");
                };
                refused(&|sent| sent.layout.size[0] = 0);
                refused(&|sent| sent.layout.size = [u32::MAX; 2]);
                refused(&|sent| sent.layout.steps.step = 7);
                refused(&|sent| sent.layout.steps.total = 0);
                refused(&|sent| sent.planes.push(ByteBuf::new()));
                refused(&|sent| sent.samples.push(70..71));
                refused(&|sent| sent.samples.insert(0, 0..0));
                if !part.samples.is_empty() {
                    refused(&|sent| drop(sent.planes.pop()));
                    refused(&|sent| sent.planes[0].extend([0; 4]));
                    refused(&|sent| sent.layout.size[1] += 1);
                    refused(&|sent| sent.samples.push(part.samples[0].clone()));
                }
            }
        }
        // Two ranges that leave a gap.
        let apart = sum(&[part(Sums::Samples, 70, 48..70), part(Sums::Samples, 70, 0..16)]);
        assert_eq!(arrived(&apart), Ok(apart));
    }

    #[test]
    fn parts_of_other_frames_and_samples_that_are_there_already_are_refused() {
        let mut some = part(Sums::Ensembles, 9, 2..5);
        for (samples, start, end) in [(4..6, 4, 5), (0..3, 2, 3), (0..9, 2, 5), (3..4, 3, 4), (2..5, 2, 5)] {
            let before = some.clone();
            let refused = some.add(part(Sums::Ensembles, 9, samples));
            assert_eq!(refused, Err(PartError::Twice { start, end }));
            assert_eq!(some, before);
        }
        for other in [part(Sums::Ensembles, 10, 5..6), part(Sums::Samples, 9, 0..9), part(Sums::Samples, 9, 0..0)] {
            assert_eq!(some.add(other), Err(PartError::Different));
        }
        some.add(part(Sums::Ensembles, 9, 9..9)).expect("none");
        some.add(part(Sums::Ensembles, 9, 7..9)).expect("others");
        some.add(part(Sums::Ensembles, 9, 5..7)).expect("those between");
        assert_eq!(some.samples(), std::slice::from_ref(&(2..9)));
    }

    #[test]
    fn windows_have_their_words_in_place() {
        let mut part = SamplePart::new(layout(Sums::Samples, 16), 0..16);
        let plane = Plane::Batch { before: 0, number: 2 };
        let words: Vec<u32> = (0..16).collect();
        part.place(plane, [1, 0, 3, 2], &words);
        assert_eq!(part.window(plane, [1, 0, 3, 2]), words);
        assert_eq!(part.window(plane, [0, 1, 2, 2]), [0, 0, 0, 0, 8, 9, 10, 11]);
        // Planes that a part's layout lacks are ignored.
        part.place(Plane::Exact, [0, 0, 3, 2], &[1; 6]);
        assert_eq!((part.all(Plane::Exact), part.all(Plane::Lengths)), (None, Some(&[0; 6][..])));
        assert_eq!(part.window(Plane::Depth, [0, 0, 1, 1]), [f32::INFINITY.to_bits()]);
    }

    #[test]
    fn cuts_lie_at_steps_and_at_the_end() {
        let steps = SampleSteps { total: 70, step: 16 };
        for samples in [0..0, 0..16, 16..70, 64..70, 70..70, 0..70, 32..32] {
            assert!(steps.allows(&samples), "{samples:?}");
        }
        for samples in [0..8, 8..16, 64..80, 71..71, 8..8] {
            assert!(!steps.allows(&samples), "{samples:?}");
        }
        assert!(!steps.allows(&Range { start: 32, end: 16 }));
    }
}
