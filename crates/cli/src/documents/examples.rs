//! Every `pellucid` line of the pages is parsed by the program's own parser, and every scene by its own reader, so that
//! no page shows an option or a key that doesn't exist.

use std::ffi::OsString;
use std::path::Path;

use clap::CommandFactory;
use pellucid_scene::{Overrides, Scene, method_keys};

use super::pages::{Block, blocks, blocks_of};
use crate::commands::{Cli, command_of_ranks};

/// A word that ends one command of a line and begins another.
fn separates(word: &str) -> bool {
    matches!(word, "|" | "||" | "&&" | "&" | ";" | "do" | "then" | "done" | "(" | ")")
}

/// The words of the commands of a shell line that are `program`, each with its arguments, without what is redirected.
fn commands(line: &str, program: &str) -> Result<Vec<Vec<String>>, String> {
    // The shell takes a `;` at the end of a word for a separator.
    let words = shlex::split(&line.replace("; ", " ; ")).ok_or("a quote has no end")?;
    let found = words.split(|word| separates(word)).filter_map(|command| {
        let is_assignment = |word: &&String| word.split_once('=').is_some_and(|(name, _)| is_name(name));
        let skipped = command.iter().take_while(|word| is_assignment(word) || *word == "$" || *word == "time").count();
        let command = &command[skipped..];
        let first = command.first()?;
        let start = if is_program(first, program) {
            1
        } else if first.starts_with("mpirun") {
            command.iter().position(|word| is_program(word, program))? + 1
        } else if first == "cargo" && program == "pellucid" && command.get(1).is_some_and(|word| word == "run") {
            // Examples have arguments of their own.
            if command.iter().any(|word| word == "--example" || word == "-p") {
                return None;
            }
            command.iter().position(|word| word == "--")? + 1
        } else {
            return None;
        };
        let is_redirection =
            |word: &String| word.trim_start_matches(|c: char| c.is_ascii_digit()).starts_with(['>', '<']);
        Some(command[start..].iter().take_while(|word| !is_redirection(word)).cloned().collect())
    });
    Ok(found.collect())
}

fn is_name(word: &str) -> bool {
    !word.is_empty() && word.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_')
}

fn is_program(word: &str, program: &str) -> bool {
    Path::new(word).file_name().is_some_and(|name| name == program)
}

/// The lines of a block with their numbers, those that a backslash continues as one.
fn whole_lines(block: &Block) -> Vec<(usize, String)> {
    let mut whole: Vec<(usize, String)> = Vec::new();
    let mut continued = false;
    for (at, line) in block.lines.iter().enumerate() {
        let text = line.strip_suffix('\\').unwrap_or(line);
        match whole.last_mut().filter(|_| continued) {
            Some((_, before)) => before.push_str(text),
            None => whole.push((block.line + 1 + at, text.to_owned())),
        }
        continued = line.ends_with('\\');
    }
    whole
}

/// Parses every command `program` of the blocks. Returns the number of those that are valid, and the parser's
/// complaints.
fn parse_all(blocks: &[Block], program: &str, parser: &clap::Command) -> (usize, Vec<String>) {
    let (mut taken, mut complaints) = (0, Vec::new());
    for block in blocks {
        for (line, text) in whole_lines(block) {
            let place = format!("{}:{line}: `{}`", block.page, text.trim());
            let found = match commands(&text, program) {
                Ok(found) => found,
                Err(problem) => {
                    complaints.push(format!("{place}: {problem}"));
                    continue;
                }
            };
            for command in found {
                complaints.extend(unused_keys(&command).map(|problem| format!("{place}: {problem}")));
                let given = std::iter::once(program.to_owned()).chain(command).map(OsString::from);
                match parser.clone().try_get_matches_from(given) {
                    Ok(_) => taken += 1,
                    // These print and end well.
                    Err(error) if error.exit_code() == 0 => taken += 1,
                    Err(error) => complaints.push(format!("{place}: {error}")),
                }
            }
        }
    }
    (taken, complaints)
}

/// Names a key of `--set method.KEY` that the method of `--method` lacks: the program would warn and change nothing.
/// Without `--method` it is auto, unless a scene file or a preset may name another.
fn unused_keys(command: &[String]) -> Option<String> {
    let values =
        |name: &'static str| command.windows(2).filter(move |pair| pair[0] == name).map(|pair| pair[1].as_str());
    let has_scene = command.iter().any(|word| word.ends_with(".toml")) || values("--preset").next().is_some();
    let method = values("--method").next_back().or_else(|| (!has_scene).then_some("auto"))?;
    let known = method_keys(method);
    let mut set = values("--set").filter_map(|set| set.strip_prefix("method.")?.split_once('='));
    let (key, _) = set.find(|(key, _)| *key != "name" && !known.contains(key))?;
    Some(format!("{method} has no key {key}"))
}

fn assert_all_parse(program: &str, parser: &clap::Command, at_least: usize) {
    let (taken, complaints) = parse_all(&blocks("sh"), program, parser);
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    assert!(taken >= at_least, "only {taken} commands `{program}` were found");
}

// A program without the window doesn't know `view`.
#[cfg(feature = "viewer")]
#[test]
fn every_command_of_the_pages_is_one_that_the_program_takes() {
    assert_all_parse("pellucid", &Cli::command(), 90);
}

#[test]
fn every_command_of_pellucid_mpi_is_one_that_it_takes() {
    assert_all_parse("pellucid-mpi", &command_of_ranks(), 5);
}

#[test]
fn wrong_commands_are_found_with_their_places() {
    let page = "text\n\n```sh\npellucid render a.ply --opacty 0.2\npellucid render --size\n\
                PELLUCID_CACHE_DIR=c target/release/pellucid stress \\\n    --nonsense -o d   # why not\n\
                pellucid info a.ply && pellucid lok a.ply | less\npellucid compare a.png b.png --fail-above 'rmse\n```\n\
                ```text\npellucid no-command\n```\n";
    let blocks: Vec<_> = blocks_of("page.md", page).into_iter().filter(|block| block.language == "sh").collect();
    let (taken, complaints) = parse_all(&blocks, "pellucid", &Cli::command());
    assert_eq!(taken, 1, "info is right: {complaints:?}");
    let parts = [(4, "--opacty"), (5, "--size"), (6, "--nonsense"), (8, "lok"), (9, "a quote has no end")];
    assert_eq!(complaints.len(), parts.len(), "{complaints:?}");
    for ((line, part), complaint) in parts.iter().zip(&complaints) {
        assert!(complaint.starts_with(&format!("page.md:{line}: ")) && complaint.contains(part), "{complaint}");
    }
}

#[test]
fn a_key_that_the_method_of_a_line_lacks_is_found() {
    let unused = |line: &str| unused_keys(&commands(line, "pellucid").unwrap()[0]);
    for line in [
        "pellucid render a.ply --method peel-layers --set method.only=3",
        "pellucid render a.ply --set method.shape=oriented --set method.name=sorted",
        "pellucid render a.toml --set method.only=3",
        "pellucid render a.ply --method circles --set cloud.0.opacity=0.5",
    ] {
        assert_eq!(unused(line), None, "{line}");
    }
    for (line, expected) in [
        ("pellucid render a.toml --method circles --set method.only=3", "circles has no key only"),
        ("pellucid render a.ply --set method.size=2 --set method.only=3", "auto has no key size"),
    ] {
        assert_eq!(unused(line).as_deref(), Some(expected), "{line}");
    }
}

#[test]
fn commands_are_found_where_they_stand_in_a_line() {
    for (line, expected) in [
        ("pellucid info a.ply   # what is in it", "info a.ply"),
        ("VK_DRIVER_FILES=$PWD/lvp.json pellucid devices", "devices"),
        ("for i in 1 2; do pellucid info $i.ply; done", "info $i.ply"),
        ("cargo run --release -- check points/", "check points/"),
        ("pellucid plan >plan.txt", "plan"),
        ("$ pellucid plan 2>&1", "plan"),
        ("tools/compare.py --pellucid target/release/pellucid -o out", ""),
        ("cargo run --release --example drivers -- --driver a", ""),
        ("mpirun -n 8 pellucid-mpi render", ""),
    ] {
        let found = commands(line, "pellucid").unwrap();
        assert_eq!(found.iter().map(|words| words.join(" ")).collect::<Vec<_>>().join(" / "), expected, "{line}");
    }
    let ranks =
        commands("mpirun -n 8 --hostfile hosts target/release/pellucid-mpi render a.ply -o a.png", "pellucid-mpi");
    assert_eq!(ranks.unwrap(), [["render", "a.ply", "-o", "a.png"]]);
}

/// Reads each scene of the blocks, and returns the reader's complaints. One without a cloud is a part of a scene and
/// gets one.
fn read_all(blocks: &[Block]) -> (usize, Vec<String>) {
    let (mut taken, mut complaints) = (0, Vec::new());
    for block in blocks {
        let mut text = block.lines.join("\n");
        if !text.contains("[[cloud]]") {
            text.push_str("\n[[cloud]]\npath = \"scan.ply\"\n");
        }
        let origin = format!("{} (the block in line {})", block.page, block.line);
        match Scene::from_toml_with(&text, Path::new(&origin), &Overrides::default()) {
            Ok(_) => taken += 1,
            Err(error) => complaints.push(error.to_string()),
        }
    }
    (taken, complaints)
}

#[test]
fn every_scene_of_the_pages_is_one_that_the_program_reads() {
    let (taken, complaints) = read_all(&blocks("toml"));
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
    assert!(taken >= 3, "only {taken} scenes were found");
}

#[test]
fn a_wrong_scene_is_found_with_its_place() {
    let (taken, complaints) =
        read_all(&blocks_of("page.md", "```toml\n[[cloud]]\npath = \"a.ply\"\nopacty = 1\n```\n"));
    assert_eq!(taken, 0);
    assert!(complaints[0].contains("page.md") && complaints[0].contains("opacty"), "{complaints:?}");
}
