//! Inputs that no output may replace.
//!
//! A file is known by what the system says of it and not by its name: so an input is found through links of both kinds,
//! through `./`, and under other letter case where the file system ignores that.

use std::ffi::OsStr;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use super::Error;
use crate::parts;
use pellucid_core::atomic;

/// Files that are read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Inputs {
    /// The files, those of a store or a model one by one. A folder stands for everything in it.
    files: Vec<PathBuf>,
    /// Folders whose files form one cloud together.
    clouds: Vec<PathBuf>,
}

impl Inputs {
    /// Adds a cloud, or any other file; of a store, of splats in a folder and of glTF all files that belong to it.
    pub fn add(&mut self, path: &Path) {
        let parts = parts::of(path);
        if path.is_dir() && !parts.is_empty() {
            self.clouds.push(path.to_owned());
        } else if !path.is_dir() {
            self.files.push(path.to_owned());
        }
        self.files.extend(parts);
    }

    /// Returns the inputs with these added.
    #[must_use]
    pub fn with(mut self, paths: impl IntoIterator<Item = impl AsRef<Path>>) -> Self {
        paths.into_iter().for_each(|path| self.add(path.as_ref()));
        self
    }

    /// Refuses an output that would replace an input.
    ///
    /// # Errors
    /// The output is one of the inputs.
    pub fn refuse(&self, output: &Path) -> Result<(), Error> {
        self.check(&[Output::file("", output)])
    }

    /// Refuses outputs that would replace an input or each other.
    ///
    /// # Errors
    /// An output is one of the inputs, or two outputs are the same file.
    pub fn check(&self, outputs: &[Output]) -> Result<(), Error> {
        for (number, output) in outputs.iter().enumerate() {
            if let Some(input) = self.replaced_by(output) {
                return Err(Error::Input { output: output.to_string(), input: input.to_owned() });
            }
            if let Some(other) = outputs.iter().take(number).find(|other| other.overlaps(output)) {
                return Err(Error::SameOutput { a: other.to_string(), b: output.to_string() });
            }
        }
        Ok(())
    }

    /// Returns the input that an output would replace.
    fn replaced_by(&self, output: &Output) -> Option<&Path> {
        let targets = match &output.names {
            Names::One => vec![output.path.clone()],
            Names::Some(_) => output.present(),
        };
        let is_hit =
            |input: &Path| targets.iter().any(|target| is_same_file(target, input) || is_within(target, input));
        let hit = self.files.iter().map(PathBuf::as_path).find(|input| is_hit(input));
        let is_cloud = |cloud: &&PathBuf| matches!(output.names, Names::Some(_)) && is_same(&output.path, cloud);
        hit.or_else(|| self.clouds.iter().find(is_cloud).map(PathBuf::as_path))
    }
}

/// Gives the name of a file that is written, for a name that differs from it at most in letter case.
type Rule = Box<dyn Fn(&str) -> Option<String>>;

enum Names {
    One,
    /// Files of a folder.
    Some(Rule),
}

/// File, or files of a folder, to be written.
pub struct Output {
    /// Option that names it; empty if none does.
    option: &'static str,
    shown: PathBuf,
    /// The file, or the folder of the files.
    path: PathBuf,
    names: Names,
}

impl Output {
    /// Returns the output that is one file, which an option names; the option is empty where there is none.
    pub fn file(option: &'static str, path: &Path) -> Self {
        Self { option, shown: path.to_owned(), path: path.to_owned(), names: Names::One }
    }

    /// Returns the output that is several files of a folder. `rule` gives the name of a file that may be written, for a
    /// name that differs from it at most in letter case. `shown` stands for all in messages.
    pub fn files(
        option: &'static str,
        shown: &Path,
        folder: &Path,
        rule: impl Fn(&str) -> Option<String> + 'static,
    ) -> Self {
        Self { option, shown: shown.to_owned(), path: folder.to_owned(), names: Names::Some(Box::new(rule)) }
    }

    /// Returns the output that is a folder with files of these names; a name that begins with a point is the end of any
    /// name.
    pub fn folder(option: &'static str, folder: &Path, names: &'static [&'static str]) -> Self {
        let rule = move |name: &str| {
            let low = name.to_lowercase();
            let end = names.iter().find(|end| end.starts_with('.') && low.ends_with(*end));
            let whole = names.iter().find(|known| **known == low).map(|known| (*known).to_owned());
            whole.or_else(|| end.map(|_| name.to_owned()))
        };
        Self::files(option, folder, folder, rule)
    }

    /// Returns the files that are there and would be replaced, of several.
    fn present(&self) -> Vec<PathBuf> {
        let folder = if self.path.as_os_str().is_empty() { Path::new(".") } else { &self.path };
        let entries =
            fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| self.path.join(entry.file_name()));
        entries.filter(|entry| self.writes(entry)).collect()
    }

    /// Returns `true` if this output may write that file.
    fn writes(&self, file: &Path) -> bool {
        let target = match &self.names {
            Names::One => Some(self.path.clone()),
            Names::Some(rule) => {
                file.file_name().and_then(OsStr::to_str).and_then(rule).map(|name| self.path.join(name))
            }
        };
        target.is_some_and(|target| is_same_place(&target, file))
    }

    fn overlaps(&self, other: &Self) -> bool {
        match (&self.names, &other.names) {
            (_, Names::One) => self.writes(&other.path),
            (Names::One, Names::Some(_)) => other.writes(&self.path),
            // No command has two.
            (Names::Some(_), Names::Some(_)) => false,
        }
    }
}

impl fmt::Display for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let space = if self.option.is_empty() { "" } else { " " };
        write!(f, "{}{space}{}", self.option, self.shown.display())
    }
}

impl fmt::Debug for Output {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Output({self})")
    }
}

/// Returns `true` if two paths lead to one file or folder that is there.
fn is_same(a: &Path, b: &Path) -> bool {
    let [a, b] = [a, b].map(|path| if path.as_os_str().is_empty() { Path::new(".") } else { path });
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let id = |path: &Path| fs::metadata(path).ok().map(|found| (found.dev(), found.ino()));
        id(a).is_some_and(|a| Some(a) == id(b))
    }
    #[cfg(not(unix))]
    {
        same_file::is_same_file(a, b).unwrap_or(false)
    }
}

/// Returns `true` if two paths lead to one regular file. Devices and pipes are not replaced by what is written to them.
fn is_same_file(a: &Path, b: &Path) -> bool {
    a.is_file() && is_same(a, b)
}

/// Returns `true` if a file lies in a folder, at any depth.
fn is_within(file: &Path, folder: &Path) -> bool {
    let Some(place) = folder.is_dir().then(|| atomic::folder(file).canonicalize().ok()).flatten() else { return false };
    place.ancestors().any(|above| is_same(above, folder))
}

/// Returns `true` if two paths are those of one regular file, whether it is there or not.
fn is_same_place(a: &Path, b: &Path) -> bool {
    if a.exists() || b.exists() {
        return is_same_file(a, b);
    }
    let (Some(a_name), Some(b_name)) = (a.file_name(), b.file_name()) else { return false };
    let folder = atomic::folder(a);
    is_same(folder, atomic::folder(b)) && (a_name == b_name || folded(a_name) == folded(b_name) && ignores_case(folder))
}

fn folded(name: &OsStr) -> Option<String> {
    name.to_str().map(str::to_lowercase)
}

/// Returns `true` if names in a folder may be written in either case: if that holds of an entry of it, or else of the
/// folder's own name.
fn ignores_case(folder: &Path) -> bool {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let own = folder.canonicalize().ok();
    entries
        .chain(own)
        .find_map(|path| Some((swapped(&path)?, path)))
        .is_some_and(|(other, path)| is_same(&other, &path))
}

/// Returns a path with the other case of each letter of its last name, if there is any.
fn swapped(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let swap = |c: char| match c {
        'a'..='z' => c.to_ascii_uppercase(),
        _ => c.to_ascii_lowercase(),
    };
    let other: String = name.chars().map(swap).collect();
    (other != name).then(|| path.with_file_name(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_in_the_other_case() {
        assert_eq!(swapped(Path::new("a/Scan 1.PLY")), Some(PathBuf::from("a/sCAN 1.ply")));
        assert_eq!(swapped(Path::new("a/12_3")), None);
    }

    #[test]
    fn case_counts_where_the_system_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let [lower, upper] = ["out.png", "OUT.png"].map(|name| folder.path().join(name));
        fs::write(folder.path().join("x"), "").unwrap();
        let ignored = folder.path().join("X").exists();
        assert_eq!(ignores_case(folder.path()), ignored);
        assert_eq!(is_same_place(&lower, &upper), ignored);
        assert!(is_same_place(&lower, &folder.path().join("./out.png")));
    }

    #[test]
    fn rules_of_folders_name_the_file_that_is_written() {
        let output = Output::folder("-o", Path::new("report"), &["report.html", ".png"]);
        let Names::Some(rule) = &output.names else { panic!("several files") };
        assert_eq!(rule("REPORT.html").as_deref(), Some("report.html"));
        assert_eq!((rule("a.PNG").as_deref(), rule("a.toml")), (Some("a.PNG"), None));
        assert_eq!(output.to_string(), "-o report");
    }
}
