//! The factor p that makes a thinned-out image as bright as the opaque one (Uchida et al. 2020, Section 3.4).
//!
//! The paper raises p from 1 in steps of 0.01 until more than 1% of the pixels of the brightened gray image lie between
//! B_th and B_max of the opaque one: B_max is its largest gray, B_th the largest gray that more than 1% of its pixels
//! reach. Since no pixel gets darker as p grows, bisection finds here the first and the last step at which a pixel lies
//! in that range, and a histogram counts the steps: the same p, with some 30 trials instead of hundreds.
//!
//! Gray is that of 8-bit pictures: 0.299 R + 0.587 G + 0.114 B (ITU-R BT.601, which makes pure red 76, as in the paper)
//! of the values that a PNG would hold over a black background, premultiplied colors clamped to 1 and sRGB-encoded
//! (unchanged with `color = "encoded"`), times 255, rounded to the nearest. Pixels without a point count as black, as
//! in the paper.

use rayon::prelude::*;
use serde_json::{Value, json};

use super::Renderer;
use crate::color::encode_srgb;
use crate::methods::prelude::*;
use crate::scene::{Brightness, ColorSpace, SpbrSimplified};

/// Steps of p are 1/100.
const STEPS_PER_UNIT: u32 = 100;

/// No p above this is tried; the paper's are below 3.
pub const LARGEST: u32 = 1000;

/// Steps from 1 to [`LARGEST`], both included.
const STEPS: u32 = (LARGEST - 1) * STEPS_PER_UNIT + 1;

/// A computed brightening.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brightening {
    /// p, from 1 to [`LARGEST`].
    pub factor: f32,
    /// B_th and B_max of the opaque image, 0 to 255. B_th = 0: at most 1% of its pixels are brighter than black, and p
    /// is 1.
    pub window: [u8; 2],
    /// Reason why p has this value.
    pub end: End,
}

/// Reason why a search for p ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The paper's condition is met.
    Met,
    /// No step meets it, since pixels jump over a narrow window; p is the first one at which more than 1% reach B_th.
    JumpedOver,
    /// No p up to [`LARGEST`] makes more than 1% of the pixels so bright; p is 1.
    TooDark,
}

/// The brightening applied to an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Applied {
    /// p, by which its colors were multiplied.
    pub factor: f32,
    /// The computation of p, if p was not given.
    pub found: Option<Brightening>,
}

impl Applied {
    /// Returns the metadata of an image, `{p, threshold, largest}`; the latter two are B_th and B_max, or null where p
    /// was given.
    pub fn json(&self) -> Value {
        let window = self.found.map(|found| found.window);
        // 2.52, and not what float32 makes of it.
        let p = self.factor.to_string().parse::<f64>().unwrap_or(f64::from(self.factor));
        json!({ "p": p, "threshold": window.map(|w| w[0]), "largest": window.map(|w| w[1]) })
    }

    /// Returns a warning for unusual values of p.
    pub fn warning(&self) -> Option<String> {
        let found = self.found?;
        match found {
            Brightening { window: [0, _], .. } => Some(
                "brightness: not brightened, because at most 1% of the pixels of the opaque image are brighter than black; \
                 use a closer view or `brightness = p`"
                    .into(),
            ),
            Brightening { end: End::TooDark, .. } => Some(format!(
                "brightness: not brightened, because no factor up to {LARGEST} makes 1% of the pixels as bright as those of \
                 the opaque image"
            )),
            _ => None,
        }
    }
}

/// Returns `true` if images of a method are brightened.
pub fn is_applied(method: &Method) -> bool {
    matches!(method, Method::SpbrSimplified(_)) || matches!(method, Method::Spbr(spbr) if spbr.brighten)
}

/// Brightens a frame's image as its method demands: `spbr-simplified`, and `spbr` with `brighten`. If p is not given,
/// all points are rendered once more, as a single ensemble. `None` for other methods, whose image stays unchanged.
///
/// # Errors
/// Returns an error if rendering fails.
pub fn apply(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    frame: &Frame,
    image: &mut Image,
) -> Result<Option<Applied>, Error> {
    if !is_applied(&frame.method) {
        return Ok(None);
    }
    renderer.disown_colors();
    let applied = match &frame.method {
        Method::SpbrSimplified(SpbrSimplified { brightness: Brightness::Factor(factor), .. }) => {
            Applied { factor: *factor, found: None }
        }
        _ => search_with(renderer, cloud, frame, image)?,
    };
    brighten(&mut image.rgba, applied.factor);
    for error in image.stderr.iter_mut().flatten().flatten() {
        *error *= applied.factor;
    }
    Ok(Some(applied))
}

/// p of an image by the opaque one.
fn search_with(
    renderer: &mut Renderer,
    cloud: &mut DeviceCloud,
    frame: &Frame,
    image: &Image,
) -> Result<Applied, Error> {
    let opaque = SpbrSimplified { ensembles: 1, brightness: Brightness::Factor(1.0) };
    let frame = Frame { method: Method::SpbrSimplified(opaque), fragments: false, max_error: None, ..*frame };
    let reference = renderer.render(cloud, &frame)?.image;
    let found = factor(&image.rgba, &reference.rgba, frame.color);
    Ok(Applied { factor: found.factor, found: Some(found) })
}

/// Returns the p that makes the image `pixels`, premultiplied R, G, B and A without background, about as bright as the
/// opaque image `reference` of the same camera. Values are linear light or encoded ones, according to `color`; NaN
/// counts as 0. The images may differ in size, since shares of their pixels are compared.
pub fn factor(pixels: &[[f32; 4]], reference: &[[f32; 4]], color: ColorSpace) -> Brightening {
    let scale = GrayScale::new(color);
    let window = window(&scale, reference);
    let [low, high] = window;
    let visits: Vec<_> = pixels
        .par_iter()
        .filter_map(|pixel| {
            let enters = first(|step| scale.gray(*pixel, of_step(step)) >= low)?;
            Some((enters, first(|step| scale.gray(*pixel, of_step(step)) > high)))
        })
        .collect();
    let (met, reached) = search(&visits, pixels.len());
    let (step, end) = match (met, reached) {
        (Some(step), _) => (step, End::Met),
        (None, Some(step)) => (step, End::JumpedOver),
        (None, None) => (0, End::TooDark),
    };
    Brightening { factor: of_step(step), window, end }
}

/// Multiplies the colors of an image by p. Values are clamped to 1, unless they exceeded it before, because 8-bit
/// pictures hold no more; A stays unchanged.
pub fn brighten(pixels: &mut [[f32; 4]], factor: f32) {
    for color in pixels.iter_mut().flat_map(|pixel| &mut pixel[..3]) {
        *color = (*color * factor).min(color.max(1.0));
    }
}

/// p of a step.
fn of_step(step: u32) -> f32 {
    (STEPS_PER_UNIT + step) as f32 / STEPS_PER_UNIT as f32
}

/// The first step at which `holds`, which stays so from there on.
fn first(holds: impl Fn(u32) -> bool) -> Option<u32> {
    let (mut below, mut at) = (0, STEPS);
    while below < at {
        let middle = below + (at - below) / 2;
        if holds(middle) {
            at = middle;
        } else {
            below = middle + 1;
        }
    }
    (at < STEPS).then_some(at)
}

/// The first step at which more than 1% of `count` pixels are within the window, and the first at which they are not
/// below it. A visit is the step at which a pixel enters, and that at which it leaves.
fn search(visits: &[(u32, Option<u32>)], count: usize) -> (Option<u32>, Option<u32>) {
    let mut changes = vec![(0i64, 0i64); STEPS as usize];
    let mut change = |step: u32, within: i64, reached: i64| {
        if let Some(at) = changes.get_mut(step as usize) {
            *at = (at.0 + within, at.1 + reached);
        }
    };
    for (enters, leaves) in visits {
        change(*enters, 1, 1);
        leaves.iter().for_each(|step| change(*step, -1, 0));
    }
    let enough = |pixels: i64| is_over_one_percent(pixels.unsigned_abs(), count);
    let sums = changes.iter().scan((0, 0), |sum, change| {
        *sum = (sum.0 + change.0, sum.1 + change.1);
        Some(*sum)
    });
    let (mut met, mut reached) = (None, None);
    for (step, (within, above)) in (0u32..).zip(sums) {
        met = met.or(enough(within).then_some(step));
        reached = reached.or(enough(above).then_some(step));
        if met.is_some() {
            break;
        }
    }
    (met, reached)
}

fn is_over_one_percent(pixels: u64, count: usize) -> bool {
    100 * u128::from(pixels) > count as u128
}

/// B_th and B_max.
fn window(scale: &GrayScale, reference: &[[f32; 4]]) -> [u8; 2] {
    let mut histogram = [0u64; 256];
    for pixel in reference {
        histogram[usize::from(scale.gray(*pixel, 1.0))] += 1;
    }
    let brightest = histogram.iter().rposition(|pixels| *pixels > 0).unwrap_or(0);
    let mut reached = 0;
    let threshold = (0..=brightest).rev().find(|gray| {
        reached += histogram[*gray];
        is_over_one_percent(reached, reference.len())
    });
    // Both come from indices of 256 numbers.
    [threshold.unwrap_or(0) as u8, brightest as u8]
}

/// Conversion of an image's values to the gray of an 8-bit picture.
struct GrayScale {
    /// sRGB-encoded values of 0 to 1 in equal steps; `None` for encoded values.
    encoded: Option<Vec<f32>>,
}

impl GrayScale {
    /// Steps of linear light: the steepest one is 1/20 of an 8-bit step.
    const RESOLUTION: u16 = u16::MAX;

    fn new(color: ColorSpace) -> Self {
        let encode = |step: u16| encode_srgb(f32::from(step) / f32::from(Self::RESOLUTION));
        Self { encoded: (color == ColorSpace::Linear).then(|| (0..=Self::RESOLUTION).map(encode).collect()) }
    }

    /// The gray of a pixel whose color is multiplied by `factor`; never less for a larger factor.
    fn gray(&self, [r, g, b, _]: [f32; 4], factor: f32) -> u8 {
        let value = |color: f32| {
            // NaN stays and becomes 0 as an index.
            let cut = (color * factor).clamp(0.0, 1.0);
            match &self.encoded {
                Some(table) => {
                    let step = (cut * f32::from(Self::RESOLUTION) + 0.5) as usize;
                    table.get(step).copied().unwrap_or(1.0)
                }
                None => cut,
            }
        };
        (255.0 * (0.299 * value(r) + 0.587 * value(g) + 0.114 * value(b)) + 0.5) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::threefry2x32;

    /// The paper's loop, trial by trial; `None` if it does not end.
    fn paper(pixels: &[[f32; 4]], reference: &[[f32; 4]], color: ColorSpace, limit: f32) -> Option<f32> {
        let scale = GrayScale::new(color);
        let grays = |pixels: &[[f32; 4]], p: f32| pixels.iter().map(|x| scale.gray(*x, p)).collect::<Vec<_>>();
        let share = |grays: &[u8], from: u8, to: u8| {
            let within = grays.iter().filter(|gray| (from..=to).contains(*gray)).count();
            within as f64 / grays.len() as f64
        };
        let opaque = grays(reference, 1.0);
        let largest = opaque.iter().copied().max()?;
        let threshold = (0..=largest).rev().find(|th| share(&opaque, *th, largest) > 0.01)?;
        let trials = (0..).map(|i| (100 + i) as f32 / 100.0).take_while(|p| *p <= limit);
        trials.into_iter().find(|p| share(&grays(pixels, *p), threshold, largest) > 0.01)
    }

    fn noise(n: u32, seed: u32, scale: f32) -> Vec<[f32; 4]> {
        let unit = |word: u32| (word >> 8) as f32 / 16_777_216.0;
        let pixel = |i| {
            let ([r, g], [b, a]) = (threefry2x32([i, 0], [seed, 1]), threefry2x32([i, 1], [seed, 1]));
            // Half of the pixels are empty, and bright ones are rare.
            let value = |word| if a % 2 == 0 { 0.0 } else { scale * unit(word).powi(3) };
            [value(r), value(g), value(b), if a % 2 == 0 { 0.0 } else { 1.0 }]
        };
        (0..n).map(pixel).collect()
    }

    #[test]
    fn the_same_as_trial_by_trial() {
        for color in [ColorSpace::Linear, ColorSpace::Encoded] {
            for (seed, dark) in [(1, 0.9), (2, 0.5), (3, 0.21), (4, 0.08), (5, 1.0), (6, 1.3)] {
                let (reference, image) = (noise(3000, seed, 0.8), noise(2500, seed + 10, 0.8 * dark));
                let found = factor(&image, &reference, color);
                assert_eq!((found.end, Some(found.factor)), (End::Met, paper(&image, &reference, color, 60.0)));
            }
        }
    }

    #[test]
    fn a_darker_copy_gets_its_brightness_back() {
        let reference = noise(20_000, 7, 0.9);
        for p in [1.0f32, 1.37, 2.52, 8.0] {
            let image: Vec<_> = reference.iter().map(|[r, g, b, a]| [r / p, g / p, b / p, *a]).collect();
            let found = factor(&image, &reference, ColorSpace::Linear);
            // One 8-bit step of the threshold, some 200 of 255, is about 1% of the linear value; p comes in steps of
            // 0.01.
            assert!((found.factor / p - 1.0).abs() < 0.02, "{p}: {found:?}");
            let mut brightened = image;
            brighten(&mut brightened, found.factor);
            let alphas = |pixels: &[[f32; 4]]| pixels.iter().map(|pixel| pixel[3]).collect::<Vec<_>>();
            assert_eq!(alphas(&brightened), alphas(&reference));
        }
    }

    #[test]
    fn black_empty_and_small() {
        let (black, gray) = (vec![[0.0, 0.0, 0.0, 1.0]; 1000], vec![[0.2, 0.2, 0.2, 1.0]; 1000]);
        let factor_for = |image: &[[f32; 4]], reference: &[[f32; 4]]| factor(image, reference, ColorSpace::Encoded);
        assert_eq!(factor_for(&black, &black), Brightening { factor: 1.0, window: [0, 0], end: End::Met });
        assert_eq!(factor_for(&black, &gray), Brightening { factor: 1.0, window: [51, 51], end: End::TooDark });
        assert_eq!(factor_for(&[], &gray).end, End::TooDark);
        assert_eq!(factor_for(&gray, &[]).factor, 1.0);
        // Objects that cover at most 1% of the picture have no effect.
        let mut small = vec![[0.0; 4]; 1000];
        small[..10].fill([1.0; 4]);
        assert_eq!(factor_for(&gray, &small), Brightening { factor: 1.0, window: [0, 255], end: End::Met });
        small[10] = [1.0; 4];
        assert_eq!(factor_for(&gray, &small), Brightening { factor: 5.0, window: [255, 255], end: End::Met });
        // NaN, and colors beyond 1 that stay.
        assert_eq!(factor_for(&[[f32::NAN, f32::INFINITY, -1.0, 1.0]; 10], &gray).factor, 1.0);
        let mut bright = [[2.0, 0.4, -0.5, 0.5], [0.7, 0.1, 0.0, 1.0]];
        brighten(&mut bright, 2.0);
        assert_eq!(bright, [[2.0, 0.8, -1.0, 0.5], [1.0, 0.2, 0.0, 1.0]]);
    }

    #[test]
    fn metadata_and_warnings() {
        let applied = |window, end| Applied { factor: 2.52, found: Some(Brightening { factor: 2.52, window, end }) };
        let given = Applied { factor: 2.5, found: None };
        assert_eq!(given.json().to_string(), r#"{"p":2.5,"threshold":null,"largest":null}"#);
        assert_eq!(applied([3, 200], End::Met).json().to_string(), r#"{"p":2.52,"threshold":3,"largest":200}"#);
        assert!(
            [given, applied([3, 200], End::Met), applied([3, 200], End::JumpedOver)]
                .iter()
                .all(|x| x.warning().is_none())
        );
        assert!(applied([0, 200], End::Met).warning().unwrap().contains("closer view"));
        assert!(applied([3, 200], End::TooDark).warning().unwrap().contains("no factor up to 1000"));
    }

    #[test]
    fn a_window_of_one_gray_may_be_jumped_over() {
        // 153.0 at p = 1 and 154.5 at 1.01: 154 is jumped over.
        let (image, reference) = (vec![[0.6, 0.6, 0.6, 1.0]; 100], vec![[154.0 / 255.0; 4]; 100]);
        let found = factor(&image, &reference, ColorSpace::Encoded);
        assert_eq!(found, Brightening { factor: 1.01, window: [154, 154], end: End::JumpedOver });
    }
}
