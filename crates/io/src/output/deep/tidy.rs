//! Samples of a pixel made tidy.

use super::Sample;

/// Composes samples of surfaces at the same depth to one each, the first in front, in float64. Volumes must not
/// overlap, and all be sorted.
pub fn tidy(samples: &mut Vec<Sample>) {
    let mut kept = 0;
    let mut next = 0;
    while next < samples.len() {
        let first = samples[next];
        let at_once =
            samples[next..].iter().take_while(|other| is_surface(other) && other.depth == first.depth).count();
        samples[kept] = match at_once {
            0 | 1 => first,
            _ => composed(&samples[next..next + at_once]),
        };
        kept += 1;
        next += at_once.max(1);
    }
    samples.truncate(kept);
}

fn is_surface(sample: &Sample) -> bool {
    sample.back <= sample.depth
}

/// The samples over one another, where the first is.
fn composed(samples: &[Sample]) -> Sample {
    let mut sum = [0f64; 4];
    for sample in samples {
        let through = 1.0 - sum[3];
        sum.iter_mut().zip(sample.rgba).for_each(|(sum, value)| *sum += through * f64::from(value));
    }
    Sample { rgba: sum.map(|value| value as f32), ..samples[0] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(depth: f32, back: f32, rgba: [f32; 4]) -> Sample {
        Sample { rgba, depth, back }
    }

    #[test]
    fn surfaces_at_a_depth_become_one_by_hand() {
        let red = [0.5, 0.0, 0.0, 0.5];
        let blue = [0.0, 0.0, 0.25, 0.25];
        let mut samples =
            vec![sample(1.0, 1.0, red), sample(2.0, 2.0, red), sample(2.0, 2.0, blue), sample(2.0, 3.0, blue)];
        tidy(&mut samples);
        // Blue behind red: 0.5 · 0.25 of it shows. The volume behind both stays.
        let both = [0.5, 0.0, 0.125, 0.625];
        let wanted = vec![sample(1.0, 1.0, red), sample(2.0, 2.0, both), sample(2.0, 3.0, blue)];
        assert_eq!(samples, wanted);
        tidy(&mut samples);
        assert_eq!(samples, wanted, "tidy ones stay");
    }

    #[test]
    fn a_surface_behind_a_volume_is_not_part_of_it() {
        let fog = sample(1.0, 2.0, [0.1; 4]);
        let wall = sample(2.0, 2.0, [1.0; 4]);
        let mut samples = vec![fog, wall, wall];
        tidy(&mut samples);
        assert_eq!(samples, [fog, wall]);
        tidy(&mut Vec::new());
    }
}
