//! Numbers of points as text.

/// A count in groups of three digits.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let groups: Vec<_> = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    groups.join("\u{2009}")
}

/// A count in a few characters.
pub fn abbreviated(count: u64) -> String {
    let [thousands, millions] = [1e3, 1e6].map(|unit| count as f64 / unit);
    match count {
        0..1_000 => count.to_string(),
        1_000..10_000 => format!("{thousands:.1}k"),
        10_000..1_000_000 => format!("{thousands:.0}k"),
        1_000_000..10_000_000 => format!("{millions:.1}M"),
        _ => format!("{millions:.0}M"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_go_in_threes() {
        let spaced = |count| grouped(count).replace('\u{2009}', " ");
        assert_eq!([0, 999, 1000, 1_234_567].map(spaced), ["0", "999", "1 000", "1 234 567"]);
        let short = [999, 1000, 12_345, 1_250_000, 999_999_999].map(abbreviated);
        assert_eq!(short, ["999", "1.0k", "12k", "1.2M", "1000M"]);
    }
}
