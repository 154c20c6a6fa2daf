//! `[shading]` and its light, and `[shadows]`.

use super::surfaces::Iterations;
use crate::schema::{Range, Slider, ValueKind, settings, value, words};
use crate::setting::Setting;
use crate::tree;
use pellucid_core::cloud::Bounds;
use pellucid_core::cloud::light_image::automatic_resolution;
use pellucid_core::cloud::shadow_texture::Casting;
use pellucid_core::image::MAX_SIDE;
use pellucid_core::light::Light;

settings! {
    /// `[shading]`.
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Shading {
        /// Shading model: lambert is matte, phong has highlights, none shows plain colors; auto is lambert except on
        /// foliage.
        model: ShadingModel = ShadingModel::Auto;
        /// Ambient light, as a factor on the color.
        ambient: f32 = 0.2, in Range::NOT_NEGATIVE, slider Slider::Linear(0.0, 1.0);
        /// Diffuse light, as a factor on the color.
        diffuse: f32 = 0.8, in Range::NOT_NEGATIVE, slider Slider::Linear(0.0, 1.0);
        /// Strength of highlights (phong).
        specular: f32 = 0.0, in Range::NOT_NEGATIVE, slider Slider::Linear(0.0, 1.0);
        /// Exponent of highlights (phong): larger values make them smaller.
        shininess: f32 = 32.0, in Range::NOT_NEGATIVE, slider Slider::Powers(1.0, 1000.0);
        /// Light: at the eye, along a direction, or at a position.
        light: Light = Light::Headlight;
        /// Eye-dome lighting.
        edl: Edl = Edl::default();
    }
}

impl Shading {
    /// Colors as they are.
    pub const NONE: Self = Self {
        model: ShadingModel::None,
        ambient: 0.2,
        diffuse: 0.8,
        specular: 0.0,
        shininess: 32.0,
        light: Light::Headlight,
        edl: Edl { edl: false, edl_strength: 1.0, edl_radius: 1.4 },
    };
}

settings! {
    /// Keys of `[shading]` about eye-dome lighting (Boucheny 2009).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Edl {
        /// Eye-dome lighting: pixels behind their neighbors get darker, which shows shape without normals.
        edl: bool = false;
        /// Strength of the darkening.
        edl_strength: f32 = 1.0, in Range::NOT_NEGATIVE, slider Slider::Linear(0.0, 4.0);
        /// Distance to the neighbors it compares with.
        edl_radius: f32 = 1.4, in Range::open(0.0, 100.0), unit "pixels", slider Slider::Linear(1.0, 8.0);
    }
}

words! {
    /// `[shading] model`.
    pub enum ShadingModel {
        /// Colors as they are.
        None = "none",
        /// c·(ambient + diffuse·max(0, n·l)).
        Lambert = "lambert",
        /// Lambert plus specular·max(0, r·v)^shininess.
        Phong = "phong",
        /// Lambert, where normals are given or estimated from neighbors that lie near a surface.
        Auto = "auto",
    }
}

/// The formula of a shading model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Formula {
    /// c.
    None,
    /// c·(ambient + diffuse·max(0, n·l)).
    Lambert,
    /// Lambert plus specular·max(0, r·v)^shininess.
    Phong,
}

impl ShadingModel {
    /// Returns its formula where there are normals.
    pub fn formula(self) -> Formula {
        match self {
            Self::None => Formula::None,
            Self::Lambert | Self::Auto => Formula::Lambert,
            Self::Phong => Formula::Phong,
        }
    }
}

value! {
    Light => ValueKind::Other(
        "`\"headlight\"`, the direction `[x, y, z]` in which the light travels, or `{ position = [x, y, z] }` in world units",
    );
    |table, key| {
        let Some(node) = table.get(key) else { return Ok(None) };
        match &node.value {
            tree::Value::String(word) if word == "headlight" => Ok(Some(Light::Headlight)),
            tree::Value::Array(_) => Ok(table.direction(key)?.map(Light::Direction)),
            tree::Value::Table(_) => {
                let light = table.table(key)?;
                light.refuse_unknown(&["position"])?;
                let position = light.vector("position")?.map(|position| Some(Light::Position(position)));
                position.ok_or_else(|| table.error(key, node, "must have a `position` if it is a table".into()))
            }
            _ => Err(table.wrong(key, node, "\"headlight\", a direction [x, y, z] or { position = [x, y, z] }")),
        }
    };
    |light| match light {
        Light::Headlight => Some(Setting::from("headlight")),
        Light::Direction(direction) => Some(Setting::from(direction.to_array())),
        // A table, which no setting is.
        Light::Position(_) => None,
    };
}

/// Most samples of an area light.
pub const MAX_SHADOW_SAMPLES: u32 = 65_536;

/// `[shadows] resolution`: columns and rows of a light's image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum MapResolution {
    /// About one point of the nearest surface for each lit pixel
    /// ([`automatic_resolution`](pellucid_core::cloud::light_image::automatic_resolution)).
    Auto,
    /// Fixed number of pixels, from 1 to [`MAX_SIDE`].
    Pixels(u32),
}

value! {
    MapResolution => ValueKind::WordOr("auto", &ValueKind::Integer(1, MAX_SIDE));
    |table, key| match table.get(key).map(|node| &node.value) {
        Some(tree::Value::String(_)) => table.choice(key, &[("auto", MapResolution::Auto)]),
        _ => Ok(table.integer(key, 1, MAX_SIDE)?.map(MapResolution::Pixels)),
    };
    |resolution| Some(match *resolution {
        MapResolution::Auto => Setting::from("auto"),
        MapResolution::Pixels(pixels) => Setting::Integer(pixels),
    });
}

settings! {
    /// `[shadows]`: one share of light per point (Dobrev et al. 2010, Section 6).
    #[derive(Copy, serde::Serialize, serde::Deserialize)]
    pub struct Shadows {
        /// Number of lights that sample an area light; more make smoother edges.
        samples: u32 = 1, in 1..=MAX_SHADOW_SAMPLES, slider Slider::Count(1, 256);
        /// Radius of the area light: degrees (below 90) around a direction, world units around a position; 0 makes hard
        /// shadows.
        light_radius: f32 = 0.0, in Range::NOT_NEGATIVE, slider Slider::Lengths(0.0, 0.25);
        /// Side of the shadow map; auto: a lit pixel holds about one point of the nearest surface, from 64 to 4096.
        resolution: MapResolution = MapResolution::Auto, unit "pixels", start 1024.0, slider Slider::Count(16, 8192);
        /// Iterations that fill background between points of the shadow map; auto: until nothing changes, at most 64.
        fill: Iterations = Iterations::Count(1), unit "iterations", start 4.0, slider Slider::Count(0, 16);
        /// Iterations that replace points seen through holes of the shadow map; auto: until nothing changes, at most
        /// 64.
        occlusion: Iterations = Iterations::Count(1), unit "iterations", start 4.0, slider Slider::Count(0, 16);
        /// Points closer than this to the first lit surface are lit, too.
        min_layer_distance: Option<f32> = None, in Range::POSITIVE, unit "world units",
            without "1% of the scene's diagonal", start 0.01, slider Slider::Lengths(1e-5, 1.0);
    }
}

/// Default distance between surfaces, as a share of the scene's diagonal.
const APART: f64 = 0.01;

impl Shadows {
    /// Returns the casting of a light onto so many points in a box; `None` for a headlight, which casts no shadows.
    pub fn casting(&self, light: Light, seed: u64, (bounds, points): (&Bounds, u64)) -> Option<Casting> {
        let light = match light {
            Light::Headlight => return None,
            Light::Direction(direction) => Light::Direction(direction.normalize_or_zero()),
            Light::Position(_) => light,
        };
        let hard = self.light_radius == 0.0;
        Some(Casting {
            light,
            samples: if hard { 1 } else { self.samples },
            light_radius: self.light_radius,
            resolution: match self.resolution {
                MapResolution::Auto => automatic_resolution(&light, bounds, points),
                MapResolution::Pixels(pixels) => pixels,
            },
            // Of `auto`, those behind the last that changes something change nothing.
            fill: self.fill.most(),
            occlusion: self.occlusion.most(),
            min_layer_distance: self.min_layer_distance.unwrap_or((APART * bounds.diagonal()) as f32),
            seed: if hard { 0 } else { seed },
        })
    }
}

words! {
    /// `[shadows] method`.
    pub enum ShadowMethod {
        /// One share of light for each point, found once for all views.
        Texture = "texture",
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// A box that is 40 × 10 from above, a quarter of a square image.
    const POINTS: Bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(40.0, 196.0, 10.0) };

    fn casting(light: Light, shadows: &Shadows, seed: u64) -> Casting {
        shadows.casting(light, seed, (&POINTS, 80_000)).expect("it casts")
    }

    #[test]
    fn what_makes_no_difference_is_none() {
        let (long, short) = (Light::Direction(DVec3::new(0.0, -4.0, 0.0)), Light::Direction(DVec3::NEG_Y));
        let hard = Shadows { samples: 30, min_layer_distance: Some(2.0), ..Shadows::default() };
        let one = casting(long, &hard, 7);
        assert_eq!(one, casting(short, &Shadows { samples: 1, ..hard }, 8));
        // The box has a diagonal of √(40² + 196² + 10²) = 200.29.
        assert_eq!((one.samples, one.seed, one.min_layer_distance), (1, 0, 2.0));
        assert_eq!(casting(long, &Shadows::default(), 7).min_layer_distance, (0.01 * 40_116f64.sqrt()) as f32);
        assert_eq!(hard.casting(Light::Headlight, 0, (&POINTS, 9)), None);
    }

    #[test]
    fn auto_is_what_it_stands_for() {
        let down = Light::Direction(DVec3::NEG_Y);
        let auto = casting(down, &Shadows::default(), 0);
        // Half of 80 000 points on a quarter of the image.
        assert_eq!((auto.resolution, auto.fill, auto.occlusion), (400, 1, 1));
        let given = Shadows { resolution: MapResolution::Pixels(400), ..Shadows::default() };
        assert_eq!(casting(down, &given, 0), auto);
        let until = Shadows { fill: Iterations::Auto, occlusion: Iterations::Auto, ..given };
        assert_eq!((casting(down, &until, 0).fill, casting(down, &until, 0).occlusion), (64, 64));
    }

    #[test]
    fn textures_of_before_there_were_iterations_had_one_of_occlusion() {
        let old = r#"{"direction":[0.0,-1.0,0.0],"samples":1,"light_radius":0.0,"resolution":1024,"min_layer_distance":0.5,"seed":0}"#;
        let read: Casting = serde_json::from_str(old).expect("as written");
        let same = Shadows {
            resolution: MapResolution::Pixels(1024),
            fill: Iterations::Count(0),
            min_layer_distance: Some(0.5),
            ..Shadows::default()
        };
        assert_eq!(read, casting(Light::Direction(DVec3::NEG_Y), &same, 0));
        // Their hash is one of this text.
        assert_eq!(serde_json::to_string(&read).expect("plain numbers"), old);
    }

    #[test]
    fn differences_are_named() {
        let soft = Shadows { light_radius: 2.0, ..Shadows::default() };
        let one = casting(Light::Position(DVec3::ONE), &soft, 1);
        assert_eq!(one.differences(&one), [""; 0]);
        let other = Shadows {
            light_radius: 3.0,
            samples: 2,
            resolution: MapResolution::Pixels(5),
            fill: Iterations::Count(2),
            occlusion: Iterations::Count(3),
            min_layer_distance: Some(1.0),
        };
        let other = casting(Light::Direction(DVec3::ONE), &other, 2);
        let all = ["light", "samples", "light_radius", "resolution", "fill", "occlusion", "min_layer_distance", "seed"];
        assert_eq!(one.differences(&other), all);
        assert_eq!(one.differences(&Casting { seed: 2, ..one }), ["seed"]);
    }

    #[test]
    fn a_spelled_casting_comes_back_to_the_bit() {
        let soft = Shadows { light_radius: 0.1, ..Shadows::default() };
        for light in [Light::Direction(DVec3::new(0.1, -0.7, 1.0 / 3.0)), Light::Position(DVec3::splat(0.1))] {
            let one = casting(light, &soft, u64::MAX);
            let text = serde_json::to_string(&one).expect("plain numbers");
            assert_eq!(serde_json::from_str::<Casting>(&text).expect("as written"), one, "{text}");
        }
    }
}
