//! Methods of rendering.

macro_rules! methods {
    ($($(#[$about:meta])+ $Variant:ident = $name:literal,)+) => {
        /// Method of rendering; docs/methods.md compares them. Its settings are those of the scene.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Method {
            $($(#[$about])+ $Variant,)+
        }

        impl Method {
            /// All methods.
            pub const ALL: &[Self] = &[$(Self::$Variant),+];

            /// Returns the name that a scene file gives the method.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$Variant => $name,)+
                }
            }
        }
    };
}

methods! {
    /// The exact method that suits the scene.
    Auto = "auto",
    /// Transparent discs, exact, by lists of fragments.
    ABuffer = "abuffer",
    /// Transparent discs, exact, by linked lists.
    LinkedList = "linked-list",
    /// Transparent discs sorted once by depth.
    Sorted = "sorted",
    /// Transparent discs, exact, by depth peeling.
    Peel = "peel",
    /// Layers of surfaces, each closed in the image.
    PeelLayers = "peel-layers",
    /// Random samples of transparent discs.
    Stochastic = "stochastic",
    /// The nearest discs exactly, and the mean of the others.
    Hybrid = "hybrid",
    /// A few layers for each pixel.
    Mlab = "mlab",
    /// Discs weighted by the light let through, from power moments.
    Moments = "moments",
    /// Discs weighted by the light let through, from wavelets.
    Wavelet = "wavelet",
    /// Weighted blended transparency.
    Weighted = "weighted",
    /// The mean color of all discs.
    Average = "average",
    /// Discs in the order of the points, unsorted.
    Unsorted = "unsorted",
    /// The nearest soft points as one transparent layer, before opaque points.
    OneLayer = "one-layer",
    /// Soft spheres and solid points, exact.
    SoftBase = "soft-base",
    /// Soft spheres by concentric shells.
    SoftConcentric = "soft-concentric",
    /// Soft discs in a presorted order.
    SoftExpress = "soft-express",
    /// The mean of opaque images of random parts of the points.
    Spbr = "spbr",
    /// The mean of opaque images, with each point in one of them.
    SpbrSimplified = "spbr-simplified",
    /// The nearest point of each pixel.
    Points = "points",
    /// Opaque squares.
    Squares = "squares",
    /// Opaque discs.
    Circles = "circles",
    /// Opaque discs with the relief of a paraboloid.
    Paraboloid = "paraboloid",
    /// Opaque discs with the relief of a cone.
    Cone = "cone",
    /// Opaque discs with the relief of a sphere.
    Sphere = "sphere",
    /// Opaque discs, blended within a depth.
    Hqs = "hqs",
    /// Opaque oriented discs, blended within a depth.
    Splats = "splats",
    /// Opaque points, closed in the image.
    ImageSpace = "image-space",
}
