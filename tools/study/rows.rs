//! The file of a driver: a line of JSON for the device, one for each case, and one for each setting of the case before
//! it.

use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use pellucid_io::output::Error;
use serde::{Deserialize, Serialize};

/// The device, and how it was measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Device {
    /// The device's name.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// Discrete, integrated, virtual, CPU, other.
    pub kind: String,
    /// Version of pellucid.
    pub pellucid: String,
    /// Width and height of the images.
    pub size: [u32; 2],
    /// Frames behind a median.
    pub frames: u64,
}

impl Device {
    /// The name of its file.
    pub fn file_name(&self) -> String {
        let text = format!("{} {}", self.device, self.driver).to_lowercase();
        // A driver's name may begin with the device's.
        let mut words: Vec<&str> = Vec::new();
        for word in text.split(|c: char| !c.is_ascii_alphanumeric() && c != '.') {
            if !word.is_empty() && !words.contains(&word) {
                words.push(word);
            }
        }
        let mut name = words.join("-");
        name.truncate(60);
        format!("{}.jsonl", name.trim_end_matches(['-', '.']))
    }
}

/// A scene with lists of one mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Case {
    pub scene: String,
    /// The wanted mean list of the covered pixels.
    pub target: u32,
    /// The mean list that was found.
    pub mean: f64,
    pub longest: u32,
    /// Pixels that hold any fragment.
    pub covered: u64,
    pub points: u64,
    /// Factor on the radii, or the extents, that the scene has by itself.
    pub radius_factor: f64,
    /// Opacity of all points; `None` if they keep their own.
    pub opacity: Option<f64>,
}

/// A setting: its key, RMSE, device time of a frame in ms, peak device bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Row(pub String, pub f64, pub f64, pub u64);

impl Row {
    pub fn key(&self) -> &str {
        &self.0
    }

    pub fn rmse(&self) -> f64 {
        self.1
    }

    pub fn ms(&self) -> f64 {
        self.2
    }

    pub fn bytes(&self) -> u64 {
        self.3
    }

    /// The method, and those of its keys that are not numbers: what the steps of a ladder share. One that leaves points
    /// out is another than the same method with all of them.
    pub fn family(&self) -> String {
        let word = |word: &str| match word.split_once('.') {
            Some(("detail", _)) => Some("detail".to_owned()),
            _ if is_step(word) => None,
            _ => Some(word.trim_start_matches("method.").to_owned()),
        };
        self.key().split(' ').filter_map(word).collect::<Vec<_>>().join(" ")
    }

    /// Key and value of the step, as in `k=8`; empty without one.
    pub fn step(&self) -> String {
        let steps = self.key().split(' ').filter(|word| is_step(word));
        steps.map(|word| word.split_once('.').map_or(word, |(_, step)| step)).collect::<Vec<_>>().join(" ")
    }
}

/// True of a key with a number.
fn is_step(word: &str) -> bool {
    word.split_once('=').is_some_and(|(_, value)| value.parse::<f64>().is_ok())
}

/// The end of a case: all of its settings are there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Done {
    done: (String, u32),
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(untagged)]
enum Line {
    Device(Device),
    Case(Case),
    Row(Row),
    Done(Done),
}

/// A case with what was measured of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    pub case: Case,
    pub rows: Vec<Row>,
    /// True if no setting is missing.
    pub done: bool,
}

/// Measurements of a driver.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    pub device: Device,
    pub cases: Vec<Measured>,
}

impl Study {
    /// Reads the lines of a file; a last one that is cut short counts as absent.
    ///
    /// # Errors
    /// Text that is none of a study's.
    fn parse(path: &Path, text: &str) -> Result<Self, Error> {
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let wrong = |number: usize, what: &str| Error::Decode {
            path: path.to_owned(),
            reason: format!("line {}: {what}; remove the file, or restore it, and measure again", number + 1),
        };
        let mut study: Option<Self> = None;
        // The case that rows belong to.
        let mut current = None;
        for (number, line) in whole.lines().enumerate() {
            let line: Line =
                serde_json::from_str(line).map_err(|_| wrong(number, "expected a device, a case or a setting"))?;
            match (line, &mut study) {
                (Line::Device(device), None) => study = Some(Self { device, cases: Vec::new() }),
                (Line::Device(_), Some(_)) => return Err(wrong(number, "a second device")),
                (Line::Case(case), Some(study)) => current = Some(study.enter(case)),
                (Line::Row(row), Some(study)) => match current {
                    Some(at) => study.cases[at].rows.push(row),
                    None => return Err(wrong(number, "a setting before any case")),
                },
                (Line::Done(Done { done: (scene, target) }), Some(study)) => study.finish(&scene, target),
                (_, None) => return Err(wrong(number, "expected a device first")),
            }
        }
        study.ok_or_else(|| wrong(0, "expected a device"))
    }

    /// The place of a case, which is added unless it is there.
    fn enter(&mut self, case: Case) -> usize {
        let known = self.cases.iter().position(|m| m.case.scene == case.scene && m.case.target == case.target);
        known.unwrap_or_else(|| {
            self.cases.push(Measured { case, rows: Vec::new(), done: false });
            self.cases.len() - 1
        })
    }

    fn finish(&mut self, scene: &str, target: u32) {
        let found = self.cases.iter_mut().find(|m| m.case.scene == scene && m.case.target == target);
        if let Some(measured) = found {
            measured.done = true;
        }
    }

    pub fn find(&self, scene: &str, target: u32) -> Option<&Measured> {
        self.cases.iter().find(|m| m.case.scene == scene && m.case.target == target)
    }
}

/// A file to which lines are added.
#[derive(Debug)]
pub struct Log {
    path: PathBuf,
    file: File,
    pub study: Study,
}

impl Log {
    /// Opens the file of a device, or begins it.
    ///
    /// # Errors
    /// A file of another size of images or number of frames, one that is damaged, or one that can't be written.
    pub fn open(folder: &Path, device: Device) -> Result<Self, Error> {
        std::fs::create_dir_all(folder).map_err(|source| Error::Write { path: folder.to_owned(), source })?;
        let path = folder.join(device.file_name());
        let failed = |source| Error::Write { path: path.clone(), source };
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(&path);
        let mut file = file.map_err(failed)?;
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(|source| Error::Read { path: path.clone(), source })?;
        // A line that was cut short is written anew.
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        file.set_len(whole as u64).and_then(|()| file.seek(SeekFrom::End(0))).map_err(failed)?;
        if whole == 0 {
            let study = Study { device: device.clone(), cases: Vec::new() };
            let mut log = Self { path, file, study };
            log.write(&Line::Device(device))?;
            return Ok(log);
        }
        let study = Study::parse(&path, &text)?;
        if study.device != device {
            let reason = format!(
                "it holds what {} measured; this would be {}. Another folder, or the same options, would help",
                in_words(&study.device),
                in_words(&device)
            );
            return Err(Error::Decode { path, reason });
        }
        Ok(Self { path, file, study })
    }

    /// Begins a case, or goes on with it.
    pub fn case(&mut self, case: Case) -> Result<(), Error> {
        self.write(&Line::Case(case.clone()))?;
        self.study.enter(case);
        Ok(())
    }

    /// Adds a setting to the case of this scene and mean, which was begun last.
    pub fn row(&mut self, scene: &str, target: u32, row: Row) -> Result<(), Error> {
        self.write(&Line::Row(row.clone()))?;
        let found = self.study.cases.iter_mut().find(|m| m.case.scene == scene && m.case.target == target);
        if let Some(measured) = found {
            measured.rows.push(row);
        }
        Ok(())
    }

    /// Takes note that nothing of a case is missing.
    pub fn done(&mut self, scene: &str, target: u32) -> Result<(), Error> {
        self.write(&Line::Done(Done { done: (scene.to_owned(), target) }))?;
        self.study.finish(scene, target);
        Ok(())
    }

    fn write(&mut self, line: &Line) -> Result<(), Error> {
        let failed = |source| Error::Write { path: self.path.clone(), source };
        let text = serde_json::to_string(line).map_err(|error| Error::Report { reason: error.to_string() })?;
        self.file.write_all(format!("{text}\n").as_bytes()).map_err(failed)
    }
}

fn in_words(device: &Device) -> String {
    let Device { device, driver, pellucid, size: [width, height], frames, .. } = device;
    format!("{device} ({driver}) with pellucid {pellucid} at {width}x{height}, {frames} frames each")
}

/// A number with four digits: a file of thousands of them stays small.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// All studies of a folder, in the order of their files' names.
///
/// # Errors
/// A folder or a file that can't be read, one that is damaged, no file.
pub fn read_all(folder: &Path) -> Result<Vec<Study>, Error> {
    let failed = |source| Error::Read { path: folder.to_owned(), source };
    let entries = std::fs::read_dir(folder).map_err(failed)?;
    let mut paths =
        entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>().map_err(failed)?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "jsonl"));
    paths.sort();
    if paths.is_empty() {
        let reason = "it holds no .jsonl file; -o measures one".to_owned();
        return Err(Error::Decode { path: folder.to_owned(), reason });
    }
    let read = |path: &PathBuf| {
        let text = std::fs::read_to_string(path).map_err(|source| Error::Read { path: path.clone(), source })?;
        Study::parse(path, &text)
    };
    paths.iter().map(read).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    pub fn device() -> Device {
        Device {
            device: "llvmpipe (LLVM 15.0.6, 256 bits)".to_owned(),
            driver: "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)".to_owned(),
            kind: "CPU".to_owned(),
            pellucid: "0.1.0".to_owned(),
            size: [64, 48],
            frames: 3,
        }
    }

    fn case(scene: &str, target: u32) -> Case {
        let scene = scene.to_owned();
        Case { scene, target, mean: 5.1, longest: 9, covered: 7, points: 3, radius_factor: 1.5, opacity: Some(0.25) }
    }

    #[test]
    fn names() {
        assert_eq!(device().file_name(), "llvmpipe-llvm-15.0.6-256-bits-mesa-22.3.6.jsonl");
        let row = Row("stochastic method.samples=64 method.alpha_correction=false".to_owned(), 0.1, 2.0, 3);
        assert_eq!((row.family().as_str(), row.step().as_str()), ("stochastic alpha_correction=false", "samples=64"));
        let row = Row("abuffer".to_owned(), 0.0, 1.0, 2);
        assert_eq!((row.family().as_str(), row.step().as_str()), ("abuffer", ""));
        let row = Row("sorted detail.spacing_px=0.5".to_owned(), 0.1, 2.0, 3);
        assert_eq!((row.family().as_str(), row.step().as_str()), ("sorted detail", "spacing_px=0.5"));
        assert_eq!((rounded(123_456.0), rounded(1.23456e-7), rounded(0.0)), (123_500.0, 1.235e-7, 0.0));
    }

    #[test]
    fn a_file_that_was_cut_short_goes_on() {
        let folder = tempfile::tempdir().unwrap();
        let mut log = Log::open(folder.path(), device()).unwrap();
        log.case(case("tori", 5)).unwrap();
        log.row("tori", 5, Row("abuffer".to_owned(), 0.0, 2.0, 9)).unwrap();
        log.done("tori", 5).unwrap();
        log.case(case("stack", 5)).unwrap();
        log.row("stack", 5, Row("weighted".to_owned(), 0.1, 1.0, 9)).unwrap();
        let known = log.study.clone();
        drop(log);
        let path = folder.path().join(device().file_name());
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("{text}[\"abuf")).unwrap();
        let mut log = Log::open(folder.path(), device()).unwrap();
        assert_eq!(log.study, known);
        log.case(case("stack", 5)).unwrap();
        log.row("stack", 5, Row("abuffer".to_owned(), 0.0, 1.5, 9)).unwrap();
        let known = log.study.clone();
        assert_eq!((known.find("stack", 5).unwrap().rows.len(), known.find("stack", 5).unwrap().done), (2, false));
        assert!(known.find("tori", 5).unwrap().done && known.find("tori", 15).is_none());
        assert_eq!(read_all(folder.path()).unwrap(), [known]);
    }

    #[test]
    fn faults_of_a_file_are_reported() {
        let folder = tempfile::tempdir().unwrap();
        let refused = |error: Error| error.to_string();
        assert!(refused(read_all(folder.path()).unwrap_err()).contains("-o measures one"));
        drop(Log::open(folder.path(), device()).unwrap());
        let other = Device { size: [32, 24], ..device() };
        let said = refused(Log::open(folder.path(), other).unwrap_err());
        assert!(said.contains("at 64x48") && said.contains("at 32x24"), "{said}");
        let path = folder.path().join(device().file_name());
        let head = std::fs::read_to_string(&path).unwrap();
        for (text, place) in [("[1]\n", "line 1"), ("[\"a\",0.0,1.0,2]\n", "line 1: expected a device first")] {
            std::fs::write(&path, text).unwrap();
            assert!(refused(read_all(folder.path()).unwrap_err()).contains(place));
        }
        for (text, place) in [("[\"a\",0.0,1.0,2]\n", "before any case"), (head.as_str(), "line 2: a second device")] {
            std::fs::write(&path, format!("{head}{text}")).unwrap();
            assert!(refused(read_all(folder.path()).unwrap_err()).contains(place));
        }
    }
}
