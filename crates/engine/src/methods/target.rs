//! The destination of a window's pixels.

use rayon::prelude::*;

use crate::methods::prelude::*;

/// The destination of a window's pixels.
pub struct Target {
    image: Scratch<[f32; 4]>,
    depths: Scratch<f32>,
    image_host: Scratch<[f32; 4]>,
    depths_host: Scratch<f32>,
    /// `true` if colors of windows are not copied to the host.
    pub(super) keeps_colors: bool,
}

impl Target {
    pub(super) fn new() -> Self {
        Self {
            image: Scratch::new("image", Memory::Device),
            depths: Scratch::new("depths", Memory::Device),
            image_host: Scratch::new("image, host", Memory::Readback),
            depths_host: Scratch::new("depths, host", Memory::Readback),
            keeps_colors: false,
        }
    }

    /// Room for a window.
    pub(super) fn reserve(&mut self, device: &Device, pixels: u64) -> Result<(), Error> {
        self.image.reserve(device, pixels)?;
        self.depths.reserve(device, pixels)?;
        self.image_host.reserve(device, pixels)?;
        self.depths_host.reserve(device, pixels)?;
        Ok(())
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

    /// Records the copy to the host, of depths alone if colors stay.
    pub fn record_read_back<'a>(&'a self, recorder: &mut Recorder<'a>, pixels: u64) -> Result<(), Error> {
        if !self.keeps_colors {
            let [from, to] = [&self.image, &self.image_host].map(|kept| kept.get().slice(0, pixels));
            recorder.copy("image/read-back", from, to)?;
        }
        recorder.copy(
            "image/read-back",
            self.depths.get().slice(0, pixels),
            self.depths_host.get().slice(0, pixels),
        )?;
        Ok(())
    }

    /// Returns colors and depths of the first pixels as they came to the host.
    pub(super) fn on_host(&self, pixels: u64) -> (&[[f32; 4]], &[f32]) {
        let pixels = pixels as usize;
        (&self.image_host.get().mapped_slice()[..pixels], &self.depths_host.get().mapped_slice()[..pixels])
    }

    /// Copies the window's rows into the image, of depths alone if colors stay.
    pub(super) fn deliver(&self, window: Window, image: &mut Image) {
        let [x0, y0, x1, y1] = window.map(|v| v as usize);
        let (width, pitch) = (x1 - x0, image.width as usize);
        // On all cores: the image's memory is untouched, and the kernel clears every page on first access.
        if !self.keeps_colors {
            let rgba = image.rgba[y0 * pitch..y1 * pitch].par_chunks_mut(pitch);
            let from = self.image_host.get().mapped_slice().par_chunks(width);
            rgba.zip(from).for_each(|(row, from)| row[x0..x1].copy_from_slice(from));
        }
        let depth = image.depth[y0 * pitch..y1 * pitch].par_chunks_mut(pitch);
        let from = self.depths_host.get().mapped_slice().par_chunks(width);
        depth.zip(from).for_each(|(row, from)| row[x0..x1].copy_from_slice(from));
    }
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
        recorder.fill("image/clear", self.image.first(pixels), 0)?;
        recorder.fill("image/clear", self.depths.first(pixels), f32::INFINITY.to_bits())?;
        Ok(())
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
