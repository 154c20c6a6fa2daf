//! Common properties of the methods of opaque points.

use pellucid_core::points::Points;
use pellucid_scene::{BlendedSplats, ImageSpace, Interpolated, Method, Relief, ScreenSplats, SplatShape};

/// The scene's settings for opaque points, independent of its method. Sizes and iterations are varied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surfaces {
    /// True if points have normals.
    pub normals: bool,
    /// Clamp and rasterizer; of size 1 in the world.
    pub splats: ScreenSplats,
    /// Outline of what has one.
    pub shape: SplatShape,
    /// `blend_depth` of three-pass splats.
    pub blend_depth: f32,
    /// The filters of `image-space`.
    pub filters: ImageSpace,
    /// The relief of the scene's method.
    pub relief: Relief,
}

impl Surfaces {
    /// The settings of a scene; `None` if its method draws no opaque points.
    pub fn for_method(method: &Method, points: &Points) -> Option<Self> {
        let normals = points.normals.is_some();
        let plain = Self {
            normals,
            splats: ScreenSplats::default(),
            shape: SplatShape::default(),
            blend_depth: BlendedSplats::default().blend_depth,
            filters: ImageSpace::default(),
            relief: method.relief(),
        };
        let sized = |splats: &ScreenSplats| ScreenSplats { size: 1.0, pixel_radius: None, ..*splats };
        Some(match method {
            Method::Points => plain,
            Method::Squares(splats) | Method::Circles(splats) | Method::Sphere(splats) => {
                Self { splats: sized(splats), ..plain }
            }
            Method::Paraboloid(settings) | Method::Cone(settings) => {
                let Interpolated { splats, shape } = settings;
                Self { splats: sized(splats), shape: *shape, ..plain }
            }
            Method::Hqs(settings) | Method::Splats(settings) => {
                let BlendedSplats { splats, blend_depth, shape } = settings;
                Self { splats: sized(splats), shape: *shape, blend_depth: *blend_depth, ..plain }
            }
            Method::ImageSpace(filters) => Self { filters: *filters, ..plain },
            _ => return None,
        })
    }

    /// The method that draws surfaces best: blended splats of size 1, in the points' tangent planes if they have
    /// normals.
    pub fn reference(&self) -> Method {
        let settings = self.blended(1.0, SplatShape::default());
        if self.normals { Method::Splats(settings) } else { Method::Hqs(settings) }
    }

    /// Returns all methods of opaque points with the settings of one of them, its size or its radius in pixels
    /// included.
    pub fn alike(&self, method: &Method) -> Vec<Method> {
        let splats = own_splats(method).copied().unwrap_or(self.splats);
        let interpolated = Interpolated { splats, shape: self.shape };
        let blended = |shape| self.blended(splats.size.into(), shape);
        let all = [
            Method::Points,
            Method::Squares(splats),
            Method::Circles(splats),
            Method::Paraboloid(interpolated),
            Method::Cone(interpolated),
            Method::Sphere(splats),
            Method::Hqs(blended(self.shape)),
            Method::ImageSpace(self.filters),
        ];
        let oriented = self.normals.then(|| Method::Splats(blended(SplatShape::default())));
        all.into_iter().chain(oriented).collect()
    }

    /// Returns the scene's splats with another size.
    pub fn sized(&self, size: f64) -> ScreenSplats {
        ScreenSplats { size: size as f32, ..self.splats }
    }

    pub(super) fn interpolated(&self, size: f64) -> Interpolated {
        Interpolated { splats: self.sized(size), shape: self.shape }
    }

    pub(super) fn blended(&self, size: f64, shape: SplatShape) -> BlendedSplats {
        // Compute tiles draw these, regardless of how the others are drawn.
        let splats = ScreenSplats { raster: Default::default(), ..self.sized(size) };
        BlendedSplats { splats, blend_depth: self.blend_depth, shape }
    }
}

/// Returns the splats of a method; `None` of one without.
fn own_splats(method: &Method) -> Option<&ScreenSplats> {
    match method {
        Method::Squares(splats) | Method::Circles(splats) | Method::Sphere(splats) => Some(splats),
        Method::Paraboloid(settings) | Method::Cone(settings) => Some(&settings.splats),
        Method::Hqs(settings) | Method::Splats(settings) => Some(&settings.splats),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_methods_have_the_size_of_the_scene_s() {
        let splats = ScreenSplats { size: 3.0, ..ScreenSplats::default() };
        let sizes = |method: Method, normals: bool| -> Vec<_> {
            let points = Points { normals: normals.then(Vec::new), ..Points::default() };
            let all = Surfaces::for_method(&method, &points).unwrap().alike(&method);
            all.iter().map(|method| (method.name(), own_splats(method).map(|splats| splats.size))).collect()
        };
        let found = sizes(Method::Circles(splats), false);
        let names = ["points", "squares", "circles", "paraboloid", "cone", "sphere", "hqs", "image-space"];
        assert_eq!(found.iter().map(|(name, _)| *name).collect::<Vec<_>>(), names);
        assert!(found.iter().all(|(_, size)| size.is_none_or(|size| size == 3.0)), "{found:?}");
        let found = sizes(Method::Points, true);
        assert_eq!(found.last(), Some(&("splats", Some(1.0))));
        // A radius in pixels is that of flat splats and reliefs; blended ones have those of the points.
        let pixels = ScreenSplats { pixel_radius: Some(2.0), ..splats };
        let of = |method: &Method| own_splats(method).map(|splats| splats.pixel_radius);
        let method = Method::Squares(pixels);
        let all = Surfaces::for_method(&method, &Points::default()).unwrap().alike(&method);
        let found: Vec<_> = all.iter().filter_map(of).collect();
        assert_eq!(found, [[Some(2.0); 5].as_slice(), &[None]].concat());
    }

    #[test]
    fn the_scene_s_settings_are_kept_but_for_the_size() {
        let splats = ScreenSplats { size: 3.0, max_pixel_radius: 7.0, ..ScreenSplats::default() };
        let square = SplatShape::Square;
        let points = Points { normals: Some(Vec::new()), ..Points::default() };
        let surfaces_of = |method: Method| Surfaces::for_method(&method, &points).unwrap();
        let cone = surfaces_of(Method::Cone(Interpolated { splats, shape: square }));
        assert_eq!((cone.splats.size, cone.splats.max_pixel_radius, cone.shape), (1.0, 7.0, square));
        assert_eq!((cone.relief, cone.normals), (Relief::Cone, true));
        let Method::Splats(reference) = cone.reference() else { panic!("{cone:?}") };
        assert_eq!((reference.splats.size, reference.splats.max_pixel_radius), (1.0, 7.0));
        assert_eq!(reference.shape, SplatShape::Circle);
        let hqs = Surfaces::for_method(
            &Method::Hqs(BlendedSplats { splats, blend_depth: 0.5, shape: square }),
            &Points::default(),
        );
        let hqs = hqs.unwrap();
        assert!(matches!(hqs.reference(), Method::Hqs(BlendedSplats { blend_depth: 0.5, .. })), "{hqs:?}");
        let filters = ImageSpace { min_layer_distance: Some(0.25), ..ImageSpace::default() };
        assert_eq!(surfaces_of(Method::ImageSpace(filters)).filters, filters);
        for other in [
            Method::ABuffer(Default::default()),
            Method::PeelLayers(Default::default()),
            Method::OneLayer(Default::default()),
        ] {
            assert_eq!(Surfaces::for_method(&other, &points), None);
        }
    }
}
