// spbr/nearest, spbr/nearest-depth, spbr/nearest-id: the nearest point of each pixel and ensemble. The largest key is
// the nearest one's: its complement is what the minimum is taken of.
#import spbr
#piece

const NEAREST_BINDING = 7;
#walker

fn visit(point: u32, plane: u32, depth: u32, pixel: u32) {
    let words = ~key_words(point, depth);
    offer(plane * push.pixels + pixel, words.y, words.x);
}
