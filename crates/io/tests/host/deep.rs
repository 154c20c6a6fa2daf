//! Deep EXR files: their bytes by hand, all of them through a decoder of these tests' own, and what no file can hold.

use std::io::{Cursor, ErrorKind, Read, Seek, SeekFrom, Write};

use flate2::read::ZlibDecoder;
use pellucid_io::output::deep::{DeepLayout, Numbers, Packing, Sample, State, Writer, Written};
use pellucid_testing_host::random;
use rand::RngExt;

pub fn layout(size: [u32; 2]) -> DeepLayout {
    DeepLayout {
        size,
        state: State::Tidy,
        tells_state: false,
        numbers: Numbers::Float,
        packing: Packing::Raw,
        volumes: false,
        metadata: vec![("pellucid:scene".to_owned(), "a.ply".to_owned())],
        camera: None,
    }
}

fn sample(rgba: [f32; 4], depth: f32) -> Sample {
    Sample { rgba, depth, back: depth }
}

/// Writes pixels in parts of `step`.
fn written(layout: &DeepLayout, lists: &[Vec<Sample>], step: usize) -> (Vec<u8>, Written) {
    let mut bytes = Vec::new();
    let mut writer = Writer::begin(Cursor::new(&mut bytes), layout).unwrap();
    for lists in lists.chunks(step) {
        let lengths: Vec<u32> = lists.iter().map(|list| list.len() as u32).collect();
        writer.push(&lengths, &lists.concat()).unwrap();
    }
    let written = writer.finish().unwrap();
    (bytes, written)
}

#[test]
fn a_tiny_image_by_hand() {
    // Two rows of one pixel: the first with two samples, the second with none.
    let lists = [vec![sample([0.5, 0.25, 1.0, 0.5], 2.0), sample([0.0, 0.0, 0.0, 1.0], 4.0)], vec![]];
    let (bytes, counts) = written(&layout([1, 2]), &lists, 1);
    let text = |text: &str| [text.as_bytes(), b"\0"].concat();
    let int = |value: i32| value.to_le_bytes().to_vec();
    let long = |value: u64| value.to_le_bytes().to_vec();
    let attribute = |name: &str, kind: &str, value: &[u8]| {
        [text(name), text(kind), int(value.len() as i32), value.to_vec()].concat()
    };
    let window = [0, 0, 0, 1].map(i32::to_le_bytes).concat();
    let channel = |name: &str| [text(name), int(2), int(0), int(1), int(1)].concat();
    let channels = [["A", "B", "G", "R", "Z"].map(channel).concat(), vec![0]].concat();
    let header = |state: Vec<u8>| {
        [
            vec![0x76, 0x2f, 0x31, 0x01, 0x02, 0x08, 0x00, 0x00],
            attribute("channels", "chlist", &channels),
            attribute("chunkCount", "int", &int(2)),
            attribute("compression", "compression", &[0]),
            attribute("dataWindow", "box2i", &window),
            state,
            attribute("displayWindow", "box2i", &window),
            attribute("lineOrder", "lineOrder", &[0]),
            attribute("maxSamplesPerPixel", "int", &int(2)),
            attribute("name", "string", b"deep"),
            attribute("pellucid:scene", "string", b"a.ply"),
            attribute("pixelAspectRatio", "float", &1f32.to_le_bytes()),
            attribute("screenWindowCenter", "v2f", &[0; 8]),
            attribute("screenWindowWidth", "float", &1f32.to_le_bytes()),
            attribute("type", "string", b"deepscanline"),
            attribute("version", "int", &int(1)),
            vec![0],
        ]
        .concat()
    };
    // A, B, G, R, Z of both samples.
    let data = [0.5f32, 1.0, 1.0, 0.0, 0.25, 0.0, 0.5, 0.0, 2.0, 4.0].map(f32::to_le_bytes).concat();
    let first = [int(0), long(4), long(40), long(40), int(2), data].concat();
    let second = [int(1), long(4), long(0), long(0), int(0)].concat();
    let file = |state: Vec<u8>| {
        let header = header(state);
        let begin = header.len() as u64 + 16;
        let table = [long(begin), long(begin + first.len() as u64)].concat();
        [header, table, first.clone(), second.clone()].concat()
    };
    let wanted = file(Vec::new());
    assert_eq!(bytes, wanted);
    let told = written(&DeepLayout { tells_state: true, ..layout([1, 2]) }, &lists, 1).0;
    assert_eq!(told, file(attribute("deepImageState", "deepImageState", &[3])));
    assert_eq!(counts, Written { samples: 2, longest: 2, bytes: wanted.len() as u64 });
    assert_eq!(layout([1, 2]).most_bytes(2).unwrap(), wanted.len() as u64);
}

/// Reads little-endian numbers.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take(&mut self, count: usize) -> Vec<u8> {
        let (first, rest) = self.0.split_at(count);
        self.0 = rest;
        first.to_vec()
    }

    fn int(&mut self) -> u32 {
        u32::from_le_bytes(self.take(4).try_into().unwrap())
    }

    fn long(&mut self) -> u64 {
        u64::from_le_bytes(self.take(8).try_into().unwrap())
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|byte| *byte == 0).unwrap();
        let text = String::from_utf8(self.take(end)).unwrap();
        self.take(1);
        text
    }
}

/// Undoes ZIPS, from OpenEXR's description: sums of what was inflated, less 128 each, and the two halves put between
/// one another.
fn unpacked(packed: &[u8], size: usize) -> Vec<u8> {
    if packed.len() == size {
        return packed.to_vec();
    }
    let mut inflated = Vec::new();
    ZlibDecoder::new(packed).read_to_end(&mut inflated).unwrap();
    assert_eq!(inflated.len(), size);
    for i in 1..size {
        inflated[i] = (i32::from(inflated[i - 1]) + i32::from(inflated[i]) - 128) as u8;
    }
    let (even, odd) = inflated.split_at(size.div_ceil(2));
    (0..size).map(|i| if i % 2 == 0 { even[i / 2] } else { odd[i / 2] }).collect()
}

/// The samples of a file, its state and its longest list.
fn decoded(file: &[u8], [width, height]: [usize; 2]) -> (Vec<Vec<Sample>>, u8, u32) {
    let mut bytes = Bytes(file);
    assert_eq!(bytes.long() as u32, 0x0131_2f76);
    let (mut channels, mut state, mut longest, mut last) = (Vec::new(), 0, 0, String::new());
    while bytes.0[0] != 0 {
        let (name, kind) = (bytes.text(), bytes.text());
        let size = bytes.int() as usize;
        let value = bytes.take(size);
        match kind.as_str() {
            "chlist" => {
                let mut list = Bytes(&value);
                while list.0[0] != 0 {
                    channels.push((list.text(), list.int()));
                    list.take(12);
                }
            }
            "deepImageState" => state = value[0],
            _ if name == "maxSamplesPerPixel" => longest = Bytes(&value).int(),
            _ => {}
        }
        assert!(last < name, "attributes are in order");
        last = name;
    }
    bytes.take(1);
    let table: Vec<u64> = (0..height).map(|_| bytes.long()).collect();
    let mut lists = Vec::new();
    for (y, at) in table.iter().enumerate() {
        let mut chunk = Bytes(&file[*at as usize..]);
        assert_eq!(chunk.int() as usize, y);
        let [packed_table, packed, size] = [chunk.long(), chunk.long(), chunk.long()].map(|n| n as usize);
        let counts = unpacked(&chunk.take(packed_table), 4 * width);
        let ends: Vec<usize> = counts.chunks(4).map(|end| Bytes(end).int() as usize).collect();
        let data = unpacked(&chunk.take(packed), size);
        let mut data = Bytes(&data);
        let count = ends[width - 1];
        let mut row = vec![Sample::default(); count];
        for (name, kind) in &channels {
            for sample in &mut row {
                let value = match kind {
                    1 => half::f16::from_le_bytes(data.take(2).try_into().unwrap()).to_f32(),
                    _ => f32::from_bits(data.int()),
                };
                match name.as_str() {
                    "R" => sample.rgba[0] = value,
                    "G" => sample.rgba[1] = value,
                    "B" => sample.rgba[2] = value,
                    "A" => sample.rgba[3] = value,
                    "Z" => (sample.depth, sample.back) = (value, value),
                    _ => sample.back = value,
                }
            }
        }
        assert!(data.0.is_empty());
        let starts = [&[0], &ends[..width - 1]].concat();
        lists.extend(starts.iter().zip(&ends).map(|(start, end)| row[*start..*end].to_vec()));
    }
    (lists, state, longest)
}

/// Lists of many lengths, with values that pack well and others that don't.
fn lists(count: usize, volumes: bool) -> Vec<Vec<Sample>> {
    let mut r = random(7);
    let mut each = |y: usize| {
        let noisy = y.is_multiple_of(3);
        let depth: f32 = r.random_range(1.0..9.0);
        let value = |r: &mut rand_pcg::Pcg64| if noisy { r.random() } else { 0.5 };
        let rgba = std::array::from_fn(|_| value(&mut r));
        Sample { rgba, depth, back: depth + if volumes { 1.0 } else { 0.0 } }
    };
    (0..count).map(|i| (0..(i * 7) % 23).map(|_| each(i / 20)).collect()).collect()
}

#[test]
fn written_deep_images_are_read_back() {
    let size = [20usize, 12];
    for volumes in [false, true] {
        let lists = lists(240, volumes);
        for packing in [Packing::Zips, Packing::Raw] {
            // No state is 0.
            for (state, tells_state, value) in
                [(State::Tidy, true, 3), (State::Sorted, true, 1), (State::Tidy, false, 0)]
            {
                let layout = DeepLayout { packing, state, tells_state, volumes, ..layout([20, 12]) };
                let (bytes, counts) = written(&layout, &lists, 240);
                assert_eq!(decoded(&bytes, size), (lists.clone(), value, 22));
                let samples = lists.iter().map(Vec::len).sum::<usize>() as u64;
                assert_eq!(counts, Written { samples, longest: 22, bytes: bytes.len() as u64 });
                let most = layout.most_bytes(samples).unwrap();
                assert!(
                    if packing == Packing::Raw { counts.bytes == most } else { counts.bytes < most },
                    "{counts:?} {most}"
                );
                for step in [1, 7, 20, 33] {
                    assert!(written(&layout, &lists, step).0 == bytes, "in parts of {step} pixels");
                }
            }
        }
    }
}

#[test]
fn half_is_the_nearest_and_keeps_depths() {
    let lists = lists(240, true);
    let layout = DeepLayout { numbers: Numbers::Half, packing: Packing::Zips, volumes: true, ..layout([20, 12]) };
    assert_eq!(layout.sample_bytes(), 16);
    let (bytes, _) = written(&layout, &lists, 240);
    let found = decoded(&bytes, [20, 12]).0;
    for (found, wanted) in found.iter().flatten().zip(lists.iter().flatten()) {
        assert_eq!((found.depth, found.back), (wanted.depth, wanted.back));
        for (found, wanted) in found.rgba.iter().zip(wanted.rgba) {
            // Half of the last of 11 bits, of numbers below 1; or of the smallest step.
            assert!((found - wanted).abs() <= wanted * 2f32.powi(-11) + 2f32.powi(-25), "{found} {wanted}");
        }
    }
}

#[test]
fn files_that_cannot_be_are_refused() {
    let begun = |layout: &DeepLayout| Writer::begin(Cursor::new(Vec::new()), layout).map(drop);
    let with = |metadata: &[(&str, &str)]| DeepLayout {
        metadata: metadata.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect(),
        ..layout([2, 2])
    };
    let long = "n".repeat(256);
    for metadata in
        [&[("", "a")][..], &[("a\0b", "c")], &[(&*long, "a")], &[("a", "b"), ("a", "c")], &[("channels", "a")]]
    {
        let error = begun(&with(metadata)).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput, "{metadata:?}");
        assert!(with(metadata).most_bytes(1).is_err());
    }
    // A name of more than 31 bytes needs a bit of the version.
    let mut bytes = Vec::new();
    Writer::begin(Cursor::new(&mut bytes), &with(&[("a name that is longer than 31 bytes", "ü")])).unwrap();
    assert_eq!(bytes[..8], [0x76, 0x2f, 0x31, 0x01, 0x02, 0x0c, 0x00, 0x00]);
    let layout = layout([2, 2]);
    let pushed = |lengths: &[u32], samples: usize| {
        let mut writer = Writer::begin(Cursor::new(Vec::new()), &layout).unwrap();
        writer.push(lengths, &vec![Sample::default(); samples]).and_then(|()| writer.finish())
    };
    assert!(pushed(&[1, 0, 0, 2], 3).is_ok());
    for (lengths, samples, reason) in [
        (&[1, 0, 0, 2][..], 2, "lengths"),
        (&[1, 0, 0], 1, "fewer pixels"),
        (&[0; 6], 0, "more pixels"),
        (&[0; 5], 0, "more pixels"),
        (&[u32::MAX, u32::MAX, 0, 0], 1, "lengths"),
    ] {
        let error = pushed(lengths, samples).unwrap_err();
        assert!(error.to_string().contains(reason), "{lengths:?}: {error}");
    }
    assert_eq!(layout.most_bytes(u64::MAX).unwrap(), u64::MAX, "no sum overflows");
}

/// Output without places to go back to, such as a pipe.
struct Pipe;

impl Write for Pipe {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

impl Seek for Pipe {
    fn seek(&mut self, _to: SeekFrom) -> std::io::Result<u64> {
        Err(ErrorKind::NotSeekable.into())
    }
}

#[test]
fn a_pipe_is_refused_at_once() {
    let error = Writer::begin(Pipe, &layout([1, 1])).map(drop).unwrap_err();
    assert!(error.to_string().contains("name a file"), "{error}");
}
