//! Float32 OpenEXR.

use std::io::{self, Cursor, Write as Out};

use exr::prelude::*;

use super::{WriteOptions, background, matrices};
use pellucid_core::color::ColorSpace;
use pellucid_core::color::decode_srgb;
use pellucid_core::image::Image as Frame;

/// R, G, B composed and linear, A, Z and, if present, other depths, list lengths, layers and standard errors.
pub(super) fn encode(mut out: impl Out, image: &Frame, options: &WriteOptions) -> io::Result<()> {
    let composed = image.composed(background(options.background, options.color));
    let linear = |value: f32| match options.color {
        ColorSpace::Linear => value,
        ColorSpace::Encoded => decode_srgb(value),
    };
    let mut channels = SmallVec::<[_; 4]>::new();
    let mut add = |name: &str, values| channels.push(AnyChannel::new(name, FlatSamples::F32(values)));
    for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
        add(name, composed.iter().map(|pixel| linear(pixel[i])).collect());
    }
    add("A", image.rgba.iter().map(|pixel| pixel[3]).collect());
    add("Z", image.depth.clone());
    for (name, depths) in [("depth.median", &image.depth_median), ("depth.mean", &image.depth_mean)] {
        depths.iter().for_each(|depths| add(name, depths.clone()));
    }
    for (name, counts) in [("fragments.Y", &image.fragments), ("layers.Y", &image.layers)] {
        counts.iter().for_each(|counts| add(name, image.mean_counts(counts)));
    }
    for (i, name) in ["stderr.R", "stderr.G", "stderr.B"].into_iter().enumerate() {
        image.stderr.iter().for_each(|errors| add(name, errors.iter().map(|error| error[i]).collect()));
    }
    let size = (image.width as usize, image.height as usize);
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let [world_to_camera, world_to_normalized_device] =
        match options.camera.and_then(|camera| matrices::matrices(&camera, [image.width, image.height])) {
            Some(matrices) => matrices.map(Some),
            None => [None; 2],
        };
    let attributes = LayerAttributes { world_to_camera, world_to_normalized_device, ..LayerAttributes::default() };
    let layer = Layer::new(size, attributes, encoding, AnyChannels::sort(channels));
    let mut picture = Image::from_layer(layer);
    for (name, value) in &options.metadata {
        // UTF-8, as OpenEXR 3 takes strings to be.
        let text = AttributeValue::Text(Text::from_slice_unchecked(value.as_bytes()));
        picture.attributes.other.insert(Text::from_slice_unchecked(name.as_bytes()), text);
    }
    let mut bytes = Vec::new();
    picture.write().to_buffered(Cursor::new(&mut bytes)).map_err(io::Error::other)?;
    sort_attributes(&mut bytes).ok_or_else(|| io::Error::other("the encoder wrote a header that can't be read"))?;
    out.write_all(&bytes)
}

/// Sorts the attributes of a single-part file's header by name.
///
/// The encoder keeps them in a hash map with a random seed and writes them in its order; without this, two runs would
/// give different bytes. The header's length does not change, so all offsets in the file stay true.
fn sort_attributes(bytes: &mut [u8]) -> Option<()> {
    // Magic number and version; then attributes of name, 0, type, 0, length, value; then 0.
    const START: usize = 8;
    let mut attributes = Vec::new();
    let mut at = START;
    while *bytes.get(at)? != 0 {
        let name_end = at + zero(bytes.get(at..)?)?;
        let kind_end = name_end + 1 + zero(bytes.get(name_end + 1..)?)?;
        let length: [u8; 4] = bytes.get(kind_end + 1..kind_end + 5)?.try_into().ok()?;
        let end = kind_end + 5 + usize::try_from(u32::from_le_bytes(length)).ok()?;
        attributes.push(bytes.get(at..end)?.to_vec());
        at = end;
    }
    attributes.sort();
    bytes.get_mut(START..at)?.copy_from_slice(&attributes.concat());
    Some(())
}

fn zero(bytes: &[u8]) -> Option<usize> {
    bytes.iter().position(|byte| *byte == 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_are_sorted_in_place() {
        let header = |attributes: [&[u8]; 2]| [b"magicver", attributes[0], attributes[1], b"\0rest"].concat();
        let (a, b) = (b"a\0string\0\x02\0\0\0xy".as_slice(), b"b\0int\0\x01\0\0\0z".as_slice());
        let mut bytes = header([b, a]);
        assert_eq!(sort_attributes(&mut bytes), Some(()));
        assert_eq!(bytes, header([a, b]));
        assert_eq!(sort_attributes(&mut header([a, b])[..20]), None, "cut short");
    }
}
