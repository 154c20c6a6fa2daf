//! The reference of commands, a page that only the book has (tools/book.sh), from clap's table of commands.

use std::fmt::Write as _;

use clap::builder::StyledStr;
use clap::{Arg, ArgAction, Command, CommandFactory};

use crate::commands::{Cli, command_of_ranks};

const INTRODUCTION: &str = "\
# Command reference

Every command and every option, in the words of `pellucid COMMAND --help`. Examples: [commands.md](commands.md). The keys that
`--set` gives: [scene-file.md](scene-file.md).

Exit status: 0 done, 1 it could not be done, 2 the command line or the scene file is wrong. A signal ends a command with that signal's
status. `-h` prints short help, `--help` all of it, `--version` the version.
";

/// The page's part about `pellucid`.
fn reference(program: &Command) -> String {
    let mut text = INTRODUCTION.to_owned();
    let _ = write!(text, "\n| command | |\n|---|---|\n");
    for command in shown(program) {
        let name = command.get_name();
        let _ = writeln!(text, "| [`{name}`](#pellucid-{name}) | {} |", cell(&plain(command.get_about())));
    }
    text.push_str("\nEvery command takes these:\n\n");
    program.get_arguments().filter(|arg| arg.is_global_set()).for_each(|arg| text.push_str(&item("", arg)));
    for command in shown(program) {
        text.push_str(&section("pellucid", command, &[]));
    }
    text
}

fn shown(program: &Command) -> impl Iterator<Item = &Command> {
    program.get_subcommands().filter(|command| !command.is_hide_set() && command.get_name() != "help")
}

/// The section of a command: what it does, its usage, its arguments and its options, without those that `known` has.
fn section(program: &str, command: &Command, known: &[&Arg]) -> String {
    let name = command.get_name();
    let about = plain(command.get_long_about().or(command.get_about()));
    let mut usage = command.clone().bin_name(format!("{program} {name}")).render_usage().to_string();
    usage = usage.trim_start_matches("Usage: ").trim().to_owned();
    let mut text = format!("\n## {program} {name}\n\n{}\n\n```text\n{usage}\n```\n", sentence(&about));
    let is_known = |arg: &Arg| known.iter().any(|other| other.get_id() == arg.get_id());
    // Arguments that every command has stand at the top of the page.
    let is_own = |arg: &&Arg| !arg.is_hide_set() && !arg.is_global_set() && *arg.get_id() != "help" && !is_known(arg);
    let own: Vec<&Arg> = command.get_arguments().filter(is_own).collect();
    // As in `--help`: those without a heading come first.
    let mut headings = vec![None];
    for arg in &own {
        if !headings.contains(&arg.get_help_heading()) {
            headings.push(arg.get_help_heading());
        }
    }
    for heading in headings {
        let title = heading.map_or(String::new(), |title| format!("**{title}**\n\n"));
        let mut of_heading = own.iter().filter(|arg| arg.get_help_heading() == heading).peekable();
        if of_heading.peek().is_some() {
            let _ = write!(text, "\n{title}");
        }
        of_heading.for_each(|arg| text.push_str(&item(&format!("{program}-{name}"), arg)));
    }
    text
}

/// An argument: anchor, names, value, help, default, values.
fn item(command: &str, arg: &Arg) -> String {
    let anchor = if command.is_empty() { String::new() } else { format!("<a id=\"{command}--{}\"></a>", arg.get_id()) };
    let help = sentence(&plain(arg.get_long_help().or(arg.get_help())));
    let mut text = format!("- {anchor}{}: {}", names(arg), indented(&help));
    let values: Vec<_> = arg.get_possible_values().into_iter().filter(|value| !value.is_hide_set()).collect();
    let takes_value = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append);
    if takes_value && !values.is_empty() && !arg.is_hide_possible_values_set() {
        let one = |value: &clap::builder::PossibleValue| match value.get_help() {
            Some(help) => format!("`{}` ({})", value.get_name(), escaped(&help.to_string())),
            None => format!("`{}`", value.get_name()),
        };
        let _ = write!(text, " Values: {}.", values.iter().map(one).collect::<Vec<_>>().join(", "));
    }
    let defaults: Vec<_> = arg.get_default_values().iter().map(|value| format!("`{}`", value.display())).collect();
    if takes_value && !defaults.is_empty() && !arg.is_hide_default_value_set() {
        let _ = write!(text, " Default: {}.", defaults.join(", "));
    }
    text + "\n"
}

/// The lines behind the first, as parts of an item of a list; a list in them stands apart.
fn indented(help: &str) -> String {
    let mut text = String::new();
    let mut last = "";
    for line in help.lines() {
        if line.starts_with("- ") && !last.starts_with("- ") && !last.is_empty() {
            text.push('\n');
        }
        let indent = if text.is_empty() || line.is_empty() { "" } else { "  " };
        let _ = writeln!(text, "{indent}{line}");
        last = line;
    }
    text.trim_end().to_owned()
}

/// `-o`, `--output <FILE>`, or `[INPUT]...`.
fn names(arg: &Arg) -> String {
    let mut name = arg.to_string();
    if let Some(short) = arg.get_short().filter(|_| arg.get_long().is_some()) {
        name = format!("-{short}`, `{name}");
    }
    format!("`{name}`")
}

fn plain(text: Option<&StyledStr>) -> String {
    text.map(|text| escaped(&text.to_string())).unwrap_or_default()
}

/// Text as Markdown shows it: what looks like a tag or emphasis is none, except between backticks. Lists become lists.
fn escaped(text: &str) -> String {
    let parts = text.split('`').enumerate().map(|(at, part)| match at % 2 {
        0 => part.replace('<', "&lt;").replace('*', "\\*").replace('_', "\\_"),
        _ => part.to_owned(),
    });
    parts.collect::<Vec<_>>().join("`").trim().to_owned()
}

fn cell(text: &str) -> String {
    text.lines().next().unwrap_or_default().replace('|', "\\|")
}

/// clap takes the full stop from a help of one paragraph.
fn sentence(text: &str) -> String {
    if text.is_empty() || text.ends_with(['.', '!', '?', ':']) { text.to_owned() } else { format!("{text}.") }
}

/// The part about `pellucid-mpi`: options that `pellucid` lacks.
fn reference_of_ranks(program: &Command, ranks: &Command) -> String {
    let mut text = "\n# pellucid-mpi\n\nIts commands take what those of `pellucid` take, and these options as well \
                    ([many-machines.md](many-machines.md)).\n"
        .to_owned();
    for command in shown(ranks) {
        let known: Vec<_> =
            program.find_subcommand(command.get_name()).into_iter().flat_map(Command::get_arguments).collect();
        text.push_str(&section("pellucid-mpi", command, &known));
    }
    text
}

// A program without the window has no `view`.
#[cfg(feature = "viewer")]
#[test]
fn the_book_has_every_command_and_option() {
    let (mut program, mut ranks) = (Cli::command(), command_of_ranks());
    program.build();
    ranks.build();
    let page = reference(&program) + &reference_of_ranks(&program, &ranks);
    for part in ["## pellucid view\n", "`--see-through", "## pellucid-mpi plan\n", "`--spread`"] {
        assert!(page.contains(part), "{part:?} is missing");
    }
    pellucid_testing::add_to_book("docs/command-reference.md", &page);
}

#[test]
fn every_command_and_every_option_has_a_sentence() {
    for command in shown(&Cli::command()) {
        assert!(command.get_about().is_some(), "{} has no help", command.get_name());
        for arg in command.get_arguments() {
            assert!(arg.get_help().is_some(), "{} {} has no help", command.get_name(), arg.get_id());
        }
    }
}

#[test]
fn help_is_text_in_markdown() {
    assert_eq!(escaped("a < b, cloud.*.x_y and `cloud.*.x_y < 2`"), "a &lt; b, cloud.\\*.x\\_y and `cloud.*.x_y < 2`");
    let arg = Arg::new("size").short('s').long("size").value_name("WxH").default_value("64x64").help("The size");
    let mut program = Command::new("p").arg(arg);
    program.build();
    let arg = program.get_arguments().find(|arg| *arg.get_id() == "size").unwrap();
    assert_eq!(
        item("p-render", arg),
        "- <a id=\"p-render--size\"></a>`-s`, `--size <WxH>`: The size. Default: `64x64`.\n"
    );
    assert_eq!(indented("Either.\n\nOne of:\n- a\n- b"), "Either.\n\n  One of:\n\n  - a\n  - b");
}
