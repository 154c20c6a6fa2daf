//! The adjustment of the number of points to an opacity, in the terms of the papers' tables.

use serde_json::{Value, json};

use super::share::Wanted;
use crate::methods::prelude::*;
use crate::passes::project::Placed;

/// The adjustment of all clouds of a frame (Tanaka et al. 2016, Table 1; Uchida et al. 2020, Table 1).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Adjusted {
    /// L, of the method.
    pub ensembles: u32,
    /// The clouds with points, in their order.
    pub clouds: Vec<Adjustment>,
}

/// The adjustment of a cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adjustment {
    /// Original number of points.
    pub points: u64,
    /// Adjusted number of points: those of all ensembles together, copies included.
    pub adjusted: u64,
    /// n_raw of Tanaka et al. 2016, Section 3.2.1, with the area of a pixel as S: points on the surface that a pixel
    /// shows, at the depth where a point is one pixel wide. `None` if the points are too few to tell.
    pub per_pixel: Option<f64>,
    /// Opacity α that was asked for; `None` for `spbr-simplified`, where it follows from L.
    pub asked: Option<f64>,
    /// Opacity α of the surface where it faces the viewer. It is below what was asked for where the surface has too few
    /// points. `None` if the points are too few to tell.
    pub opacity: Option<f64>,
}

impl Adjustment {
    /// Returns k, the factor on the number of points (Tanaka et al. 2016, Eq. 4).
    pub fn ratio(&self) -> f64 {
        self.adjusted as f64 / self.points.max(1) as f64
    }

    /// Formats the figures for people.
    fn text(&self, ensembles: u32) -> String {
        let known = |value: Option<f64>| value.map_or_else(|| "unknown".to_owned(), significant);
        let (opacity, per_pixel) = (known(self.opacity), known(self.per_pixel));
        let alpha = match self.asked {
            None => format!("α {opacity}, which follows from L"),
            Some(asked) if self.opacity.is_some_and(|opacity| opacity < asked) => {
                format!("α {opacity} instead of {}", significant(asked))
            }
            Some(asked) => format!("α {}", significant(asked)),
        };
        let Self { points, adjusted, .. } = self;
        let k = significant(self.ratio());
        format!("{alpha}, L {ensembles}, n_raw {per_pixel} on a pixel, points {points} adjusted to {adjusted}, k {k}")
    }
}

impl Adjusted {
    /// Formats a line for each cloud; `names` are those of the clouds.
    pub fn lines(&self, names: &[String]) -> Vec<String> {
        let line = |(cloud, number): (&Adjustment, usize)| match names.get(number) {
            Some(name) => format!("{name}: {}", cloud.text(self.ensembles)),
            None => format!("cloud {}: {}", number + 1, cloud.text(self.ensembles)),
        };
        self.clouds.iter().zip(0..).map(line).collect()
    }

    /// Returns the figures in the form that profiles have.
    pub fn to_json(&self, names: &[String]) -> Value {
        let cloud = |(cloud, number): (&Adjustment, usize)| {
            json!({
                "cloud": names.get(number),
                "alpha": cloud.opacity,
                "asked": cloud.asked,
                "n_raw": cloud.per_pixel,
                "points": cloud.points,
                "adjusted": cloud.adjusted,
                "k": cloud.ratio(),
            })
        };
        json!({"L": self.ensembles, "clouds": self.clouds.iter().zip(0..).map(cloud).collect::<Vec<_>>()})
    }
}

/// Formats a number with four significant digits, or all of those before the point.
fn significant(value: f64) -> String {
    let digits = if value > 0.0 { 3 - value.log10().floor() as i32 } else { 0 };
    let rounded = format!("{value:.*}", digits.clamp(0, 12) as usize);
    match rounded.contains('.') {
        true => rounded.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => rounded,
    }
}

impl Wanted<'_> {
    /// Returns the adjustment of a cloud.
    pub fn adjustment(&self, placed: &Placed) -> Adjustment {
        let share = self.share(placed);
        let ensembles = f64::from(self.method.ensembles().unwrap_or(1));
        let per_pixel = Some(self.per_pixel(placed, share.depth)).filter(|there| *there > 0.0);
        let follows = matches!(self.method, Method::SpbrSimplified(_));
        let opacity = match follows {
            // Uchida et al. 2020, Section 3.4: Eq. 1 with n = N_raw / L.
            true => per_pixel.map(|there| -(-there / ensembles).exp_m1()),
            false => per_pixel.map(|_| share.opacity),
        };
        Adjustment {
            points: share.points.end - share.points.start,
            adjusted: share.slots,
            per_pixel,
            asked: (!follows).then(|| self.opacity(placed)),
            opacity,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_and_no_idle_zeros() {
        let cases =
            [(0.5, "0.5"), (0.123_456, "0.1235"), (20.833, "20.83"), (123_456.7, "123457"), (0.0, "0"), (1.0, "1")];
        for (value, text) in cases {
            assert_eq!(significant(value), text);
        }
        assert_eq!(significant(0.000_012_345_6), "0.00001235");
    }

    #[test]
    fn unknown_figures_are_said_to_be_unknown() {
        let alone = Adjustment { points: 1, adjusted: 8, per_pixel: None, asked: Some(0.5), opacity: None };
        let adjusted = Adjusted { ensembles: 8, clouds: vec![alone, Adjustment { asked: None, ..alone }] };
        let lines = adjusted.lines(&["a.ply".to_owned()]);
        assert_eq!(lines[0], "a.ply: α 0.5, L 8, n_raw unknown on a pixel, points 1 adjusted to 8, k 8");
        assert!(lines[1].starts_with("cloud 2: α unknown, which follows from L, L 8, n_raw unknown"), "{}", lines[1]);
        let json = adjusted.to_json(&[]);
        assert_eq!(json["clouds"][0]["n_raw"], Value::Null);
        assert_eq!(json["clouds"][0]["cloud"], Value::Null);
        assert_eq!(json["clouds"][1]["asked"], Value::Null);
        assert_eq!(json["L"], 8);
    }
}
