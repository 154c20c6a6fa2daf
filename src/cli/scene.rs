//! `pellucid scene`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Args;
use pellucid::scene::procedural::{self, BUILTINS, Generated};
use pellucid::{Error, Result, io, output, scene};

use super::talk::{Talk, print};

#[derive(Debug, Args)]
pub struct SceneArgs {
    /// The scene; --list names them.
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// List the scenes and their parameters: name, summary, then each parameter with its default and range.
    #[arg(long)]
    list: bool,
    /// Folder for scene.toml and its clouds; created if it isn't there.
    #[arg(short, long, value_name = "DIR", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// A parameter of the scene, as in points=400000; repeatable.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Seed of everything random in the scene.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
}

pub fn run(args: SceneArgs, talk: Talk) -> Result<ExitCode> {
    if args.list {
        print(&list())?;
        return Ok(ExitCode::SUCCESS);
    }
    if let (Some(name), Some(folder)) = (&args.name, &args.output) {
        let parameters = args.set.iter().map(|pair| parameter(pair)).collect::<Result<Vec<_>, _>>()?;
        let generated = procedural::build(name, &parameters, args.seed).map_err(scene::Error::from)?;
        write(folder, &generated)?;
        talk.detail(format_args!("{}: written", folder.join("scene.toml").display()));
    }
    Ok(ExitCode::SUCCESS)
}

fn list() -> String {
    let line = |builtin: &procedural::Builtin| {
        let parameter =
            |p: &procedural::Parameter| format!("{}={} ({} to {}: {})", p.name, p.default, p.min, p.max, p.summary);
        let parameters: Vec<_> = builtin.parameters.iter().map(parameter).collect();
        format!("{:<10} {}; {}\n", builtin.name, builtin.summary, parameters.join(", "))
    };
    BUILTINS.iter().map(line).collect()
}

fn parameter(pair: &str) -> Result<(String, f64), scene::Error> {
    let problem = || scene::Error::Usage(format!("--set {pair}: expected KEY=NUMBER, as in points=400000"));
    let (key, value) = pair.split_once('=').ok_or_else(problem)?;
    let value = value.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(problem)?;
    Ok((key.trim().to_owned(), value))
}

/// The scene file is written last, so that it never names a cloud that isn't there.
fn write(folder: &Path, generated: &Generated) -> Result<()> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| Error::from(output::Error::Write { path, source })
    };
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    let temporary = tempfile::Builder::new().prefix(".pellucid-").tempdir_in(folder).map_err(failed(folder))?;
    for (name, cloud) in &generated.clouds {
        let mut file = PathBuf::from(name);
        if file.extension().is_none() {
            file.set_extension("ply");
        }
        let (from, to) = (temporary.path().join(&file), folder.join(&file));
        io::ply::write(&from, cloud)?;
        std::fs::rename(&from, &to).map_err(failed(&to))?;
    }
    output::write_atomically(&folder.join("scene.toml"), |out| {
        std::io::Write::write_all(out, generated.scene_toml.as_bytes())
    })?;
    Ok(())
}
