//! H.264 and VP9 by the program `ffmpeg`, which reads raw frames from a pipe.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

use super::FilmFormat;
use super::stills::{Stills, even};
use crate::commands::interrupt::{self, Helper};

/// Names the program, where it is not the one in PATH.
const VARIABLE: &str = "PELLUCID_FFMPEG";

/// Threads of the encoder. Their number shows in the bytes of a film, so it doesn't follow the machine's.
const THREADS: &str = "4";

/// Frames become limited BT.709, and are marked so at the end: from version 7.1 on, ffmpeg takes the marks of a film
/// from its frames, and `scale` sets the matrix and the range alone.
const FILTERS: &str = "scale=in_range=pc:out_range=tv:out_color_matrix=bt709:flags=bicubic+accurate_rnd+full_chroma_int+bitexact,\
    format=yuv420p,setparams=color_primaries=bt709:color_trc=bt709:colorspace=bt709:range=tv";

/// Lines of ffmpeg's that an error repeats.
const LINES: usize = 5;

/// Interval at which the program checks whether ffmpeg has ended.
const PAUSE: Duration = Duration::from_millis(10);

/// Reasons why a film was not encoded.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The program is not there.
    #[error(
        "{film}: the program ffmpeg encodes such films, and {program} can't be started ({source}); install it (Debian, Ubuntu: \
         apt install ffmpeg; Fedora: dnf install ffmpeg-free; macOS: brew install ffmpeg; Windows: winget install ffmpeg), name \
         it in {VARIABLE}, or give -o a .gif or .apng, which need no other program",
        film = film.display(), program = program.display()
    )]
    NoProgram { film: PathBuf, program: PathBuf, source: io::Error },
    /// The program is there, but was built without what is needed.
    #[error(
        "{film}: {program} has no encoder {encoder}; install an ffmpeg that has it, name it in {VARIABLE}, or give -o {others}",
        film = film.display(), program = program.display()
    )]
    NoEncoder { film: PathBuf, program: PathBuf, encoder: &'static str, others: &'static str },
    /// The program failed.
    #[error("{film}: {program} failed ({status}): {said}", film = film.display(), program = program.display())]
    Failed { film: PathBuf, program: PathBuf, status: String, said: String },
    /// A frame can't be read, or the pipe not be written.
    #[error("{film}: can't be encoded: {source}", film = film.display())]
    Frames { film: PathBuf, source: io::Error },
}

fn program() -> PathBuf {
    std::env::var_os(VARIABLE).filter(|name| !name.is_empty()).unwrap_or_else(|| OsString::from("ffmpeg")).into()
}

/// The encoder of a film, what to make instead where it is missing, and its settings.
fn coding(kind: FilmFormat) -> Option<(&'static str, &'static str, &'static [&'static str])> {
    match kind {
        FilmFormat::Mp4 => {
            Some(("libx264", "a .webm, .gif or .apng", &["-preset", "medium", "-crf", "18", "-movflags", "+faststart"]))
        }
        FilmFormat::Webm => Some((
            "libvpx-vp9",
            "an .mp4, .gif or .apng",
            &["-crf", "24", "-b:v", "0", "-deadline", "good", "-cpu-used", "2", "-row-mt", "1"],
        )),
        FilmFormat::Gif | FilmFormat::Apng => None,
    }
}

/// Looks for the program and for its encoder.
///
/// # Errors
/// The program or its encoder is missing.
pub fn check(film: &Path, kind: FilmFormat) -> Result<(), Error> {
    let Some((encoder, others, _)) = coding(kind) else { return Ok(()) };
    let (film, program) = (film.to_owned(), program());
    let listed = Command::new(&program).args(["-hide_banner", "-encoders"]).stdin(Stdio::null()).output();
    let listed = match listed {
        Ok(output) => String::from_utf8_lossy(&output.stdout).into_owned(),
        Err(source) => return Err(Error::NoProgram { film, program, source }),
    };
    match listed.lines().any(|line| line.split_whitespace().nth(1) == Some(encoder)) {
        true => Ok(()),
        false => Err(Error::NoEncoder { film, program, encoder, others }),
    }
}

/// A film to encode.
pub struct Encoding<'a> {
    /// File name of the film, for messages.
    pub film: &'a Path,
    pub kind: FilmFormat,
    /// Temporary file that ffmpeg writes.
    pub part: &'a Path,
    pub fps: u32,
    pub title: &'a str,
}

impl Encoding<'_> {
    /// Hands all frames to ffmpeg and waits for its end.
    ///
    /// # Errors
    /// An interruption, frames that can't be read, and failures of ffmpeg with its last lines.
    pub fn run(&self, stills: &Stills<'_>, step: &dyn Fn()) -> Result<(), Error> {
        let program = program();
        let mut command = self.command(&program, stills);
        #[cfg(unix)]
        {
            // Ctrl-C reaches this program alone, which then ends ffmpeg.
            std::os::unix::process::CommandExt::process_group(&mut command, 0);
        }
        let failed = |source: io::Error| Error::Frames { film: self.film.to_owned(), source };
        let mut child = command.spawn().map_err(failed)?;
        let (input, output) = (child.stdin.take(), child.stderr.take());
        let helper = Helper::keep(child);
        let said = output.map(|output| thread::spawn(move || last_lines(output)));
        let fed = input.map_or(Ok(()), |input| feed(input, stills, step));
        let ended = match &fed {
            // It has ended, and says why.
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => helper.wait(PAUSE),
            Err(_) => {
                helper.kill();
                helper.wait(PAUSE)
            }
            Ok(()) => helper.wait(PAUSE),
        };
        let ended = ended.map_err(failed)?;
        let said = said.and_then(|said| said.join().ok()).unwrap_or_default();
        match fed {
            Err(error) if error.kind() != io::ErrorKind::BrokenPipe => return Err(failed(error)),
            Ok(()) if ended.success() => return Ok(()),
            _ => {}
        }
        super::interrupted().map_err(failed)?;
        Err(Error::Failed { film: self.film.to_owned(), program, status: named(ended), said: said.join("; ") })
    }

    fn command(&self, program: &Path, stills: &Stills<'_>) -> Command {
        let [width, height] = stills.size().map(|side| side.next_multiple_of(2));
        let (encoder, _, settings) = coding(self.kind).unwrap_or(("libx264", "", &[]));
        let mut command = Command::new(program);
        command.args(["-hide_banner", "-nostdin", "-loglevel", "error", "-y"]);
        command.args(["-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", &format!("{width}x{height}")]);
        command.args(["-framerate", &self.fps.to_string(), "-i", "pipe:0"]);
        // The matrix of BT.709 on the way, and said in the file: players would guess by the size.
        command.args(["-vf", FILTERS]);
        command.args([
            "-colorspace",
            "bt709",
            "-color_primaries",
            "bt709",
            "-color_trc",
            "bt709",
            "-color_range",
            "tv",
        ]);
        command.args(["-c:v", encoder]).args(settings).args(["-threads", THREADS]);
        command.args(["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"]);
        command.args(["-metadata", &format!("title={}", self.title)]);
        // `file:` so that no name is taken for a protocol.
        let mut part = OsString::from("file:");
        part.push(self.part);
        command.arg(part);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }
}

fn feed(mut input: impl Write, stills: &Stills<'_>, step: &dyn Fn()) -> io::Result<()> {
    for still in stills.iter() {
        super::interrupted()?;
        input.write_all(&even(still?).bytes)?;
        step();
    }
    Ok(())
}

/// The last lines of a stream, read to its end, whatever is in it.
fn last_lines(stream: impl Read) -> Vec<String> {
    let mut lines = VecDeque::new();
    let mut stream = BufReader::new(stream);
    let mut line = Vec::new();
    // A line without an end is cut into pieces.
    while stream.by_ref().take(4096).read_until(b'\n', &mut line).is_ok_and(|length| length > 0) {
        let text = String::from_utf8_lossy(&line).trim().to_owned();
        line.clear();
        if !text.is_empty() {
            lines.push_back(text);
        }
        if lines.len() > LINES {
            lines.pop_front();
        }
    }
    lines.into()
}

fn named(status: ExitStatus) -> String {
    match status.code() {
        Some(code) => format!("status {code}"),
        None => status.to_string(),
    }
}

impl Helper {
    /// Waits for the end; an interruption by the user brings it about.
    fn wait(&self, pause: Duration) -> io::Result<ExitStatus> {
        loop {
            if let Some(status) = self.try_wait()? {
                return Ok(status);
            }
            if interrupt::asked() {
                self.kill();
            }
            thread::sleep(pause);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_reach_the_encoder_with_all_four_marks_of_bt709() {
        let last = FILTERS.rsplit_once(',').and_then(|(_, last)| last.strip_prefix("setparams="));
        let mut marks: Vec<&str> = last.unwrap_or_default().split(':').collect();
        marks.sort_unstable();
        assert_eq!(marks, ["color_primaries=bt709", "color_trc=bt709", "colorspace=bt709", "range=tv"]);
        assert!(!FILTERS.contains(' '), "the line break of the source is none of the filter's");
    }

    #[test]
    fn only_the_last_lines_are_kept() {
        let text: String = (0..9).map(|number| format!("line {number}\n\n")).collect();
        assert_eq!(last_lines(text.as_bytes()), ["line 4", "line 5", "line 6", "line 7", "line 8"]);
        assert_eq!(last_lines(&b"\xff cut"[..]), ["\u{fffd} cut"]);
        assert_eq!(last_lines(vec![b'a'; 40_000].as_slice()).len(), LINES);
    }
}
