// Shared by the kernels that sort and blend the lists of one class.
#import lists
#import stop
#import early_end

struct Push {
    class_index: u32,
    first_fragment: u32,
    // Largest opacity, and largest color component, background included.
    max_opacity: f32,
    max_color: f32,
}

var<immediate> push: Push;
