//! Transparent discs, and the methods that blend them.

use crate::schema::{Ladder, Range, Slider, ValueKind, settings, value, words};
use crate::setting::Setting;

settings! {
    /// Settings of the disc family (`abuffer` and its relatives).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Discs {
        /// Orientation of discs: flat ones face the screen, oriented ones lie in the tangent plane.
        shape: DiscShape = DiscShape::Flat;
        /// Falloff of opacity toward the rim of a disc.
        falloff: Falloff = Falloff::Flat;
        /// Rasterization by compute shaders or by the hardware rasterizer; the picture is the same.
        raster: Raster = Raster::Auto;
        /// Sorting of long lists of fragments; the picture is the same.
        long_lists: LongLists = LongLists::Merge, only LISTED;
        /// Footprint and order of Gaussians.
        gaussians: GaussianSettings = GaussianSettings::default();
    }
}

settings! {
    /// Settings of Gaussian splats, by whatever method of the disc family.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct GaussianSettings {
        /// Falloff of a Gaussian's opacity over the pixels.
        kernel: Kernel = Kernel::Ewa;
        /// Order of Gaussians.
        order: Option<Order> = None, without "`\"center\"` for sorted, else `\"pixel\"`";
        /// Largest opacity of a fragment of a Gaussian.
        alpha_max: f32 = 0.99, in Range::UNIT;
        /// Smallest opacity of a fragment; a Gaussian ends there.
        alpha_min: f32 = 1.0 / 255.0, in ALPHA_MIN, slider Slider::Powers(1e-5, 0.1);
        /// Added to the variance on the screen along both axes (ewa).
        dilation: f32 = 0.3, in Range::NOT_NEGATIVE, unit "px²", slider Slider::Linear(0.0, 2.0);
        /// Compensate for the opacity that the dilation adds (ewa).
        antialias: bool = false;
        /// End a list before the fragment that would leave less than this share of the light; 0 never ends a list
        /// early.
        stop: f32 = 0.0, in Range::below(0.0, 1.0), slider Slider::Powers(0.0, 0.1), only &["auto", "abuffer", "linked-list", "sorted", "peel"];
    }
}

/// Something must end a Gaussian.
const ALPHA_MIN: Range = Range::closed(1e-6, 1.0);

words! {
    /// Falloff of a Gaussian's opacity over the pixels.
    pub enum Kernel {
        /// The Gaussian's projection, linear around its center (Zwicker et al. 2001; Kerbl et al. 2023).
        Ewa = "ewa",
        /// The Gaussian's largest value along the pixel's ray (Moënne-Loccoz et al. 2024).
        Ray = "ray",
        /// An ellipsoid of constant density that rays pass through (Mai et al. 2025): abuffer and linked-list.
        Ellipsoid = "ellipsoid",
    }
}

words! {
    /// Order of Gaussians.
    pub enum Order {
        /// The depth of their centers along the viewing axis.
        Center = "center",
        /// The distance of their centers from the eye.
        Distance = "distance",
        /// The place where they are densest along the pixel's ray (Radl et al. 2024).
        Pixel = "pixel",
    }
}

words! {
    /// Depth and tilt of a transparent disc.
    pub enum DiscShape {
        /// Screen-aligned; one depth, that of the center.
        Flat = "flat",
        /// A disc in the tangent plane, with a depth for each pixel; flat where a point has no normal.
        Oriented = "oriented",
    }
}

words! {
    /// Falloff of opacity toward the rim of a disc.
    pub enum Falloff {
        /// Constant.
        Flat = "flat",
        /// opacity·exp(−2ρ²), ρ = distance / radius, at most 1.
        Gaussian = "gaussian",
    }
}

words! {
    /// The visitor of a splat's pixels.
    pub enum Raster {
        /// The one expected to be faster on this device for these splats.
        Auto = "auto",
        /// Compute shaders.
        Compute = "compute",
        /// The hardware rasterizer, with atomics in the fragment shader.
        Hardware = "hardware",
    }
}

/// Methods that sort lists of fragments, or of events.
pub(super) const LISTED: &[&str] = &["abuffer", "linked-list", "soft-base", "soft-concentric"];

words! {
    /// Way to sort lists that are too long for one invocation's registers.
    pub enum LongLists {
        /// Runs that many invocations sort, which are merged between two buffers.
        Merge = "merge",
        /// Sorting in place in the fragment buffer, by one invocation for each list.
        InPlace = "in-place",
    }
}

/// Layers that depth peeling goes through at most, since each of them visits every splat.
pub const MAX_LAYERS: u32 = 65_536;

settings! {
    /// Settings of depth peeling.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Peel {
        /// The discs that are peeled.
        discs: Discs = Discs::default();
        /// Number of nearest layers that are peeled and blended; 0 means all.
        layers: u32 = 0, in 0..=MAX_LAYERS, slider Slider::Count(0, 256), tried LAYERS;
    }
}

const LAYERS: Ladder = Ladder { ends_at_longest_list: true, ..Ladder::new(&[1, 2, 4, 8, 16, 32, 64], &[1, 8]) };

/// Samples of a pixel that stochastic transparency takes at most.
pub const MAX_SAMPLES: u32 = 4096;

settings! {
    /// Settings of multi-sample stochastic transparency.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Stochastic {
        /// The discs that are sampled.
        discs: Discs = Discs::default();
        /// Samples per pixel: more samples have less noise and take longer.
        samples: u32 = 64, in 1..=MAX_SAMPLES, slider Slider::Count(1, 1024), refines true, tried SAMPLES;
        /// Use the exact opacity and scale colors to it, for less noise.
        alpha_correction: bool = true;
    }
}

const SAMPLES: Ladder = Ladder {
    fine: &[1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096],
    at_once: 4,
    ..Ladder::new(&[1, 4, 16, 64, 256, 1024], &[1, 8, 64])
};

/// Fragments that `hybrid` composes exactly at most.
pub const MAX_K: u32 = 64;

settings! {
    /// Settings of hybrid transparency.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Hybrid {
        /// The discs that are blended.
        discs: Discs = Discs::default();
        /// Number of nearest fragments that are exact; those behind are the tail.
        k: u32 = 8, in 1..=MAX_K, tried NEAREST;
        /// Fragments with less opacity always belong to the tail, at any depth.
        core_alpha_min: f32 = 0.0, in Range::UNIT, slider Slider::Linear(0.0, 0.25);
        /// Composition of the tail.
        tail: Tail = Tail::Average;
        /// Number of power moments of the tail (moments).
        moments: MomentCount = MomentCount::Four;
    }
}

words! {
    /// Way in which `hybrid` composes the fragments behind the exact ones.
    pub enum Tail {
        /// The mean color of the tail under its exact opacity (Maule et al. 2013).
        Average = "average",
        /// Each weighted by the light let through in front of it, by power moments, under their exact opacity.
        Moments = "moments",
    }
}

const NEAREST: Ladder = Ladder { ends_at_longest_list: true, ..Ladder::new(&[1, 2, 4, 8, 16, 32], &[1, 8]) };

/// Layers that `mlab` keeps at most.
pub const MAX_NODES: u32 = 16;

settings! {
    /// Settings of multi-layer alpha blending.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Mlab {
        /// The discs that are blended.
        discs: Discs = Discs::default();
        /// Layers kept per pixel while discs come in file order; one fragment more than this is still exact.
        nodes: u32 = 4, in 1..=MAX_NODES, tried NODES;
    }
}

const NODES: Ladder = Ladder { ends_at_longest_list: true, ..Ladder::new(&[1, 2, 4, 8, 16], &[1, 4]) };

settings! {
    /// Settings of moment-based transparency.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Moments {
        /// The discs that are blended.
        discs: Discs = Discs::default();
        /// Number of power moments of each pixel's optical depth.
        moments: MomentCount = MomentCount::Four, tried MOMENTS;
        /// Place of the light in front of a fragment between its bounds: 0 is the most light, 1 the least.
        overestimation: f32 = 0.1, in Range::UNIT;
        /// Share by which moments are moved toward a smooth distribution: more is smoother, less is sharper.
        bias: Option<f32> = None, in Range::UNIT, without "`5e-7`, `5e-6`, `5e-5` for 4, 6, 8 moments", start 5e-6, slider Slider::Powers(1e-8, 0.1);
    }
}

impl Moments {
    /// Returns the bias in force.
    pub fn bias(&self) -> f32 {
        let default = match self.moments {
            MomentCount::Four => 5e-7,
            MomentCount::Six => 5e-6,
            MomentCount::Eight => 5e-5,
        };
        self.bias.unwrap_or(default)
    }
}

const MOMENTS: Ladder = Ladder::new(&[4, 6, 8], &[4, 8]);

/// Number of power moments, besides the sum itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum MomentCount {
    /// 4
    Four = 4,
    /// 6
    Six = 6,
    /// 8
    Eight = 8,
}

impl MomentCount {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Four, Self::Six, Self::Eight];

    /// Returns the number.
    pub fn get(self) -> u32 {
        self as u32
    }
}

value! {
    MomentCount => ValueKind::OneOf(&[4, 6, 8]);
    |table, key| {
        let Some(number) = table.integer(key, 4, 8)? else { return Ok(None) };
        let found = MomentCount::ALL.into_iter().find(|count| count.get() == number);
        match (found, table.get(key)) {
            (None, Some(node)) => Err(table.error(key, node, format!("must be 4, 6 or 8, found {number}"))),
            _ => Ok(found),
        }
    };
    |count| Some(Setting::Integer(count.get()));
}

/// Largest rank of `wavelet`.
pub const MAX_RANK: u32 = 5;

settings! {
    /// Settings of transparency by wavelets.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Wavelet {
        /// The discs that are blended.
        discs: Discs = Discs::default();
        /// Rank of the wavelets; each pixel stores 2^(rank + 1) coefficients of its optical depth.
        rank: u32 = 3, in 1..=MAX_RANK, tried RANKS;
    }
}

const RANKS: Ladder = Ladder::new(&[1, 2, 3, 4, 5], &[1, 3]);
