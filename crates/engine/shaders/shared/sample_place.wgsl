// Where the sample of a pixel lies. The stage has `view`.

// 1: pixels are quarters of those of the picture, half as wide and high, each with the sample of an image of its own.
// The column of a sample in its quarter follows from the row of that, and its row from the column (Hammersley's points;
// src/methods/mean.rs).
override QUARTERS: u32 = 0u;

// Columns and rows of a pixel of the picture.
fn columns_of_pixel() -> f32 {
    return select(1.0, 2.0, QUARTERS != 0u);
}

// Place of the sample in a pixel: in its middle, unless that is a quarter.
fn sample_in(pixel: vec2<u32>) -> vec2<f32> {
    if QUARTERS == 0u {
        return vec2<f32>(0.5);
    }
    return view.sample.xy + view.sample.z * vec2<f32>(pixel.yx & vec2<u32>(1u));
}

// How far samples lie from the middle of their pixels at most, in x and y.
fn most_aside() -> f32 {
    if QUARTERS == 0u {
        return 0.0;
    }
    return view.sample.w;
}
