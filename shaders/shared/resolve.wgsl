// What the kernels that sort and blend the lists of one class share. One invocation per pixel of the class.
#import compose
#import stop
#import classes
#import dispatch

struct Push {
    // The class, and the band's first fragment among the window's.
    class_index: u32,
    first_fragment: u32,
    // Largest opacity, and largest color component, background included.
    most_opacity: f32,
    most_color: f32,
}

@group(0) @binding(13) var<storage, read> offsets: array<u32>;
@group(0) @binding(14) var<storage, read> classes: array<u32>;
@group(0) @binding(15) var<storage, read> pixels: array<u32>;
@group(0) @binding(16) var<storage, read> fragments: array<vec2<u32>>;
@group(0) @binding(17) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(18) var<storage, read_write> depths: array<f32>;
var<immediate> push: Push;

// Index of the n-th pixel of the class in the window, NOTHING beyond the last.
fn class_pixel(n: u32) -> u32 {
    let word = push.class_index * CLASS_WORDS;
    if n >= classes[word + CLASS_TOTAL] {
        return NOTHING;
    }
    return pixels[classes[word + CLASS_START] + n];
}

fn pixel_place(p: u32) -> vec2<u32> {
    let width = view.window.z - view.window.x;
    return view.window.xy + vec2<u32>(p % width, p / width);
}
