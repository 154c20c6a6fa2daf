//! Renders the same scenes by every method on several drivers, and compares their images (docs/determinism.md).
//!
//! ```sh
//! cargo run --release --example drivers -- \
//!     --driver "Mesa 25=lvp25.json,mesa25/usr/lib/x86_64-linux-gnu" --driver "SwiftShader=vk_swiftshader_icd.json"
//! ```
//!
//! `NAME=MANIFEST` is a driver's manifest (JSON), behind a comma the folder of libraries that it needs, if any. The
//! loader picks drivers once per process: each one renders in a process of its own, with `VK_DRIVER_FILES` and
//! `LD_LIBRARY_PATH` set. If the folder has a dynamic linker, `ld-linux-x86-64.so.2`, that one starts the process: a
//! driver of a newer system needs that system's libc, and libc and linker belong together. The images of the driver
//! that the environment gives are what the others are compared with; `--first NAME=MANIFEST` says another.
//!
//! The exit status is 1 if any image is beyond its bound, 2 if a driver could not render at all. What a driver lacks is
//! not applicable, and is no pass.

mod bound;
mod images;
mod table;

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Parser;
use pellucid_lab::check;

use images::DriverImages;

#[derive(Debug, Parser)]
struct Args {
    /// A driver to compare: its name, its manifest, and perhaps the folder of its libraries.
    #[arg(long = "driver", value_name = "NAME=MANIFEST[,LIBRARIES]", value_parser = driver)]
    drivers: Vec<Driver>,
    /// The driver that the others are compared with, instead of the one that the environment gives.
    #[arg(long, value_name = "NAME=MANIFEST[,LIBRARIES]", value_parser = driver)]
    first: Option<Driver>,
    /// Only subjects whose name contains this.
    #[arg(long)]
    only: Option<String>,
    /// A row for every method, those that are equal to the last bit too.
    #[arg(long)]
    all: bool,
    /// Renders all subjects into this folder and compares nothing: what the children do.
    #[arg(long, hide = true)]
    render: Option<PathBuf>,
}

/// A driver as the command line names it.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Driver {
    name: String,
    /// `None`: what the environment gives.
    manifest: Option<PathBuf>,
    libraries: Option<PathBuf>,
}

fn driver(text: &str) -> Result<Driver, String> {
    let (name, rest) = text.split_once('=').ok_or("expected NAME=MANIFEST, as in \"Mesa 25=lvp_icd.x86_64.json\"")?;
    let (manifest, libraries) = rest.split_once(',').map_or((rest, None), |(m, l)| (m, Some(l)));
    let there = |path: &str| Path::new(path).canonicalize().map_err(|e| format!("{path}: {e}"));
    let libraries = libraries.map(there).transpose()?;
    Ok(Driver { name: name.to_owned(), manifest: Some(there(manifest)?), libraries })
}

fn main() -> ExitCode {
    let args = Args::parse();
    let done = match &args.render {
        Some(folder) => images::render(folder, args.only.as_deref()).map(|()| true),
        None => compare(&args),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

/// Prints the table; whether nothing is beyond its bound.
fn compare(args: &Args) -> Result<bool, String> {
    let own = Driver { name: "the environment's".into(), manifest: None, libraries: None };
    let first = args.first.clone().unwrap_or(own);
    let folder = tempfile::tempdir().map_err(|e| format!("a folder for images: {e}"))?;
    let mut found = Vec::new();
    for (number, driver) in std::iter::once(&first).chain(&args.drivers).enumerate() {
        eprintln!("{} …", driver.name);
        found.push(rendered_by(driver, &folder.path().join(number.to_string()), args.only.as_deref())?);
    }
    let subjects = check::compared();
    let subjects =
        subjects.iter().filter(|subject| images::is_asked(subject, args.only.as_deref())).collect::<Vec<_>>();
    let lines = table::lines(&subjects, &found);
    print!("{}", table::heads(&found));
    print!("{}", table::markdown(&lines, &found, args.all));
    Ok(lines.iter().all(|line| !line.verdict.is_wrong()))
}

/// File name of the dynamic linker.
const LINKER: &str = "ld-linux-x86-64.so.2";

/// The dynamic linker of a folder of libraries, if it has one.
fn linker_in(libraries: &Path) -> Option<PathBuf> {
    Some(libraries.join(LINKER)).filter(|path| path.is_file())
}

/// A program with these libraries' own linker, if they have one.
fn started(program: &Path, libraries: Option<&Path>) -> Command {
    let Some((libraries, linker)) = libraries.and_then(|libraries| Some((libraries, linker_in(libraries)?))) else {
        return Command::new(program);
    };
    let mut command = Command::new(linker);
    command.arg("--library-path").arg(libraries).arg(program);
    command
}

/// Has a driver render all subjects, in a process of its own.
fn rendered_by(driver: &Driver, folder: &Path, only: Option<&str>) -> Result<DriverImages, String> {
    let failed = |what: String| format!("{}: {what}", driver.name);
    std::fs::create_dir_all(folder).map_err(|e| failed(format!("{}: {e}", folder.display())))?;
    let program = std::env::current_exe().map_err(|e| failed(format!("this program's path: {e}")))?;
    let mut command = started(&program, driver.libraries.as_deref());
    command.arg("--render").arg(folder);
    if let Some(only) = only {
        command.args(["--only", only]);
    }
    if let Some(manifest) = &driver.manifest {
        // The older variable would win in old loaders.
        command.env("VK_DRIVER_FILES", manifest).env_remove("VK_ICD_FILENAMES").env_remove("LD_LIBRARY_PATH");
    }
    if let Some(libraries) = driver.libraries.as_deref().filter(|libraries| linker_in(libraries).is_none()) {
        command.env("LD_LIBRARY_PATH", libraries);
    }
    let status = command.status().map_err(|e| failed(e.to_string()))?;
    if !status.success() {
        return Err(failed(format!("its process ended with {status}")));
    }
    images::load(folder).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_with_a_linker_start_the_program_by_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let words = || {
            let command = started(Path::new("program"), Some(folder.path()));
            let arguments = command.get_args().map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>();
            (command.get_program().to_string_lossy().into_owned(), arguments)
        };
        assert_eq!(words(), ("program".to_owned(), Vec::new()));
        let linker = folder.path().join(LINKER);
        std::fs::write(&linker, "").expect("written");
        let (path, arguments) = words();
        assert_eq!(path, linker.to_string_lossy());
        assert_eq!(arguments, ["--library-path", &folder.path().to_string_lossy(), "program"]);
    }

    #[test]
    fn drivers_have_a_name_a_manifest_and_perhaps_libraries() {
        let folder = tempfile::tempdir().expect("a folder");
        let manifest = folder.path().join("icd.json");
        std::fs::write(&manifest, "{}").expect("written");
        let (path, libraries) = (manifest.display(), folder.path().display());
        let of = |text: String| driver(&text);
        let found = of(format!("Mesa 25={path}")).expect("a driver");
        assert_eq!((found.name.as_str(), found.libraries), ("Mesa 25", None));
        let found = of(format!("a={path},{libraries}")).expect("a driver");
        assert!(found.manifest.is_some() && found.libraries.is_some());
        assert!(of(format!("{path}")).is_err_and(|text| text.contains("NAME=MANIFEST")));
        assert!(of(format!("a={path}.other")).is_err_and(|text| text.contains("icd.json.other")));
    }
}
