//! The table of methods: how a scene file names each, what it draws, and which settings it takes.
//!
//! Reader, help, reference and window list methods in the order of this table.

mod properties;

use super::schema::{Key, Settings};
use super::settings::{
    BlendedSplats, Discs, Hybrid, ImageSpace, Interpolated, Mlab, Moments, OneLayer, Peel, PeelLayers, ScreenSplats,
    Soft, SoftLayout, Spbr, SpbrSimplified, Stochastic, Wavelet,
};
pub use properties::{Relief, SoftMethod};

/// The name that leaves the method to the scene.
pub(super) const AUTO: &str = "auto";

/// Declares the methods: the enum, and what holds of each. A line is `"name" => Variant(Settings), Family, for
/// Purpose;` behind the sentence that says what the method draws; `also` lists settings, in addition to the defaults,
/// by which comparisons draw the same thing.
macro_rules! methods {
    (
        $(
            $(#[doc = $about:literal])+
            $name:literal => $Variant:ident $(($Settings:ty))?, $family:ident, for $purpose:ident $(, also $also:expr)?;
        )+
    ) => {
        /// A method with its settings.
        #[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
        pub enum Method {
            $($(#[doc = $about])+ $Variant $(($Settings))?,)+
        }

        /// The names a scene file may use: `auto`, and every method.
        pub const METHODS: &[&str] = &[AUTO, $($name),+];

        impl Method {
            /// Returns every method with its defaults.
            pub fn all() -> Vec<Self> {
                vec![$(Self::$Variant $((<$Settings>::default()))?),+]
            }

            /// The name a scene file gives it.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$Variant { .. } => $name,)+
                }
            }

            /// Returns a description of its image, in a sentence or two.
            pub fn about(&self) -> &'static str {
                match self {
                    $(Self::$Variant { .. } => concat!($($about),+).trim_ascii_start(),)+
                }
            }

            /// Other settings by which comparisons draw the same thing, as in `raster=hardware`.
            pub fn also(&self) -> &'static [&'static str] {
                $($(if matches!(self, Self::$Variant { .. }) {
                    return $also;
                })?)+
                &[]
            }

            /// Returns the family of methods that draw the same things.
            pub fn family(&self) -> Family {
                match self {
                    $(Self::$Variant { .. } => Family::$family,)+
                }
            }

            /// Returns the purpose of the method.
            pub fn purpose(&self) -> Purpose {
                match self {
                    $(Self::$Variant { .. } => Purpose::$purpose,)+
                }
            }

            pub(super) fn settings(&self) -> Option<&dyn Settings> {
                $($(if let Self::$Variant(settings) = self {
                    let settings: &$Settings = settings;
                    return Some(settings);
                })?)+
                None
            }

            pub(super) fn settings_mut(&mut self) -> Option<&mut dyn Settings> {
                $($(if let Self::$Variant(settings) = self {
                    let settings: &mut $Settings = settings;
                    return Some(settings);
                })?)+
                None
            }
        }
    };
}

methods! {
    /// The nearest point of each pixel, opaque, one pixel large.
    "points" => Points, Opaque, for Opaque;
    /// The nearest square of each pixel, opaque and facing the screen.
    "squares" => Squares(ScreenSplats), Opaque, for Opaque;
    /// The nearest disc of each pixel, opaque and facing the screen.
    "circles" => Circles(ScreenSplats), Opaque, for Opaque;
    /// Like `circles`, but a paraboloid moves fragments toward the viewer, so that splats meet half-way (Schütz and
    /// Wimmer 2015).
    "paraboloid" => Paraboloid(Interpolated), Opaque, for Opaque;
    /// Like `paraboloid`, but by a cone.
    "cone" => Cone(Interpolated), Opaque, for Opaque;
    /// Like `paraboloid`, but by a sphere.
    "sphere" => Sphere(ScreenSplats), Opaque, for Opaque;
    /// Transparent discs, exact for any number of layers, crossing or not (Maule et al. 2012).
    "abuffer" => ABuffer(Discs), Discs, for Exact, also &["raster=hardware", "long_lists=in-place"];
    /// The image of `abuffer`, to the byte, through a linked list for each pixel (Yang et al. 2010).
    "linked-list" => LinkedList(Discs), Discs, for Exact;
    /// Discs sorted once by depth and blended tile by tile: exact for flat ones, approximate where oriented ones cross.
    "sorted" => Sorted(Discs), Discs, for Exact;
    /// Exact depth peeling of the same discs, without memory for fragments; one pass for each layer.
    "peel" => Peel(Peel), Discs, for Exact;
    /// The nearest surfaces of points, each closed as by `image-space`, blended front to back (Dobrev et al. 2010).
    "peel-layers" => PeelLayers(PeelLayers), Surfaces, for Surfaces;
    /// Random samples of the same discs in each pixel, without sorting, with a standard error (Enderton et al. 2011).
    "stochastic" => Stochastic(Stochastic), Discs, for Approximate, also &["alpha_correction=false", "raster=hardware"];
    /// The nearest discs of each pixel exactly, and those behind by their mean (Maule et al. 2013) or by their moments.
    "hybrid" => Hybrid(Hybrid), Discs, for Approximate, also &["tail=moments"];
    /// A few layers for each pixel; discs come in the order of the files, and the last two layers are merged (Salvi and
    /// Vaidyanathan 2014).
    "mlab" => Mlab(Mlab), Discs, for Approximate;
    /// Discs weighted by the light let through in front of them, as bounded by power moments of each pixel's optical
    /// depth (Münstermann et al. 2018).
    "moments" => Moments(Moments), Discs, for Approximate, also &["overestimation=0", "overestimation=0.25"];
    /// Discs weighted by the light let through in front of them, by wavelets of each pixel's optical depth (Aizenshtein
    /// et al. 2022).
    "wavelet" => Wavelet(Wavelet), Discs, for Approximate;
    /// Discs averaged with weights that fall with depth (McGuire and Bavoil 2013): an approximation with exact opacity.
    "weighted" => Weighted(Discs), Discs, for Approximate;
    /// The mean color of all discs, opaque: a wrong picture to compare with.
    "average" => Average(Discs), Discs, for Compare;
    /// Discs blended in the order of the files: a wrong picture to compare with.
    "unsorted" => Unsorted(Discs), Discs, for Compare;
    /// Opaque discs or squares that face the screen; those close behind the nearest are blended with it.
    "hqs" => Hqs(BlendedSplats), Opaque, for Opaque;
    /// Opaque discs in their tangent planes; those close behind the nearest are blended with it (Botsch et al. 2004).
    "splats" => Splats(BlendedSplats), Opaque, for Opaque;
    /// Points whose holes are closed by filters of the image (Dobrev et al. 2010); needs no radii.
    "image-space" => ImageSpace(ImageSpace), Surfaces, for Opaque;
    /// Soft points as spheres, integrated exactly along each ray, in front of solid points (Seemann et al. 2018).
    "soft-base" => SoftBase(Soft), Soft, for Soft, also &["layout=paper"];
    /// Like `soft-base`, but each sphere consists of concentric shells of constant density.
    "soft-concentric" => SoftConcentric(Soft), Soft, for Soft, also &["equalize=false"];
    /// Like `soft-base`, but with discs in a presorted order: fast and approximate.
    "soft-express" => SoftExpress(Soft), Soft, for Soft;
    /// The nearest soft points as one transparent layer; all other points are opaque.
    "one-layer" => OneLayer(OneLayer), OneLayer, for Soft;
    /// The mean of opaque images of random parts of the points: surfaces with a given opacity (Tanaka et al. 2016).
    "spbr" => Spbr(Spbr), Ensembles, for Surfaces;
    /// Like `spbr`, but each point is in one part only: opacity follows from the points (Uchida et al. 2020).
    "spbr-simplified" => SpbrSimplified(SpbrSimplified), Ensembles, for Surfaces;
}

/// Returns the methods that eye-dome lighting applies to, as the rest of a message about one to which it doesn't.
pub fn edl_methods() -> String {
    let names: Vec<_> =
        Method::all().into_iter().filter(Method::takes_edl).map(|method| format!("\"{}\"", method.name())).collect();
    format!("{} have one", names.join(", "))
}

/// Methods that draw the same things, each in its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Family {
    /// Opaque points and splats.
    Opaque,
    /// Surfaces of points that are closed in the image.
    Surfaces,
    /// Transparent discs.
    Discs,
    /// Soft spheres before solid points.
    Soft,
    /// Single transparent layer before opaque points.
    OneLayer,
    /// Points of surfaces that are partitioned into ensembles.
    Ensembles,
}

impl Family {
    /// Every family, in the order in which lists have them.
    pub const ALL: [Self; 6] = [Self::Opaque, Self::Surfaces, Self::Discs, Self::Soft, Self::OneLayer, Self::Ensembles];

    /// Returns a short description of its methods.
    pub fn title(self) -> &'static str {
        match self {
            Self::Opaque => "opaque points and splats",
            Self::Surfaces => "surfaces closed in the image",
            Self::Discs => "transparent discs",
            Self::Soft => "soft spheres",
            Self::OneLayer => "one transparent layer",
            Self::Ensembles => "ensembles of points",
        }
    }

    /// Returns `true` if its pictures let through more light the lower the opacity of points is.
    pub fn has_opacity(self) -> bool {
        match self {
            Self::Surfaces | Self::Discs | Self::Ensembles => true,
            Self::Opaque | Self::Soft | Self::OneLayer => false,
        }
    }

    /// Returns its methods with their defaults.
    pub fn methods(self) -> impl Iterator<Item = Method> {
        Method::all().into_iter().filter(move |method| method.family() == self)
    }
}

/// Purpose of a method: the groups in which the window lists them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Purpose {
    /// Everything that discs let through, exactly.
    Exact,
    /// Result of the exact methods with an error, in less time or memory.
    Approximate,
    /// Surfaces that have the opacity asked for, however many points they are made of.
    Surfaces,
    /// Soft points before solid ones.
    Soft,
    /// Surfaces that hide what is behind them.
    Opaque,
    /// Wrong pictures that papers compare with.
    Compare,
}

impl Purpose {
    /// Every purpose, in the order in which lists have them.
    pub const ALL: [Self; 6] =
        [Self::Exact, Self::Approximate, Self::Surfaces, Self::Soft, Self::Opaque, Self::Compare];

    /// Returns the wish that the methods of this group fulfill.
    pub fn title(self) -> &'static str {
        match self {
            Self::Exact => "transparent discs, exactly",
            Self::Approximate => "transparent discs, approximately",
            Self::Surfaces => "surfaces of a chosen opacity",
            Self::Soft => "soft foliage or noise in front of solid points",
            Self::Opaque => "opaque surfaces",
            Self::Compare => "wrong pictures, to compare with",
        }
    }

    /// Returns its methods with their defaults.
    pub fn methods(self) -> impl Iterator<Item = Method> {
        Method::all().into_iter().filter(move |method| method.purpose() == self)
    }
}

impl Method {
    /// Returns its keys with the values in force; `name` is not among them.
    pub fn keys(&self) -> Vec<Key> {
        let mut keys = self.settings().map(Settings::keys).unwrap_or_default();
        keys.retain(|key| key.only.is_empty() || key.only.contains(&self.name()));
        keys
    }

    /// Returns `true` if its image is exact except for rounding. `crossing`: true if splats have a depth for each
    /// pixel, and so may cross (`plan::may_cross`).
    pub fn is_exact(&self, crossing: bool) -> bool {
        match self {
            Self::ABuffer(_) | Self::LinkedList(_) => true,
            Self::Sorted(_) => !crossing,
            Self::Peel(peel) => peel.layers == 0,
            Self::SoftBase(soft) => soft.layout == SoftLayout::Precise,
            _ => false,
        }
    }

    /// Returns `true` if its image depends on the seed.
    pub fn is_sampled(&self) -> bool {
        matches!(self, Self::Stochastic(_) | Self::Spbr(_) | Self::SpbrSimplified(_))
    }

    /// Returns settings of this type, if those of the method are of it or hold some.
    pub(super) fn part<T: 'static>(&self) -> Option<&T> {
        let mut parts = Vec::new();
        self.settings()?.parts(&mut parts);
        parts.into_iter().find_map(|part| part.downcast_ref())
    }

    /// Returns one of its keys with its current value.
    pub fn key(&self, name: &str) -> Option<Key> {
        self.keys().into_iter().find(|key| key.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_its_place_in_a_list_by_purpose() {
        let listed: Vec<_> = Purpose::ALL.into_iter().flat_map(Purpose::methods).map(|method| method.name()).collect();
        let all = Method::all();
        assert!(all.iter().all(|method| listed.contains(&method.name())) && listed.len() == all.len(), "{listed:?}");
        assert!(Purpose::ALL.iter().all(|purpose| purpose.methods().next().is_some()), "no heading without methods");
    }
}
