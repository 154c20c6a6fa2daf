//! Profiles as `compare` reads them. The code is the program's, which is no part of the library.

mod cli;

use cli::compare_profiles;
use cli::console::Console;
use cli::limit::{Limit, Slower};

use super::with_file;

/// Two profiles, between them a line `----`; one alone is compared with itself. All limits are looked at.
pub fn profile(input: &[u8]) {
    const BETWEEN: &[u8] = b"\n----\n";
    let at = input.windows(BETWEEN.len()).position(|window| window == BETWEEN);
    let (a, b) = at.map_or((input, input), |at| (&input[..at], &input[at + BETWEEN.len()..]));
    let limits = Limit::all(&["frame=1".to_owned()], &["abuffer/count=0".to_owned()]).expect("limits");
    let slower = ["1.5", "abuffer/count=2"].map(|text| Slower::parse(text).expect("a limit"));
    with_file("a.json", a, |a| {
        with_file("b.json", b, |b| {
            for json in [false, true] {
                let _ = compare_profiles::run([a, b], (json, true), &[], &[], Console);
                let _ = compare_profiles::run([a, b], (json, true), &limits, &[], Console);
                let _ = compare_profiles::run([a, b], (json, true), &[], &slower, Console);
            }
        });
    });
}
