//! Uchida et al. 2020, Eq. 8 and 9: as many ensembles as bring the noise of a pixel below β.

use std::path::Path;

use pellucid_core::image::Image;
use pellucid_engine::Result;
use pellucid_scene::{Method, Spbr};

use super::chart;
use super::stage::{Stage, noisy_plane};

/// Side of the images.
const SIDE: f64 = 512.0;
/// σ² of the noise of each point, as in the paper's example, in gray levels².
const VARIANCE: f64 = 10.0;
/// 1 / β: 1 and 3 are the paper's.
const PER_BETA: [u32; 3] = [1, 2, 3];
const OPACITIES: [f64; 2] = [0.3, 0.9];
/// Gray of the plane: far from black and white, where noise is cut off.
const GRAY: f64 = 128.0;

/// Writes `choice.csv`.
pub fn measure(stage: &mut Stage, scale: f64, folder: &Path) -> Result<()> {
    let side = (SIDE * scale).round() as u32;
    let mut table = Vec::new();
    for alpha in OPACITIES {
        // More than the most ensembles need, so that no point is dealt twice.
        let most = PER_BETA.map(|per_beta| wanted(per_beta, alpha)).into_iter().max().unwrap_or(1);
        let per_pixel = 1.1 * f64::from(most) * -(-alpha).ln_1p();
        let count = (per_pixel * f64::from(side).powi(2)).round() as usize;
        let mut cloud = stage.upload(noisy_plane(count, GRAY, VARIANCE, stage.seed))?;
        for per_beta in PER_BETA {
            let beta = f64::from(per_beta).recip();
            for (rule, ensembles) in [("Eq. 9", wanted(per_beta, 1.0)), ("Eq. 9 over α", wanted(per_beta, alpha))] {
                let method = Method::Spbr(Spbr { ensembles, ..Spbr::default() });
                let found = deviation(&stage.thinned(&mut cloud, side, alpha as f32, method)?);
                let expected = expected(alpha, ensembles);
                println!(
                    "α {alpha}, β {beta:.3}, {rule}: L {ensembles}, deviation {found:.3} of {expected:.3}, {:.2} β",
                    found / beta
                );
                table.push(vec![alpha, beta, f64::from(ensembles), found, expected, found / beta]);
            }
        }
    }
    let header = "alpha,beta,ensembles,deviation,expected deviation,deviation over beta";
    super::write(folder, "choice.csv", &chart::csv(header, &table))
}

/// The least L above σ² / (share · β²): Eq. 9 with a share of 1.
fn wanted(per_beta: u32, share: f64) -> u32 {
    // A hair of rounding is no whole ensemble.
    (VARIANCE * f64::from(per_beta).powi(2) / share + 1e-9).floor() as u32 + 1
}

/// Standard deviation, in gray levels, of the mean color of the images that hit a pixel, over the pixels that any hits.
fn deviation(image: &Image) -> f64 {
    let hit = image.rgba.iter().filter(|pixel| pixel[3] > 0.0);
    let errors: Vec<_> = hit.map(|pixel| 255.0 * f64::from(pixel[0] / pixel[3]) - GRAY).collect();
    (errors.iter().map(|error| error * error).sum::<f64>() / errors.len().max(1) as f64).sqrt()
}

/// Expected deviation: σ √E\[1/M\], where M of L images hit the pixel, each with probability α, and at least one.
fn expected(alpha: f64, ensembles: u32) -> f64 {
    let (mut sum, mut any) = (0.0, 0.0);
    let mut chance = (1.0 - alpha).powi(ensembles as i32);
    for hits in 1..=ensembles {
        chance *= f64::from(ensembles - hits + 1) / f64::from(hits) * alpha / (1.0 - alpha);
        (sum, any) = (sum + chance / f64::from(hits), any + chance);
    }
    (VARIANCE * sum / any).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_paper_s_examples_are_above_10_and_90() {
        assert_eq!(PER_BETA.map(|per_beta| wanted(per_beta, 1.0)), [11, 41, 91]);
        // A third of the images are hit: three times as many.
        assert_eq!(wanted(1, 0.3), 34);
    }

    /// Two images of α = 1/2: one is hit in 2 of 3 cases, both in 1 of 3: E\[1/M\] = 5/6.
    #[test]
    fn one_of_two_images_or_both() {
        assert!((expected(0.5, 2) - (10.0f64 * 5.0 / 6.0).sqrt()).abs() < 1e-12);
        // Nearly opaque: all of them.
        assert!((expected(1.0 - 1e-9, 10) - 1.0).abs() < 1e-6);
    }
}
