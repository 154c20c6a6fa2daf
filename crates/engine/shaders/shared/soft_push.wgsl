// Push constants of the kernels that blend soft spheres.
struct Push {
    // A class of list lengths, and the band's first fragment among the window's.
    class_index: u32,
    first_fragment: u32,
    // Largest color component, background included.
    max_color: f32,
    // λ, and the opacity that stands for it in Eq. 22.
    lambda: f32,
    peak: f32,
    // For long lists: largest radius, and the first of the events of each list that a dispatch looks at.
    max_radius: f32,
    first: u32,
}

var<immediate> push: Push;
