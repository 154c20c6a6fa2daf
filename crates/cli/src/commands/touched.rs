//! The files that a command reads and those that it writes: no command replaces one of its inputs.

use std::path::Path;

use pellucid_engine::Result;
use pellucid_io::output::{Inputs, Output};

/// Arguments of a command, which tell what it reads and what it writes.
pub trait Touches {
    /// Returns the files that the command reads and writes.
    ///
    /// # Errors
    /// Options that don't go together.
    fn touched(&self) -> Result<Touched>;
}

/// Files that a command reads, and files that it writes.
#[derive(Debug, Default)]
pub struct Touched {
    inputs: Inputs,
    outputs: Vec<Output>,
}

impl Touched {
    /// Begins with the files that are read.
    pub fn reads(inputs: Inputs) -> Self {
        Self { inputs, outputs: Vec::new() }
    }

    /// Adds a file that is written if an option names it.
    #[must_use]
    pub fn writes(self, option: &'static str, path: Option<&Path>) -> Self {
        self.and(path.map(|path| Output::file(option, path)))
    }

    /// Adds what is written.
    #[must_use]
    pub fn and(mut self, outputs: impl IntoIterator<Item = Output>) -> Self {
        self.outputs.extend(outputs);
        self
    }

    /// Refuses outputs that would replace an input or each other.
    ///
    /// # Errors
    /// An output is one of the inputs, or two outputs are the same file.
    pub fn check(&self) -> Result<()> {
        Ok(self.inputs.check(&self.outputs)?)
    }
}

#[cfg(test)]
mod tests {
    use std::any::TypeId;
    use std::fs;
    use std::path::PathBuf;

    use clap::{Arg, CommandFactory, Parser};
    use tempfile::TempDir;

    use super::super::{Cli, mpi_args};
    use super::*;

    /// Role of the file that an option names.
    enum Role {
        Read,
        /// Written, by a command with these arguments besides. `IN` is the input that the option names too, which ends
        /// in this.
        Written(&'static str, &'static [&'static str]),
        /// A folder to write to, by a command with these arguments besides. `IN` is the input, a file of this name
        /// there.
        Folder(&'static str, &'static [&'static str]),
        /// A folder to write to, by a command that reads nothing.
        Alone,
    }

    use Role::{Alone, Folder, Read, Written};

    /// Options that name files, by command and name.
    const ROLES: &[(&str, &str, Role)] = &[
        ("render", "inputs", Read),
        ("render", "path", Read),
        ("render", "like", Read),
        ("render", "output", Written(".png", &["IN"])),
        ("render", "profile", Written(".json", &["IN"])),
        ("render", "trace", Written(".json", &["IN"])),
        ("render", "html", Written(".html", &["IN", "--turntable", "--frames", "2"])),
        ("render", "popping", Written(".csv", &["IN", "--turntable", "--frames", "2"])),
        ("profile", "inputs", Read),
        ("profile", "path", Read),
        ("profile", "like", Read),
        ("profile", "output", Written(".json", &["IN"])),
        ("profile", "profile", Written(".json", &["IN"])),
        ("profile", "trace", Written(".json", &["IN"])),
        ("stress", "output", Alone),
        ("tradeoff", "inputs", Read),
        ("tradeoff", "path", Read),
        ("tradeoff", "like", Read),
        ("tradeoff", "output", Folder("tradeoff.csv", &["IN"])),
        ("plan", "inputs", Read),
        ("plan", "like", Read),
        ("prepare", "inputs", Read),
        ("prepare", "output", Written(".ply", &["IN"])),
        ("info", "files", Read),
        ("scene", "output", Folder("scene.toml", &["iso", "--volume", "IN"])),
        ("scene", "volume", Read),
        ("view", "inputs", Read),
        ("view", "path", Read),
        ("view", "like", Read),
        ("compare", "a", Read),
        ("compare", "b", Read),
        ("compare", "output", Written(".png", &["IN", "IN"])),
        ("man", "folder", Alone),
    ];

    fn role(command: &str, option: &Arg) -> &'static Role {
        let id = option.get_id().as_str();
        let known = ROLES.iter().find(|(of, name, _)| (*of, *name) == (command, id));
        let missing = || panic!("{command}: {id} names a file; say in `Touches` what becomes of it, and in ROLES");
        known.map_or_else(missing, |(.., role)| role)
    }

    fn names_a_file(option: &Arg) -> bool {
        option.get_value_parser().type_id() == TypeId::of::<PathBuf>()
    }

    fn touched(arguments: &[String]) -> Result<Touched> {
        let cli = Cli::try_parse_from(arguments).unwrap_or_else(|error| panic!("{arguments:?}: {error}"));
        cli.command.touched()
    }

    /// The message about a command line whose output is its input.
    fn refusal(arguments: &[String]) -> String {
        let checked = touched(arguments).and_then(|touched| touched.check());
        let error = checked.expect_err(&format!("{arguments:?} is not refused"));
        assert_eq!(error.exit_status(), 2, "{error}");
        error.to_string()
    }

    fn file(folder: &TempDir, name: &str) -> String {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "0 0 0\n1 1 1\n").unwrap();
        path.display().to_string()
    }

    #[test]
    fn every_option_of_an_output_refuses_an_input() {
        let program = Cli::command();
        for command in program.get_subcommands() {
            for option in command.get_arguments().filter(|option| names_a_file(option)) {
                let folder = tempfile::tempdir().unwrap();
                let (input, output, others) = match role(command.get_name(), option) {
                    Read | Alone => continue,
                    Written(end, others) => {
                        let input = file(&folder, &format!("in{end}"));
                        (input.clone(), input, others)
                    }
                    Folder(name, others) => {
                        (file(&folder, &format!("out/{name}")), folder.path().join("out").display().to_string(), others)
                    }
                };
                let option = option.get_long().expect("outputs are options");
                let mut line: Vec<String> = ["pellucid", command.get_name()].map(str::to_owned).into();
                line.extend(others.iter().map(|argument| argument.replace("IN", &input)));
                line.extend([format!("--{option}"), output.clone()]);
                let message = refusal(&line);
                assert!(message.contains(&output) && message.contains(&input), "{message}");
                assert_eq!(fs::read_to_string(&input).unwrap(), "0 0 0\n1 1 1\n");
            }
        }
    }

    #[test]
    fn the_options_of_ranks_are_those_of_the_program() {
        let ranks = mpi_args::Cli::command();
        for command in ranks.get_subcommands() {
            command.get_arguments().filter(|option| names_a_file(option)).for_each(|option| {
                role(command.get_name(), option);
            });
        }
    }

    /// Words of a command line, in which names of files are those of a folder.
    fn line(folder: &TempDir, words: &str) -> Vec<String> {
        let full = |word: &str| match word.contains('.') && !word.starts_with("--") {
            true => folder.path().join(word).display().to_string(),
            false => word.to_owned(),
        };
        ["pellucid"].into_iter().chain(words.split(' ')).map(full).collect()
    }

    #[test]
    fn an_input_is_known_whatever_names_it() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["scan.ply", "picture.png", "h.png", "area.geojson", "p.json", "frame_0002.png", "x.csv"] {
            file(&folder, name);
        }
        let scene = "[[cloud]]\npath = 'picture.png'\nphoto = { heights = 'h.png', height_scale = 1 }\n\
                     [[clip]]\npolygon = 'area.geojson'\n";
        fs::write(folder.path().join("scene.toml"), scene).unwrap();
        let model = ["model/cameras.txt", "model/images.txt"];
        model.iter().for_each(|name| drop(file(&folder, name)));
        for words in [
            "render scene.toml -o picture.png",
            "render scene.toml -o ./picture.png",
            "render scene.toml -o h.png",
            "render scene.toml --profile area.geojson",
            "render scene.toml --profile scene.toml",
            "render scan.ply --path p.json --profile p.json",
            "render scan.ply --path ./model/ --profile model/cameras.txt",
            "render frame_0002.png --turntable --frames 2 -o frame_%04d.png",
            "render scan.ply x.csv --turntable --frames 2 -o y.gif --popping x.csv",
            "profile scan.ply --trace scan.ply",
            "prepare scan.ply -o scan.ply",
            "prepare scan.ply -o ./scan.ply",
        ] {
            let message = refusal(&line(&folder, words));
            assert!(message.contains("would replace the input"), "{words}: {message}");
        }
        for words in ["render scene.toml -o other.png", "render scan.ply --path ./model/ -o model/a_%d.png"] {
            touched(&line(&folder, words)).and_then(|touched| touched.check()).expect(words);
        }
    }

    #[cfg(unix)]
    #[test]
    fn an_input_is_known_through_links() {
        let folder = tempfile::tempdir().unwrap();
        file(&folder, "picture.png");
        let at = |name: &str| folder.path().join(name);
        std::os::unix::fs::symlink(at("picture.png"), at("soft.png")).unwrap();
        fs::hard_link(at("picture.png"), at("hard.png")).unwrap();
        std::os::unix::fs::symlink(folder.path(), at("there.d")).unwrap();
        fs::hard_link(at("picture.png"), at("f_0007.png")).unwrap();
        for words in [
            "render picture.png -o soft.png",
            "render soft.png -o picture.png",
            "render picture.png -o hard.png",
            "render picture.png -o there.d/picture.png",
            "render there.d/soft.png -o hard.png",
            "render picture.png --turntable --frames 9 -o f_%04d.png --overwrite",
        ] {
            refusal(&line(&folder, words));
        }
    }

    #[test]
    fn two_outputs_are_two_files() {
        let folder = tempfile::tempdir().unwrap();
        file(&folder, "scan.ply");
        for words in [
            "render scan.ply -o a.png --profile a.png",
            "render scan.ply --profile a.json --trace ./a.json",
            "render scan.ply --turntable --frames 9 -o f_%03d.png --profile f_004.png",
            "render scan.ply --turntable --frames 9 -o f_%03d.png --profile a.json --trace a.json.partial",
            "render scan.ply --turntable --frames 9 -o a.gif --html ./a.gif",
        ] {
            let message = refusal(&line(&folder, words));
            assert!(message.contains("both are the same file"), "{words}: {message}");
        }
        let apart = line(&folder, "render scan.ply --turntable --frames 9 -o f_%03d.png --profile f_4.png");
        touched(&apart).and_then(|touched| touched.check()).unwrap();
        #[cfg(unix)]
        {
            let nowhere = ["render", "--profile", "/dev/null", "--trace", "/dev/null"].map(str::to_owned);
            let nowhere = [&["pellucid".to_owned()][..], &nowhere].concat();
            touched(&nowhere).and_then(|touched| touched.check()).unwrap();
        }
    }
}
