//! Command lines as they are typed.

/// The command as it was typed.
pub fn command() -> String {
    std::iter::once("pellucid".to_owned()).chain(std::env::args().skip(1)).collect::<Vec<_>>().join(" ")
}

/// An argument as a POSIX shell reads it.
pub fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_alphanumeric() || "-_./,:=+%@".contains(c);
    if !argument.is_empty() && argument.chars().all(is_plain) {
        return argument.to_owned();
    }
    format!("'{}'", argument.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_quoted_where_a_shell_would_read_them_otherwise() {
        let read = [
            ("scan.laz", "scan.laz"),
            ("a b", "'a b'"),
            ("it's", r"'it'\''s'"),
            ("", "''"),
            ("<x>", "'<x>'"),
            ("-5,2.5", "-5,2.5"),
        ];
        read.iter().for_each(|(argument, expected)| assert_eq!(quoted(argument), *expected));
    }
}
