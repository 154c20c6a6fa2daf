//! Separates bias from noise, from images with different seeds.

use super::{Errors, Repeats};

/// Images of one stochastic setting, as differences from the reference.
pub(super) struct Seeds {
    count: u32,
    /// Mean difference of each channel and pixel.
    mean: Vec<f64>,
    /// Squared differences from the mean, over all channels.
    squares: f64,
    errors: Vec<Errors>,
    /// RMSE against the analytic image, if it exists.
    analytic: Vec<f64>,
}

impl Seeds {
    pub fn new(pixels: usize) -> Self {
        Self { count: 0, mean: vec![0.0; 3 * pixels], squares: 0.0, errors: Vec::new(), analytic: Vec::new() }
    }

    /// Adds an image. Sums are kept as Welford (1962) does, so that they don't cancel.
    pub fn add(&mut self, image: &[[f32; 3]], reference: &[[f32; 3]], errors: Errors, analytic: Option<f64>) {
        self.count += 1;
        let share = 1.0 / f64::from(self.count);
        let values = image.as_flattened().iter().zip(reference.as_flattened());
        for (mean, (value, truth)) in self.mean.iter_mut().zip(values) {
            let difference = f64::from(*value) - f64::from(*truth);
            let from_old = difference - *mean;
            *mean += share * from_old;
            self.squares += from_old * (difference - *mean);
        }
        self.errors.push(errors);
        self.analytic.extend(analytic);
    }

    /// Bias and noise; at least two images.
    pub fn repeats(&self) -> Repeats {
        let (channels, count) = (self.mean.len().max(1) as f64, f64::from(self.count));
        let noise = self.squares / channels / (count - 1.0).max(1.0);
        let of_mean = self.mean.iter().map(|mean| mean * mean).sum::<f64>() / channels;
        Repeats {
            seeds: self.count,
            noise: noise.sqrt(),
            bias: (of_mean - noise / count).max(0.0).sqrt(),
            bias_floor: (noise / count).sqrt(),
        }
    }

    /// Root of the mean square of the RMSE against the analytic image.
    pub fn rmse_analytic(&self) -> Option<f64> {
        let squares: f64 = self.analytic.iter().map(|rmse| rmse * rmse).sum();
        (!self.analytic.is_empty()).then(|| (squares / self.analytic.len() as f64).sqrt())
    }

    /// The errors over the seeds: root mean squares of rmse, means of the others; psnr is that of the rmse.
    pub fn errors(&self) -> Errors {
        let mean =
            |value: fn(&Errors) -> f64| self.errors.iter().map(value).sum::<f64>() / f64::from(self.count.max(1));
        let rmse = mean(|e| e.rmse * e.rmse).sqrt();
        Errors {
            rmse,
            // A square already.
            nmse: mean(|e| e.nmse),
            psnr: Some(pellucid_core::metrics::psnr(rmse)).filter(|psnr| psnr.is_finite()),
            ssim: mean(|e| e.ssim),
            flip: mean(|e| e.flip),
            max: mean(|e| e.max),
            above_1_255: mean(|e| e.above_1_255),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with_rmse(rmse: f64) -> Errors {
        Errors { rmse, nmse: rmse, psnr: None, ssim: 1.0, flip: 0.0, max: rmse, above_1_255: 0.0 }
    }

    #[test]
    fn bias_and_noise_by_hand() {
        // Differences 1 and 3 in every channel: mean 2, variance 2, so bias² = 4 − 2/2 = 3.
        let mut seeds = Seeds::new(2);
        for value in [1.5f32, 3.5] {
            seeds.add(&[[value; 3]; 2], &[[0.5; 3]; 2], with_rmse(f64::from(value) - 0.5), Some(f64::from(value)));
        }
        let Repeats { seeds: count, noise, bias, bias_floor } = seeds.repeats();
        assert_eq!(count, 2);
        let assert_is =
            |value: f64, square: f64| assert!((value * value - square).abs() < 1e-12, "{value}² for {square}");
        assert_is(noise, 2.0);
        assert_is(bias, 3.0);
        assert_is(bias_floor, 1.0);
        // √((1 + 9) / 2), and the mean of 1 and 3.
        let errors = seeds.errors();
        assert_is(errors.rmse, 5.0);
        assert_eq!(errors.max, 2.0);
        // (1.5² + 3.5²) / 2.
        assert_is(seeds.rmse_analytic().unwrap(), 7.25);
        // Both together are the error: rmse² = bias² + noise².
        assert_is(errors.rmse, bias * bias + noise * noise);
    }

    #[test]
    fn without_bias_there_is_none_below_the_floor() {
        let mut seeds = Seeds::new(1);
        for value in [-1.0f32, 1.0] {
            seeds.add(&[[value; 3]], &[[0.0; 3]], with_rmse(1.0), None);
        }
        assert_eq!((seeds.repeats().bias, seeds.rmse_analytic()), (0.0, None));
    }
}
