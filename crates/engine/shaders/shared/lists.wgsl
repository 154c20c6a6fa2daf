// The lists of one class of lengths, for kernels that sort and blend them: one invocation per pixel of the class. The
// stage's push constants begin with the class and the band's first fragment among the window's.
#import compose
#import classes
#import dispatch

@group(0) @binding(17) var<storage, read> offsets: array<u32>;
@group(0) @binding(18) var<storage, read> classes: array<u32>;
@group(0) @binding(19) var<storage, read> pixels: array<u32>;
@group(0) @binding(20) var<storage, read> fragments: array<vec2<u32>>;
@group(0) @binding(21) var<storage, read_write> image: array<vec4<f32>>;
@group(0) @binding(22) var<storage, read_write> depths: array<f32>;

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
