//! Words that somebody wrote, and those that were probably meant.

/// Returns a phrase that names the candidate nearest to `word`, or all candidates if none is near.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>, what: &str) -> String {
    let candidates: Vec<_> = candidates.into_iter().collect();
    let best = candidates
        .iter()
        .map(|c| (strsim::damerau_levenshtein(&word.to_lowercase(), c), *c))
        .min_by_key(|(distance, _)| *distance);
    match best {
        // Half of the word's letters wrong is no longer a slip of the finger.
        Some((distance, c)) if 2 * distance <= word.chars().count().max(c.len()) => format!("; did you mean `{c}`?"),
        _ => format!("; {what}: {}", candidates.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_names_the_key_and_a_guess_lists_all() {
        assert_eq!(nearest("opactiy", ["path", "opacity"], "known"), "; did you mean `opacity`?");
        assert_eq!(nearest("transparency", ["path", "opacity"], "known"), "; known: path, opacity");
    }
}
