//! Names of numbered pictures: `step_%02d.png`.

use std::path::{Path, PathBuf};

use pellucid_engine::Result;
use pellucid_io::output::Output;

use super::limit;

/// Digits of a number at most.
const MAX_WIDTH: usize = 9;

/// The kind of sequence, which decides the form of its file names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Naming {
    /// The steps of a time series.
    Steps,
    /// The frames of a camera path. Their numbers can't be padded with spaces, which tools that make films reject.
    Frames,
}

impl Naming {
    /// The requirements on a name, as the end of a sentence.
    fn needs(self) -> &'static str {
        match self {
            Self::Steps => "--frames needs a number in the name, as in step_%02d.png",
            Self::Frames => "a frame's name needs one number, %d or %0Nd, as in frame_%04d.png",
        }
    }
}

/// A file name with one number in it.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    folder: PathBuf,
    before: String,
    after: String,
    /// Least digits.
    width: usize,
    /// True if the number is padded with zeros, else with spaces.
    zeros: bool,
}

impl Pattern {
    /// Reads `step_%02d.png` as printf does: `%d`, `%3d` or `%03d`, once, in the name of the file; `%%` is a percent
    /// sign.
    ///
    /// # Errors
    /// A name without a number or with several, or with any other `%`; `%3d` in names of frames.
    pub fn parse(path: &Path, naming: Naming) -> Result<Self> {
        let usage = |problem: &str| {
            let path = path.display();
            limit::usage(format!("-o {path}: {problem}; {}", naming.needs()))
        };
        let name = path.file_name().ok_or_else(|| usage("this names no file"))?;
        let name = name.to_str().ok_or_else(|| usage("the name is not UTF-8"))?;
        let mut parts = [String::new(), String::new()];
        let mut number = None;
        let mut rest = name;
        while let Some((text, behind)) = rest.split_once('%') {
            let part = &mut parts[usize::from(number.is_some())];
            part.push_str(text);
            if let Some(behind) = behind.strip_prefix('%') {
                part.push('%');
                rest = behind;
                continue;
            }
            let digits = behind.chars().take_while(char::is_ascii_digit).count();
            let (digits, behind) = behind.split_at(digits);
            let width = if digits.is_empty() { Some(0) } else { digits.parse().ok() };
            let width = width.filter(|width| *width <= MAX_WIDTH);
            let (Some(behind), Some(width)) = (behind.strip_prefix('d'), width) else {
                return Err(usage("% stands neither for a number (%d, %02d) nor for itself (%%)"));
            };
            if number.replace((width, digits.starts_with('0'))).is_some() {
                return Err(usage("there is more than one number"));
            }
            rest = behind;
        }
        parts[usize::from(number.is_some())].push_str(rest);
        let (width, zeros) = number.ok_or_else(|| usage("every picture would have this name"))?;
        if naming == Naming::Frames && width > 0 && !zeros {
            return Err(usage("spaces would fill the number"));
        }
        let [before, after] = parts;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self { folder, before, after, width, zeros })
    }

    /// Returns all files as an output.
    pub fn output(&self) -> Output {
        let shown = self.shown();
        let (pattern, folder) = (self.clone(), self.folder.clone());
        Output::files("-o", &shown, &folder, move |name| pattern.name_like(name))
    }

    /// The pattern as it may be given.
    fn shown(&self) -> PathBuf {
        let Self { folder, before, after, width, zeros } = self;
        let escaped = |text: &str| text.replace('%', "%%");
        let (zero, width) = (if *zeros { "0" } else { "" }, if *width > 0 { width.to_string() } else { String::new() });
        folder.join(format!("{}%{zero}{width}d{}", escaped(before), escaped(after)))
    }

    /// Returns the name of a file of the sequence that differs from `name` at most in letter case.
    fn name_like(&self, name: &str) -> Option<String> {
        let low = name.to_lowercase();
        let rest = low.strip_prefix(&self.before.to_lowercase())?.strip_suffix(&self.after.to_lowercase())?;
        let own = self.name(rest.trim_start().parse().ok()?);
        (own.to_lowercase() == low).then_some(own)
    }

    /// The name of the file of a number.
    fn name(&self, number: usize) -> String {
        let Self { before, after, width, zeros, .. } = self;
        let width = *width;
        let number = if *zeros { format!("{number:0width$}") } else { format!("{number:width$}") };
        format!("{before}{number}{after}")
    }

    /// The file of a number.
    pub fn file(&self, number: usize) -> PathBuf {
        self.folder.join(self.name(number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_number_as_printf_writes_it() {
        let file = |pattern: &str, number| Pattern::parse(Path::new(pattern), Naming::Steps).unwrap().file(number);
        assert_eq!(file("step_%02d.png", 3), Path::new("step_03.png"));
        assert_eq!(file("a%b/%d.exr", 12), Path::new("a%b/12.exr"));
        assert_eq!(file("100%%_%3d%%.png", 7), Path::new("100%_  7%.png"));
        assert_eq!(file("%02d", 123), Path::new("123"));
    }

    #[test]
    fn names_of_a_sequence_are_known_in_either_case() {
        let pattern = Pattern::parse(Path::new("a/Frame_%03d%%.png"), Naming::Frames).unwrap();
        assert_eq!(pattern.shown(), Path::new("a/Frame_%03d%%.png"));
        assert_eq!(pattern.name_like("frame_012%.PNG").as_deref(), Some("Frame_012%.png"));
        assert_eq!(pattern.name_like("Frame_1234%.png").as_deref(), Some("Frame_1234%.png"));
        for other in ["Frame_12%.png", "Frame_%.png", "Frame_012.png", "Frame_+12%.png", "x"] {
            assert_eq!(pattern.name_like(other), None, "{other}");
        }
        let spaces = Pattern::parse(Path::new("%3d.png"), Naming::Steps).unwrap();
        assert_eq!((spaces.name_like("  7.png").as_deref(), spaces.name_like("7.png")), (Some("  7.png"), None));
    }

    #[test]
    fn other_names_are_refused() {
        for (name, says) in [
            ("step.png", "every picture would have this name"),
            ("%d_%d.png", "more than one"),
            ("%s.png", "neither"),
            ("%.png", "neither"),
            ("%0x.png", "neither"),
            ("%0999999999999999999999d.png", "neither"),
            ("%10d.png", "neither"),
            ("%d%", "neither"),
            ("..", "no file"),
        ] {
            let message = Pattern::parse(Path::new(name), Naming::Steps).expect_err(name).to_string();
            assert!(message.contains(says) && message.contains("step_%02d.png"), "{message}");
            let message = Pattern::parse(Path::new(name), Naming::Frames).expect_err(name).to_string();
            assert!(message.contains(says) && message.contains("frame_%04d.png"), "{message}");
        }
        let message = Pattern::parse(Path::new("%4d.png"), Naming::Frames).expect_err("spaces").to_string();
        assert!(message.contains("spaces"), "{message}");
        assert!(Pattern::parse(Path::new("%d.png"), Naming::Frames).is_ok());
    }
}
