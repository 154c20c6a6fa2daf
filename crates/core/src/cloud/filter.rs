//! Filters that splats were trained with, as their file says it.

/// The filter that a file of splats names. It is shown, and a note names the keys that render them so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Filter {
    /// Filter of the original renderer: every splat grows by a fixed variance on the image.
    Plain,
    /// Filter of Mip-Splatting: splats that grow become less opaque.
    Mip,
    /// Filter of 2D Gaussian splatting: flat splats.
    Flat,
}

impl Filter {
    /// Returns the filter of a name as files have it, in any case.
    pub fn named(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "default" => Some(Self::Plain),
            "mip" | "antialiased" => Some(Self::Mip),
            "2dgs" => Some(Self::Flat),
            _ => None,
        }
    }

    /// Returns the name that PLY files have for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Plain => "default",
            Self::Mip => "mip",
            Self::Flat => "2dgs",
        }
    }
}
