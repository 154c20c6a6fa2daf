//! Advice about options that a command doesn't have.

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use pellucid_scene::paths_of;

/// Advice of the parser that suits no option of these programs: no input is called like an option.
const AS_A_VALUE: &str = " as a value";

/// Replaces the parser's advice to take an unknown option for a value by the keys of the scene file that have its name.
pub fn advise(mut error: clap::Error) -> clap::Error {
    if error.kind() != ErrorKind::UnknownArgument {
        return error;
    }
    let tips = match error.remove(ContextKind::Suggested) {
        Some(ContextValue::StyledStrs(tips)) => tips,
        _ => Vec::new(),
    };
    let typed = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(typed)) => typed.clone(),
        _ => String::new(),
    };
    let mut tips: Vec<StyledStr> = tips.into_iter().filter(|tip| !tip.to_string().contains(AS_A_VALUE)).collect();
    // Commands that take a scene have these keys.
    let takes_scene = matches!(error.get(ContextKind::Usage), Some(ContextValue::StyledStr(usage))
        if usage.to_string().contains("INPUT"));
    tips.extend(key_tip(&typed).filter(|_| takes_scene).map(StyledStr::from));
    if !tips.is_empty() {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(tips));
    }
    error
}

/// Names the keys of the scene file that are called as an option would be.
fn key_tip(typed: &str) -> Option<String> {
    let name = typed.strip_prefix("--")?.split('=').next()?.replace('-', "_");
    let paths = paths_of(&name);
    let paths: Vec<_> = paths.iter().map(|path| format!("--set {path}=VALUE")).collect();
    (!paths.is_empty()).then(|| format!("a key of the scene file has this name: {}", paths.join(" or ")))
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::super::Cli;
    use super::*;

    fn advice(arguments: &[&str]) -> String {
        let error = Cli::try_parse_from([&["pellucid"], arguments].concat()).expect_err("an unknown option");
        advise(error).render().to_string()
    }

    #[test]
    fn an_unknown_option_is_not_taken_for_a_value() {
        for arguments in [["render", "--shape=flat"], ["stress", "--frobnicate"], ["plan", "-o"], ["render", "--zz"]] {
            let text = advice(&arguments);
            assert!(text.contains("unexpected argument") && !text.contains("-- -"), "{text}");
        }
    }

    #[test]
    fn a_key_of_the_scene_file_is_named() {
        let text = advice(&["render", "--shape", "oriented"]);
        assert!(text.contains("tip: a key of the scene file has this name: --set method.shape=VALUE"), "{text}");
        let text = advice(&["plan", "--outlier-factor", "3"]);
        assert!(text.contains("--set cloud.*.outlier_factor=VALUE"), "{text}");
    }

    #[test]
    fn a_command_without_a_scene_has_no_keys() {
        for command in ["stress", "check"] {
            assert!(!advice(&[command, "--samples", "4"]).contains("--set"), "{command}");
        }
    }

    #[test]
    fn a_slip_still_gets_the_nearest_option() {
        assert!(advice(&["render", "--opacty", "1"]).contains("'--opacity'"));
    }
}
