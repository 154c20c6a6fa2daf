//! `render -o turn.mp4` and `--html`: a film, an animation or a page of the frames of a path.
//!
//! Frames are rendered as PNG files first, in a folder beside the film, so that an interrupted run goes on from them.

mod animation;
mod ffmpeg;
mod gif;
mod page;
mod palette;
mod stills;

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use pellucid_core::atomic::Writer;
use pellucid_engine::Result;
use pellucid_io::output::{self, Files, Output};

use super::bar::Bar;
use super::console::Console;
use super::frames::{Naming, Pattern};
use super::headings::FRAMES;
use super::limit::usage;
use super::options::refuse;
use super::render::RenderArgs;
use super::{Error as CommandError, interrupt};
pub use ffmpeg::Error;
pub use page::Caption;
use stills::Stills;

/// Frames of a second, unless `--fps` says otherwise.
const FPS: u32 = 25;

/// A browser shows a frame of a GIF for a tenth of a second if it is to be shown for less than two hundredths.
const MAX_GIF_FPS: u32 = 50;

/// File that ffmpeg writes in the folder of the frames, before the film gets its name.
const PARTS: [&str; 2] = ["film.mp4", "film.webm"];

/// Film and page that the frames become.
#[derive(Debug, Args)]
pub struct FilmArgs {
    /// With --path or --turntable: write a page that turns the scene in any browser.
    ///
    /// Mouse, finger, keys and a slider turn it. The page holds all frames and loads nothing else. Without -o only the
    /// page is written.
    #[arg(long, value_name = "PAGE.html", help_heading = FRAMES)]
    html: Option<PathBuf>,
    /// Frames per second of a film, an animation or a page; by default 25.
    #[arg(long, value_name = "N", help_heading = FRAMES, value_parser = clap::value_parser!(u32).range(1..=240))]
    fps: Option<u32>,
}

/// The container and coding of a film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FilmFormat {
    Mp4,
    Webm,
    Gif,
    Apng,
}

impl FilmFormat {
    /// Returns the kind that belongs to the extension, if it is that of a film.
    fn of(path: &Path) -> Option<Self> {
        Some(match extension(path)?.as_str() {
            "mp4" => Self::Mp4,
            "webm" => Self::Webm,
            "gif" => Self::Gif,
            "apng" => Self::Apng,
            _ => return None,
        })
    }
}

fn extension(path: &Path) -> Option<String> {
    Some(path.extension()?.to_str()?.to_lowercase())
}

/// Refuses the name of a film with a number in it, as numbered frames have.
fn refuse_number(path: &Path) -> Result<()> {
    if Pattern::parse(path, Naming::Frames).is_err() {
        return Ok(());
    }
    let path = path.display();
    Err(usage(format!("-o {path}: a film is one file, without a number in its name; numbered frames are .png or .exr")))
}

/// True if somebody who gives this name expects a film.
fn names_film(path: &Path) -> bool {
    let others = ["mkv", "mov", "avi", "m4v", "ogv"];
    FilmFormat::of(path).is_some() || extension(path).is_some_and(|extension| others.contains(&extension.as_str()))
}

/// Film and page that the frames of a path become; both may be missing.
#[derive(Debug, Default)]
pub struct Films {
    film: Option<(PathBuf, FilmFormat)>,
    page: Option<PathBuf>,
    fps: u32,
    /// The folder of the frames, if they go once everything is made of them.
    folder: Option<PathBuf>,
}

impl FilmArgs {
    /// Refuses films and their options where the camera doesn't move.
    pub fn refuse(&self, output: Option<&Path>) -> Result<()> {
        if let Some(output) = output.filter(|output| names_film(output)) {
            refuse_number(output)?;
            let output = output.display();
            return Err(usage(format!("-o {output}: a film needs a camera that moves: --turntable or --path")));
        }
        match (&self.html, self.fps) {
            (Some(_), _) => Err(usage("--html needs a camera that moves: --turntable or --path")),
            (None, Some(_)) => Err(usage("--fps needs a film, as in --turntable --frames 72 -o turn.mp4")),
            (None, None) => Ok(()),
        }
    }

    /// Returns the film and the page that the options request.
    pub fn films(&self, args: &RenderArgs) -> Result<Films> {
        let film = args.output.as_ref().filter(|output| names_film(output));
        let film = film.map(|path| known_kind(path).map(|kind| (path.clone(), kind))).transpose()?;
        if self.fps.is_some() && film.is_none() && self.html.is_none() {
            return Err(usage(
                "--fps needs a film (-o turn.mp4, .webm, .gif or .apng) or --html; numbered frames have no pace",
            ));
        }
        let fps = self.fps.unwrap_or(FPS);
        let first = film.as_ref().map(|(path, _)| path).or(self.html.as_ref());
        if let Some(first) = first {
            check_options(first, film.as_ref().map(|(_, kind)| *kind), self.html.is_some(), fps, args)?;
        }
        let kept = first.filter(|_| film.is_some() || args.output.is_none());
        let folder = kept.map(|path| {
            let mut name = path.as_os_str().to_owned();
            name.push(".frames");
            PathBuf::from(name)
        });
        Ok(Films { film, page: self.html.clone(), fps, folder })
    }
}

fn known_kind(path: &Path) -> Result<FilmFormat> {
    refuse_number(path)?;
    FilmFormat::of(path).ok_or_else(|| {
        let path = path.display();
        usage(format!(
            "-o {path}: films are .mp4 (H.264), .webm (VP9), .gif or .apng; frame_%04d.png makes numbered frames for another program"
        ))
    })
}

/// Refuses options that would have no effect on a film or a page.
fn check_options(first: &Path, kind: Option<FilmFormat>, page: bool, fps: u32, args: &RenderArgs) -> Result<()> {
    let path = first.display();
    let keeps_alpha = kind.is_none_or(|kind| kind == FilmFormat::Apng);
    let is_exr = |output: &PathBuf| extension(output).is_some_and(|extension| extension == "exr");
    refuse([
        (
            args.aov,
            format!("{path}: --aov adds channels to .exr files, and films and pages have none; give -o frame_%04d.exr"),
        ),
        (args.deep.format().is_some(), format!("{path}: --deep writes one .exr, and not a film or a page")),
        (
            args.transparent && page,
            "--html: its pictures are JPEGs, which can't be transparent; leave out --transparent".to_owned(),
        ),
        (args.transparent && !keeps_alpha, format!("{path}: only an .apng keeps --transparent, of the films")),
        (
            kind == Some(FilmFormat::Gif) && fps > MAX_GIF_FPS,
            format!(
                "{path}: browsers show at most {MAX_GIF_FPS} frames of a GIF in a second; give a smaller --fps, or make an .apng"
            ),
        ),
        (
            page && args.output.as_ref().is_some_and(is_exr),
            "--html is made of .png frames; give -o frame_%04d.png, or no -o".to_owned(),
        ),
    ])
}

impl Films {
    /// True if only frames are wanted.
    pub fn is_none(&self) -> bool {
        self.film.is_none() && self.page.is_none()
    }

    /// True if frames are in a folder of their own, which goes when they do.
    pub fn has_folder(&self) -> bool {
        self.folder.is_some()
    }

    /// The names of the frames, if they are not what `-o` names.
    pub fn pattern(&self) -> Result<Option<Pattern>> {
        let pattern = |folder: &PathBuf| Pattern::parse(&folder.join("frame_%04d.png"), Naming::Frames);
        self.folder.as_ref().map(pattern).transpose()
    }

    /// The film and the page, as outputs.
    pub fn outputs(&self) -> impl Iterator<Item = Output> {
        let film = self.film.iter().map(|(path, _)| Output::file("-o", path));
        film.chain(self.page.iter().map(|path| Output::file("--html", path)))
    }

    /// Refuses files that could not be written in the end.
    pub fn check_targets(&self) -> Result<()> {
        let films = self.film.iter().map(|(path, _)| path);
        films.chain(&self.page).try_for_each(|path| output::check_folder(path))?;
        self.folder.iter().try_for_each(|folder| output::check_report_folder(folder))?;
        Ok(())
    }

    /// Refuses a film that this machine can't encode.
    ///
    /// # Errors
    /// No ffmpeg, or one without the encoder.
    pub fn check_tools(&self) -> Result<(), Error> {
        self.film.as_ref().map_or(Ok(()), |(path, kind)| ffmpeg::check(path, *kind))
    }

    /// Makes the folder of the frames. If it stays empty, dropping the result removes it.
    pub fn make_folder(&self) -> Result<Option<pellucid_core::atomic::NewFolder>> {
        Ok(self.folder.as_ref().map(|folder| output::make_folder(folder)).transpose()?)
    }

    /// Makes everything of the frames, and removes those that nobody asked for. False if the user interrupted it.
    ///
    /// # Errors
    /// Frames that can't be read, files that can't be written, and a failure of ffmpeg.
    pub fn make(&self, files: &[PathBuf], caption: &Caption, console: Console) -> Result<bool, CommandError> {
        let stills = Stills::open(files)?;
        let mut made = Files::default();
        let done = self
            .film(&mut made, &stills, caption, console)
            .and_then(|()| self.page(&mut made, &stills, caption, console));
        match done {
            Err(_) if interrupt::asked() => return Ok(false),
            done => done?,
        }
        made.publish()?;
        for path in self.film.iter().map(|(path, _)| path).chain(&self.page) {
            let bytes = fs::metadata(path).map_or(0, |found| found.len());
            let (count, size) = (files.len(), bytesize::ByteSize(bytes));
            console.detail(format_args!("{}: written, {count} frames, {size}", path.display()));
        }
        if let Some(folder) = &self.folder {
            remove_frames(folder, files, console);
        }
        Ok(true)
    }

    fn film(&self, made: &mut Files, stills: &Stills, caption: &Caption, console: Console) -> Result<(), CommandError> {
        let Some((path, kind)) = &self.film else { return Ok(()) };
        let progress = making(path, stills, console);
        let step = || progress.inc(1);
        match kind {
            FilmFormat::Mp4 | FilmFormat::Webm => {
                self.encode(made, (path, *kind), stills, caption, (console, &step))?;
            }
            FilmFormat::Gif => made.add(path, |out| gif::write(out, stills, self.fps, caption.closed, &step))?,
            FilmFormat::Apng => made.add(path, |out| animation::write(out, stills, self.fps, caption, &step))?,
        }
        progress.finish_and_clear();
        Ok(())
    }

    /// Has ffmpeg encode a film.
    fn encode(
        &self,
        made: &mut Files,
        (path, kind): (&Path, FilmFormat),
        stills: &Stills,
        caption: &Caption,
        (console, step): (Console, &dyn Fn()),
    ) -> Result<(), CommandError> {
        let [width, height] = stills.size();
        let [wide, high] = [width, height].map(|side| side.next_multiple_of(2));
        if [wide, high] != [width, height] {
            console.note(format_args!(
                "{}: {width} × {height} pixels become {wide} × {high}, since films need even sides: the last column or row is \
                 there twice",
                path.display()
            ));
        }
        let folder = self.folder.as_deref().unwrap_or(Path::new("."));
        let part = folder.join(if kind == FilmFormat::Mp4 { PARTS[0] } else { PARTS[1] });
        let encoding = ffmpeg::Encoding { film: path, kind, part: &part, fps: self.fps, title: &caption.title };
        let encoded = encoding.run(stills, step).map_err(CommandError::from).and_then(|()| {
            let copy = |out: &mut Writer| io::copy(&mut fs::File::open(&part)?, out).map(drop);
            Ok(made.add(path, copy)?)
        });
        // Half a film is of no use. What can't be removed is replaced the next time.
        let _ = fs::remove_file(&part);
        encoded
    }

    fn page(&self, made: &mut Files, stills: &Stills, caption: &Caption, console: Console) -> Result<(), CommandError> {
        let Some(path) = &self.page else { return Ok(()) };
        let progress = making(path, stills, console);
        let warn = |warning: String| console.warn(format_args!("{}: {warning}", path.display()));
        made.add(path, |out| page::write(out, stills, self.fps, caption, &warn, &|| progress.inc(1)))?;
        progress.finish_and_clear();
        Ok(())
    }
}

/// Begins the progress of a file that is made of all frames.
fn making(path: &Path, stills: &Stills<'_>, console: Console) -> Bar {
    let progress = console.progress();
    progress.counted(&format!("making {}", path.display()), stills.count() as u64);
    progress
}

/// Removes frames and their folder. Whatever else is in it stays, and the folder with it.
fn remove_frames(folder: &Path, files: &[PathBuf], console: Console) {
    let leftovers = fs::read_dir(folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let is_leftover = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // Of runs that were killed.
        (name.starts_with(".pellucid-") && name.ends_with(".tmp")) || PARTS.contains(&name.as_str())
    };
    let leftovers: Vec<PathBuf> = leftovers.filter(is_leftover).collect();
    for file in files.iter().chain(&leftovers) {
        if let Err(error) = fs::remove_file(file) {
            console
                .warn(format_args!("{}: can't be removed, although it is no longer needed: {error}", file.display()));
            return;
        }
    }
    if fs::remove_dir(folder).is_err() {
        console.note(format_args!("{}: stays, since it holds other files too", folder.display()));
    }
}

/// The reason for which making a film ends when the user interrupts it.
fn interrupted() -> io::Result<()> {
    if interrupt::asked() { Err(io::Error::other("interrupted")) } else { Ok(()) }
}
