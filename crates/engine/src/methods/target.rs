//! The destination of a window's pixels.

use rayon::prelude::*;

use super::encode::PixelEncoder;
use super::{Colors, Outputs};
use crate::gpu::GpuType;
use crate::methods::prelude::*;

/// The destination of a window's pixels.
pub struct Target {
    image: Scratch<[f32; 4]>,
    depths: Scratch<f32>,
    image_host: Scratch<[f32; 4]>,
    depths_host: Scratch<f32>,
    bytes: Scratch<u32>,
    bytes_host: Scratch<u32>,
    encoder: Option<PixelEncoder>,
    /// The outputs of windows that are copied to the host.
    outputs: Outputs,
}

impl Target {
    pub(super) fn new() -> Self {
        Self {
            image: Scratch::new("image", Memory::Device),
            depths: Scratch::new("depths", Memory::Device),
            image_host: Scratch::new("image, host", Memory::Readback),
            depths_host: Scratch::new("depths, host", Memory::Readback),
            bytes: Scratch::new("bytes", Memory::Device),
            bytes_host: Scratch::new("bytes, host", Memory::Readback),
            encoder: None,
            outputs: Outputs::default(),
        }
    }

    /// Room for a window, of which the host gets these outputs.
    pub(super) fn reserve(&mut self, device: &Device, pixels: u64, outputs: Outputs) -> Result<(), Error> {
        self.image.reserve(device, pixels)?;
        self.depths.reserve(device, pixels)?;
        self.outputs = outputs;
        match outputs.colors {
            Colors::Float => self.image_host.reserve(device, pixels)?,
            Colors::Bytes => {
                self.bytes.reserve(device, pixels)?;
                self.bytes_host.reserve(device, pixels)?;
            }
            Colors::Stay => {}
        }
        if outputs.depth {
            self.depths_host.reserve(device, pixels)?;
        }
        Ok(())
    }

    /// Makes ready to encode the colors of a frame, if their bytes come to the host.
    pub(super) fn follow(&mut self, device: &Device, frame: &Frame) -> Result<(), Error> {
        if self.outputs.colors == Colors::Bytes {
            let encoder = match self.encoder.take() {
                Some(encoder) => encoder,
                None => PixelEncoder::new(device)?,
            };
            self.encoder.insert(encoder).follow(frame);
        }
        Ok(())
    }

    /// Brings colors to the host that would stay, since the device won't have all of them at once.
    pub(super) fn bring_colors(&mut self, device: &Device) -> Result<(), Error> {
        if self.leaves_colors() {
            self.outputs.colors = Colors::Float;
            self.image_host.reserve(device, self.image.get().len())?;
        }
        Ok(())
    }

    /// Returns `true` if colors of windows stay on the device.
    pub(super) fn leaves_colors(&self) -> bool {
        self.outputs.colors == Colors::Stay
    }

    /// Returns premultiplied color and A of the window's pixels.
    pub fn image(&self) -> Slice<'_, [f32; 4]> {
        self.image.get().all()
    }

    /// Returns the colors of the first pixels, on the host.
    pub(super) fn read_colors(&self, pixels: u64) -> Result<Vec<[f32; 4]>, Error> {
        Ok(self.image.get().read(0, pixels)?)
    }

    /// Returns the depths of the first pixels, on the host.
    pub(super) fn read_depths(&self, pixels: u64) -> Result<Vec<f32>, Error> {
        Ok(self.depths.get().read(0, pixels)?)
    }

    /// Gives the first pixels these depths.
    pub(super) fn set_depths(&self, depths: &[f32]) -> Result<(), Error> {
        Ok(self.depths.get().upload(depths)?)
    }

    /// Returns depths of the window's pixels.
    pub fn depths(&self) -> Slice<'_, f32> {
        self.depths.get().all()
    }

    /// Both.
    pub fn pixels(&self) -> Pixels<'_> {
        Pixels { image: self.image(), depths: self.depths() }
    }

    /// Records the copy to the host, of the outputs that are wanted there.
    pub fn record_read_back<'a>(&'a self, recorder: &mut Recorder<'a>, pixels: u64) -> Result<(), Error> {
        let mut copies = Vec::new();
        match (self.outputs.colors, &self.encoder) {
            (Colors::Float, _) => {
                let [from, to] = [&self.image, &self.image_host].map(|kept| kept.get().slice(0, pixels));
                copies.push((from.cast(), to.cast()));
            }
            (Colors::Bytes, Some(encoder)) => {
                let [from, to] = [&self.bytes, &self.bytes_host].map(|kept| kept.get().slice(0, pixels));
                encoder.record(recorder, self.image.get().slice(0, pixels), from)?;
                copies.push((from, to));
            }
            (Colors::Bytes, None) | (Colors::Stay, _) => {}
        }
        if self.outputs.depth {
            let [from, to] = [&self.depths, &self.depths_host].map(|kept| kept.get().slice(0, pixels));
            copies.push((from.cast(), to.cast()));
        }
        match copies.is_empty() {
            true => Ok(()),
            false => Ok(recorder.copy_all("image/read-back", &copies)?),
        }
    }

    /// Returns colors and depths of the first pixels as they came to the host.
    pub(super) fn on_host(&self, pixels: u64) -> (&[[f32; 4]], &[f32]) {
        let pixels = pixels as usize;
        (&self.image_host.get().mapped_slice()[..pixels], &self.depths_host.get().mapped_slice()[..pixels])
    }

    /// Copies the window's rows into the image, as far as they came to the host.
    pub(super) fn deliver(&self, window: Window, image: &mut Image) {
        let pitch = image.width;
        match (self.outputs.colors, &mut image.bytes) {
            (Colors::Float, _) => place(self.image_host.get(), window, &mut image.rgba, pitch, |color| *color),
            (Colors::Bytes, Some(bytes)) => {
                place(self.bytes_host.get(), window, bytes, pitch, |word| word.to_le_bytes());
            }
            (Colors::Bytes, None) | (Colors::Stay, _) => {}
        }
        if self.outputs.depth {
            place(self.depths_host.get(), window, &mut image.depth, pitch, |depth| *depth);
        }
    }
}

/// Puts the rows of a window into an image that has so many columns.
fn place<F: GpuType + Sync, T: Send>(
    from: &Buffer<F>,
    window: Window,
    image: &mut [T],
    columns: u32,
    of: impl Fn(&F) -> T + Sync,
) {
    let [x0, y0, x1, y1] = window.map(|v| v as usize);
    let (width, pitch) = (x1 - x0, columns as usize);
    // On all cores: the image's memory is untouched, and the kernel clears every page on first access.
    let rows = image[y0 * pitch..y1 * pitch].par_chunks_mut(pitch).zip(from.mapped_slice().par_chunks(width));
    rows.for_each(|(row, from)| row[x0..x1].iter_mut().zip(from).for_each(|(to, from)| *to = of(from)));
}

group! {
    /// The image to draw into; it has at least as many elements as the window has pixels.
    pub Pixels as PixelsGroup {
        /// Premultiplied color; A = 1 where anything is, else all 0.
        image: ReadWrite<[f32; 4]>,
        /// Depths along the viewing axis, +inf where nothing is.
        depths: ReadWrite<f32>,
    }
}

impl<'a> Pixels<'a> {
    /// Records that nothing is there.
    pub fn record_nothing(self, recorder: &mut Recorder<'a>, window: Window) -> Result<(), Error> {
        let pixels = bands::pixels(window);
        let [image, depths] = [self.image.first(pixels).cast(), self.depths.first(pixels).cast()];
        Ok(recorder.fill_all("image/clear", &[(image, 0), (depths, f32::INFINITY.to_bits())])?)
    }
}

fields! {
    /// Pixels of a window's solid points, which soft ones are drawn before, or of its nearest soft points.
    pub struct Layer {
        image: Scratch<[f32; 4]> = Scratch::new("solid image", Memory::Device),
        depths: Scratch<f32> = Scratch::new("solid depths", Memory::Device),
    }
}

impl Layer {
    /// Bytes of a pixel.
    pub const PIXEL_BYTES: u64 = 20;

    /// Room for a window.
    pub fn reserve(&mut self, device: &Device, pixels: u64) -> Result<(), Error> {
        self.image.reserve(device, pixels)?;
        self.depths.reserve(device, pixels)?;
        Ok(())
    }

    /// Returns premultiplied color, A = 1 where something is.
    pub fn image(&self) -> Slice<'_, [f32; 4]> {
        self.image.get().all()
    }

    /// Returns depths along the viewing axis, +inf where nothing is.
    pub fn depths(&self) -> Slice<'_, f32> {
        self.depths.get().all()
    }

    /// Returns both of `len` pixels from `start`, on the host.
    pub fn read(&self, [start, len]: [u64; 2]) -> Result<(Vec<[f32; 4]>, Vec<f32>), Error> {
        Ok((self.image.get().read(start, len)?, self.depths.get().read(start, len)?))
    }

    /// Both.
    pub fn pixels(&self) -> Pixels<'_> {
        Pixels { image: self.image(), depths: self.depths() }
    }
}
