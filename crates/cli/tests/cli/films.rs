//! `render -o turn.mp4`, `.webm`, `.gif`, `.apng`: what is in the files, how they go on after an interruption, and what
//! is refused.

use std::collections::HashSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use gif::{ColorOutput, DecodeOptions};
use pellucid_testing::shader_cache;
use pellucid_testing::skip::{NO_PROGRAM, skip};
use tempfile::TempDir;

use super::sequence::{garden, said, written};
use crate::{assert_refused, done, has_device, inside, run};

/// Frames of each film, and their size.
const COUNT: usize = 6;
const SIZE: [u32; 2] = [96, 64];

/// The arguments of a film of the garden.
fn film<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let turn =
        ["--method", "circles", "--size", "96x64", "--turntable", "--frames", "6", "--background", "0.2,0.3,0.4"];
    [&["render", "garden/scene.toml"], &turn[..], more].concat()
}

/// True if films can be encoded here, or must be.
pub fn has_ffmpeg() -> bool {
    let found = ["ffmpeg", "ffprobe"].iter().all(|name| Command::new(name).arg("-version").output().is_ok());
    if !found {
        skip(NO_PROGRAM, "ffmpeg and ffprobe");
    }
    found
}

/// Returns the answer of ffprobe about a film's frames.
fn probe(file: &Path, entries: &str) -> String {
    let probe = Command::new("ffprobe")
        .args([
            "-v",
            "error",
            "-count_frames",
            "-select_streams",
            "v:0",
            "-show_entries",
            entries,
            "-of",
            "default=nw=1",
        ])
        .arg(file)
        .output()
        .unwrap();
    assert!(probe.status.success() && probe.stderr.is_empty(), "{}", String::from_utf8_lossy(&probe.stderr));
    String::from_utf8(probe.stdout).unwrap()
}

/// R, G and B of the pixels of all frames, decoded by ffmpeg.
fn decoded(file: &Path, size: [u32; 2]) -> Vec<Vec<u8>> {
    let args = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-sws_flags", "accurate_rnd+full_chroma_int", "-"];
    let output = Command::new("ffmpeg").args(["-v", "error", "-i"]).arg(file).args(args).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout.chunks((3 * size[0] * size[1]) as usize).map(<[u8]>::to_vec).collect()
}

/// The pixels of an 8-bit PNG and its number of channels.
fn pixels(file: &Path) -> (Vec<u8>, usize) {
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(file).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    (bytes, info.color_type.samples())
}

/// The mean of how far bytes are apart.
fn apart(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let sum: u64 = a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

/// Frames of a folder as numbered pictures, for comparison.
fn numbered(folder: &TempDir) -> Vec<Vec<u8>> {
    done(folder, &film(&["-o", "f_%d.png"]));
    (0..COUNT).map(|number| pixels(&inside(folder, &format!("f_{number}.png"))).0).collect()
}

/// Asserts that each frame is nearer to its picture than `bound` and far nearer than to any other.
fn assert_same(frames: &[Vec<u8>], pictures: &[Vec<u8>], bound: f64) {
    assert_eq!(frames.len(), pictures.len());
    for (number, frame) in frames.iter().enumerate() {
        let own = apart(frame, &pictures[number]);
        let others = (0..pictures.len()).filter(|other| *other != number).map(|other| apart(frame, &pictures[other]));
        let nearest = others.fold(f64::INFINITY, f64::min);
        assert!(own < bound && nearest > 2.0 * own, "frame {number}: {own} from its picture, {nearest} from another");
    }
}

fn names(folder: &TempDir) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn ffmpeg_films_have_all_frames_and_their_colors() {
    if !has_device() || !has_ffmpeg() {
        return;
    }
    let folder = garden();
    let before = names(&folder);
    let entries = "stream=codec_name,pix_fmt,width,height,r_frame_rate,nb_read_frames,color_space,color_transfer,color_primaries,color_range";
    for (name, codec) in [("turn.mp4", "h264"), ("turn.webm", "vp9")] {
        done(&folder, &film(&["-o", name, "--fps", "12"]));
        let probed = probe(&inside(&folder, name), entries);
        for line in [
            &format!("codec_name={codec}"),
            "pix_fmt=yuv420p",
            "width=96",
            "height=64",
            "r_frame_rate=12/1",
            "nb_read_frames=6",
            "color_space=bt709",
            "color_transfer=bt709",
            "color_primaries=bt709",
            "color_range=tv",
        ] {
            assert!(probed.lines().any(|found| found == line), "{name}: {line} in {probed}");
        }
    }
    // Nothing stays beside the films.
    let after = [before, vec!["turn.mp4".to_owned(), "turn.webm".to_owned()]].concat();
    assert_eq!(names(&folder).into_iter().collect::<HashSet<_>>(), after.into_iter().collect());
    // The index stands before the frames, so that a film starts while it is loaded.
    let bytes = fs::read(inside(&folder, "turn.mp4")).unwrap();
    let place = |name: &[u8]| bytes.windows(4).position(|window| window == name).unwrap();
    assert!(place(b"moov") < place(b"mdat"));
    // The same command, the same bytes.
    fs::rename(inside(&folder, "turn.mp4"), inside(&folder, "first.mp4")).unwrap();
    done(&folder, &film(&["-o", "turn.mp4", "--fps", "12"]));
    assert!(fs::read(inside(&folder, "turn.mp4")).unwrap() == bytes);
    // Chroma has half the size, which single pixels of the scene's few points show: its mean error is some steps of
    // 255.
    let pictures = numbered(&folder);
    for name in ["turn.mp4", "turn.webm"] {
        let frames = decoded(&inside(&folder, name), SIZE);
        assert_same(&frames, &pictures, 6.0);
        // The background has no edge near the corner: there only roundings to limited range are left.
        for (frame, picture) in frames.iter().zip(&pictures) {
            assert!(
                frame[..3].iter().zip(&picture[..3]).all(|(a, b)| a.abs_diff(*b) <= 3),
                "{name}: {:?}",
                &frame[..3]
            );
        }
    }
}

#[test]
fn an_odd_size_is_made_even_and_said() {
    if !has_device() || !has_ffmpeg() {
        return;
    }
    let folder = garden();
    let args = ["--size", "95x63", "-o", "turn.mp4", "--turntable", "--frames", "3", "--method", "circles"];
    let text = said(&folder, &[&["render", "garden/scene.toml"], &args[..]].concat());
    assert!(text.contains("turn.mp4: 95 × 63 pixels become 96 × 64"), "{text}");
    let probed = probe(&inside(&folder, "turn.mp4"), "stream=width,height,nb_read_frames");
    assert_eq!(probed.lines().collect::<Vec<_>>(), ["width=96", "height=64", "nb_read_frames=3"]);
    let frame = &decoded(&inside(&folder, "turn.mp4"), [96, 64])[0];
    done(&folder, &[&["render", "garden/scene.toml"], &args[..2], &["-o", "f_%d.png"], &args[4..]].concat());
    let picture = pixels(&inside(&folder, "f_0.png")).0;
    let rows = frame.chunks_exact(96 * 3).zip(picture.chunks_exact(95 * 3));
    let kept: (Vec<u8>, Vec<u8>) = rows.fold(Default::default(), |(mut a, mut b), (frame, picture)| {
        a.extend_from_slice(&frame[..95 * 3]);
        b.extend_from_slice(picture);
        (a, b)
    });
    // Not scaled: pixels are where they were.
    let other = pixels(&inside(&folder, "f_1.png")).0;
    let (own, next) = (apart(&kept.0, &kept.1), apart(&kept.0, &other));
    assert!(own < 6.0 && next > 2.0 * own, "{own}, {next}");
}

#[test]
fn an_apng_has_every_bit_and_transparency() {
    if !has_device() {
        return;
    }
    let folder = garden();
    for (more, channels) in [(&[][..], 3), (&["--transparent"], 4)] {
        done(&folder, &film(&[&["-o", "turn.apng", "--fps", "30"], more].concat()));
        done(&folder, &film(&[&["-o", "f_%d.png", "--overwrite"], more].concat()));
        let mut decoder =
            png::Decoder::new(std::io::BufReader::new(fs::File::open(inside(&folder, "turn.apng")).unwrap()));
        decoder.set_transformations(png::Transformations::IDENTITY);
        let mut reader = decoder.read_info().unwrap();
        let control = reader.info().animation_control().copied().unwrap();
        assert_eq!((control.num_frames, control.num_plays), (COUNT as u32, 0), "a turn goes on for ever");
        assert!(reader.info().uncompressed_latin1_text.iter().any(|text| text.keyword == "pellucid:method"));
        let mut shown = HashSet::new();
        for number in 0..COUNT {
            let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
            let info = reader.next_frame(&mut bytes).unwrap();
            let delay = reader.info().frame_control().unwrap();
            assert_eq!((delay.delay_num, delay.delay_den, info.color_type.samples()), (1, 30, channels));
            assert!(bytes == pixels(&inside(&folder, &format!("f_{number}.png"))).0, "frame {number}");
            shown.insert(bytes);
        }
        assert_eq!(shown.len(), COUNT, "the camera moves");
    }
}

/// The pixels of all frames of a GIF, how long each is shown in hundredths of a second, and how often all of them.
fn read_gif(file: &Path, size: [u32; 2]) -> (Vec<Vec<u8>>, Vec<u16>, gif::Repeat) {
    let mut options = DecodeOptions::new();
    options.set_color_output(ColorOutput::Indexed);
    let mut decoder = options.read_info(fs::File::open(file).unwrap()).unwrap();
    let palette = decoder.global_palette().unwrap().to_vec();
    let mut canvas = vec![0; (3 * size[0] * size[1]) as usize];
    let (mut frames, mut delays) = (Vec::new(), Vec::new());
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert!(frame.palette.is_none() && frame.transparent.is_none(), "one palette for all");
        delays.push(frame.delay);
        for (at, index) in frame.buffer.iter().enumerate() {
            let (x, y) = (at % usize::from(frame.width), at / usize::from(frame.width));
            let place = 3 * ((y + usize::from(frame.top)) * size[0] as usize + x + usize::from(frame.left));
            canvas[place..place + 3].copy_from_slice(&palette[3 * usize::from(*index)..][..3]);
        }
        frames.push(canvas.clone());
    }
    (frames, delays, decoder.repeat())
}

#[test]
fn small_things_keep_their_colors_in_a_gif() {
    if !has_device() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let size = [65, 49];
    let scene = "[image]\nsize = [65, 49]\nbackground = [0.0, 0.0, 0.0]\n[[cloud]]\npath = \"two.ply\"\n";
    fs::write(inside(&folder, "two.toml"), scene).unwrap();
    // A large splat, whose shades are more than 256, and a small one before it.
    for (large, small) in
        [([0.9, 0.2, 0.3], [0.1, 0.8, 0.2]), ([0.3, 0.4, 0.9], [0.95, 0.9, 0.0]), ([1.0, 1.0, 0.6], [0.1, 0.2, 0.9])]
    {
        let line = |place: &str, color: [f64; 3], scale: f64| {
            let [r, g, b] = color.map(|value| (value - 0.5) / 0.28209479177387814);
            let scale = scale.ln();
            format!("{place} {r} {g} {b} 4.6 {scale} {scale} {scale} 1 0 0 0\n")
        };
        let names = "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";
        let properties: String = names.split(' ').map(|name| format!("property float {name}\n")).collect();
        let lines = line("0 0 0", large, 3.0) + &line("0.5 0 0", small, 0.2);
        let file = format!("ply\nformat ascii 1.0\nelement vertex 2\n{properties}end_header\n{lines}");
        fs::write(inside(&folder, "two.ply"), file).unwrap();
        let film =
            |name| done(&folder, &["render", "two.toml", "--turntable", "--frames", "4", "--overwrite", "-o", name]);
        film("two.gif");
        film("f_%d.png");
        let frames = read_gif(&inside(&folder, "two.gif"), size).0;
        let mut colors = HashSet::new();
        let mut worst = (0.0, [0; 3], [0; 3]);
        for (number, frame) in frames.iter().enumerate() {
            let picture = pixels(&inside(&folder, &format!("f_{number}.png"))).0;
            for (shown, wanted) in frame.chunks_exact(3).zip(picture.chunks_exact(3)) {
                let square = |channel: usize| f64::from(shown[channel].abs_diff(wanted[channel])).powi(2);
                let apart = ((2.0 * square(0) + 4.0 * square(1) + square(2)) / 7.0).sqrt();
                if apart > worst.0 {
                    worst = (apart, [wanted[0], wanted[1], wanted[2]], [shown[0], shown[1], shown[2]]);
                }
                colors.insert(wanted.to_vec());
            }
        }
        assert!(colors.len() > 256 && frames.len() == 4, "{} colors: the palette must not be exact", colors.len());
        // 16 levels to the color of a palette, 4 to the mean of a cube of 8, 6 for dithering.
        assert!(worst.0 <= 26.0, "{worst:?}");
    }
}

#[test]
fn a_gif_is_near_to_the_pictures_and_its_background_rests() {
    if !has_device() {
        return;
    }
    let folder = garden();
    done(&folder, &film(&["-o", "turn.gif", "--fps", "30"]));
    let pictures = numbered(&folder);
    let read = |name: &str| read_gif(&inside(&folder, name), SIZE);
    let (frames, delays, repeat) = read("turn.gif");
    assert_eq!((delays.as_slice(), repeat), (&[3, 4, 3, 3, 4, 3][..], gif::Repeat::Infinite));
    // A step of dithering is 6 of 255 at most, and half of that in the mean; the palette is about as far off where it
    // is not exact.
    assert_same(&frames, &pictures, 5.0);
    // Pixels of the background have exactly its color in each frame.
    let background = &pictures[0][..3];
    let mut rests = 0;
    for (frame, picture) in frames.iter().zip(&pictures) {
        for (shown, wanted) in
            frame.chunks_exact(3).zip(picture.chunks_exact(3)).filter(|(_, wanted)| *wanted == background)
        {
            assert_eq!(shown, wanted);
            rests += 1;
        }
    }
    assert!(rests > 1000, "{rests} pixels");
    // A path with an end plays once.
    let args = ["--path", "path.json", "--frames", "3", "--method", "circles", "--size", "96x64", "-o", "path.gif"];
    done(&folder, &[&["render", "garden/scene.toml"], &args[..]].concat());
    assert_eq!(read("path.gif").2, gif::Repeat::Finite(0));
    assert_eq!(read("path.gif").1, [4, 4, 4]);
}

#[test]
fn a_film_goes_on_from_the_frames_that_are_there() {
    if !has_device() || !has_ffmpeg() {
        return;
    }
    let folder = garden();
    // An ffmpeg that says that it has the encoder, and then fails.
    let broken = inside(&folder, "broken");
    fs::write(&broken, "#!/bin/sh\ncase $* in *-encoders*) echo ' V....D libx264 x';; *) echo one >&2; echo 'no space left' >&2; exit 3;; esac\n")
        .unwrap();
    Command::new("chmod").arg("+x").arg(&broken).status().unwrap();
    let args = film(&["-o", "turn.mp4", "-v"]);
    let output = crate::pellucid(&folder, &args).env("PELLUCID_FFMPEG", &broken).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), written(&stderr)), (Some(1), COUNT), "{stderr}");
    assert!(
        stderr.contains("error: turn.mp4: ") && stderr.contains("failed (status 3): one; no space left"),
        "{stderr}"
    );
    assert!(!inside(&folder, "turn.mp4").exists() && inside(&folder, "turn.mp4.frames/frame_0005.png").exists());
    // Other settings are not mixed in.
    let other = film(&["-o", "turn.mp4", "--seed", "3"]);
    let (status, _, stderr) = run(&folder, &other);
    assert!(status == 1 && stderr.contains("turn.mp4.frames/frame_0000.png: this file is not a frame"), "{stderr}");
    assert!(stderr.contains("--overwrite"), "{stderr}");
    // One is missing, and only that is rendered. What a killed run left goes too.
    fs::remove_file(inside(&folder, "turn.mp4.frames/frame_0003.png")).unwrap();
    fs::write(inside(&folder, "turn.mp4.frames/.pellucid-abcdef.tmp"), "half").unwrap();
    let again = said(&folder, &args);
    assert!(again.contains("5 of 6 frames were there already, 1 were rendered"), "{again}");
    assert!(
        again.contains("turn.mp4.frames/frame_0003.png: written") && !again.contains("frame_0002.png: written"),
        "{again}"
    );
    assert!(inside(&folder, "turn.mp4").exists() && !inside(&folder, "turn.mp4.frames").exists());
    let probed = probe(&inside(&folder, "turn.mp4"), "stream=nb_read_frames");
    assert_eq!(probed.trim(), "nb_read_frames=6");
}

#[cfg(unix)]
#[test]
fn an_interruption_ends_ffmpeg_and_leaves_no_half_film() {
    use std::process::Stdio;
    use std::time::Duration;

    use pellucid_testing::signals::heeding;

    if !has_device() || !has_ffmpeg() {
        return;
    }
    let folder = garden();
    // It takes the frames, writes something and never ends.
    let slow = inside(&folder, "slow");
    let script = "#!/bin/sh\ncase $* in *-encoders*) echo ' V....D libx264 x'; exit;; esac\necho $$ >pid\nfor last; do :; done\n\
                  echo half >\"${last#file:}\"\ncat >/dev/null\nexec sleep 1000\n";
    fs::write(&slow, script).unwrap();
    Command::new("chmod").arg("+x").arg(&slow).status().unwrap();
    for (signal, code) in [("-INT", Some(130)), ("-TERM", None)] {
        let mut command = heeding(assert_cmd::cargo::cargo_bin("pellucid"));
        command.current_dir(&folder).env("PELLUCID_CACHE_DIR", shader_cache()).env("PELLUCID_FFMPEG", &slow);
        command.args(film(&["-o", "turn.mp4"])).stdout(Stdio::null()).stderr(Stdio::null());
        if let Some(device) = crate::device() {
            command.args(["--device", &device]);
        }
        let mut child = command.spawn().unwrap();
        let part = inside(&folder, "turn.mp4.frames/film.mp4");
        while !part.exists() {
            assert!(child.try_wait().unwrap().is_none(), "it ended before it was to be interrupted");
            std::thread::sleep(Duration::from_millis(5));
        }
        Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap();
        assert_eq!(child.wait().unwrap().code(), code, "{signal}");
        assert!(!inside(&folder, "turn.mp4").exists());
        assert!(inside(&folder, "turn.mp4.frames/frame_0005.png").exists(), "frames stay");
        let encoder = fs::read_to_string(inside(&folder, "pid")).unwrap();
        let runs = || {
            let state = fs::read_to_string(format!("/proc/{}/status", encoder.trim())).unwrap_or_default();
            !state.is_empty() && !state.contains("State:\tZ")
        };
        // After SIGTERM nobody waits for it, so that it may take a moment.
        (0..1000).take_while(|_| runs()).for_each(|_| std::thread::sleep(Duration::from_millis(5)));
        assert!(!runs(), "{signal}: ffmpeg goes on");
        fs::remove_file(inside(&folder, "pid")).unwrap();
        let _ = fs::remove_file(&part);
    }
    let again = said(&folder, &film(&["-o", "turn.mp4"]));
    assert!(again.contains("6 of 6 frames were there already, 0 were rendered"), "{again}");
    assert!(inside(&folder, "turn.mp4").exists() && !inside(&folder, "turn.mp4.frames").exists());
}

#[cfg(unix)]
#[test]
fn a_kill_at_any_file_leaves_no_half_film_and_no_frame_is_rendered_twice() {
    if !has_device() {
        return;
    }
    let args = film(&["-o", "turn.gif", "--html", "turn.html"]);
    let whole = garden();
    done(&whole, &args);
    let read = |folder: &TempDir| ["turn.gif", "turn.html"].map(|name| fs::read(inside(folder, name)).ok());
    let wanted = read(&whole);
    // Six frames get their names, then the film and the page.
    for file in [1, 4, 7, 8] {
        let folder = garden();
        let fault = format!("kill@output/rename:{file}");
        let killed = crate::pellucid(&folder, &args).env("PELLUCID_FAULT", fault).output().unwrap();
        assert_eq!(killed.status.code(), None, "{file}: {}", String::from_utf8_lossy(&killed.stderr));
        let left = read(&folder);
        assert!(left.iter().zip(&wanted).all(|(left, wanted)| left.is_none() || left == wanted), "{file}");
        let there =
            (0..COUNT).filter(|number| inside(&folder, &format!("turn.gif.frames/frame_{number:04}.png")).exists());
        let (there, text) = (there.count(), said(&folder, &args));
        assert_eq!(there, COUNT.min(file - 1), "{file}");
        let already = format!("{there} of 6 frames were there already, {} were rendered", COUNT - there);
        assert!(there == 0 || text.contains(&already), "{file}: {text}");
        assert!(read(&folder) == wanted && !inside(&folder, "turn.gif.frames").exists(), "{file}");
    }
}

#[test]
fn a_missing_ffmpeg_or_encoder_is_reported_before_anything_is_read() {
    let folder = crate::folder();
    // The input is missing too: the encoder is looked for first.
    let args = ["render", "no.ply", "--turntable", "--frames", "4", "-o", "turn.mp4"];
    let with = |program: &Path| {
        let output = crate::pellucid(&folder, &args).env("PELLUCID_FFMPEG", program).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (status, stderr) = with(Path::new("/nowhere/ffmpeg"));
    assert_eq!(status, Some(1));
    for part in ["turn.mp4: ", "/nowhere/ffmpeg", "apt install ffmpeg", "PELLUCID_FFMPEG", ".gif or .apng"] {
        assert!(stderr.contains(part), "{part} in {stderr}");
    }
    // A program that knows no encoder.
    let (status, stderr) = with(Path::new("true"));
    assert!(status == Some(1) && stderr.contains("true has no encoder libx264"), "{stderr}");
    assert!(names(&folder).is_empty());
}

#[test]
fn options_that_do_not_fit_a_film_are_refused() {
    let folder = crate::folder();
    let refused = |args: &[&str], says: &[&str]| assert_refused(&folder, &[&["render"], args].concat(), 2, says);
    for name in ["turn.mp4", "turn.webm", "turn.gif", "turn.apng", "turn.mkv"] {
        refused(&["-o", name], &[name, "--turntable or --path"]);
        refused(&["-o", name, "--frames"], &[name, "--turntable or --path"]);
    }
    refused(&["--html", "a.html"], &["--html", "--turntable or --path"]);
    refused(&["--fps", "30"], &["--fps needs a film"]);
    let turn = ["--turntable", "--frames", "4"];
    let film = |more: &[&'static str], says: &[&str]| refused(&[&turn[..], more].concat(), says);
    film(&["--fps", "30"], &["--fps needs a film"]);
    film(&["-o", "turn.mkv"], &["turn.mkv", ".mp4 (H.264), .webm (VP9), .gif or .apng"]);
    film(&["-o", "turn.gif", "--fps", "60"], &["at most 50 frames"]);
    film(&["-o", "turn.gif", "--aov"], &["--aov", "frame_%04d.exr"]);
    film(&["-o", "turn.gif", "--deep"], &["--deep"]);
    for name in ["turn.gif", "turn.mp4", "turn.webm"] {
        film(&["-o", name, "--transparent"], &[name, "only an .apng"]);
    }
    film(&["--html", "a.html", "--transparent"], &["--html", "--transparent"]);
    film(&["--html", "a.html", "-o", "f_%d.exr"], &["--html", ".png"]);
    let missing = |more: &[&'static str], says: &[&str]| {
        assert_refused(&folder, &[&["render"], &turn[..], more].concat(), 1, says);
    };
    missing(&["-o", "none/turn.gif"], &["none/turn.gif: no folder none"]);
    missing(&["--html", "none/a.html"], &["none/a.html: no folder none"]);
    fs::write(inside(&folder, "turn.gif.frames"), "").unwrap();
    missing(&["-o", "turn.gif"], &["turn.gif.frames", "is a file and not a folder"]);
}
