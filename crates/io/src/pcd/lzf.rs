//! LZF, the compression of `binary_compressed` PCD files (Marc Lehmann's liblzf format).

/// The largest expansion of one input byte: 3 bytes of a long match become 264.
pub(super) const MAX_EXPANSION: usize = 88;

/// Decompresses a stream that must become exactly `len` bytes. Memory grows with the decoded part.
pub(super) fn decompress(input: &[u8], len: usize) -> Result<Vec<u8>, String> {
    if len / MAX_EXPANSION > input.len() {
        return Err(format!("{} compressed bytes can't expand to the {len} that are announced", input.len()));
    }
    let mut output = Vec::new();
    let mut rest = input;
    while let Some((&control, after)) = rest.split_first() {
        let at = input.len() - rest.len();
        let ends = || format!("the compressed data end within the item at their byte {at}");
        rest = if control < 32 {
            let (literals, after) = after.split_at_checked(usize::from(control) + 1).ok_or_else(ends)?;
            output.extend_from_slice(literals);
            after
        } else {
            let (extra, after) = if control >> 5 == 7 { after.split_first().ok_or_else(ends)? } else { (&0, after) };
            let (low, after) = after.split_first().ok_or_else(ends)?;
            let count = usize::from(control >> 5) + usize::from(*extra) + 2;
            let back = (usize::from(control & 31) << 8 | usize::from(*low)) + 1;
            let start = output.len().checked_sub(back).ok_or_else(|| {
                format!(
                    "the item at byte {at} of the compressed data refers to {back} bytes back, but there are only {}",
                    output.len()
                )
            })?;
            // A match may overlap its own output.
            for from in start..start + count {
                output.push(output[from]);
            }
            after
        };
        if output.len() > len {
            return Err(format!("the compressed data expand to more than the {len} bytes that are announced"));
        }
    }
    if output.len() == len {
        Ok(output)
    } else {
        Err(format!("the data expand to {} bytes, not to {len}", output.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_and_matches() {
        assert_eq!(decompress(&[2, 7, 8, 9], 3).unwrap(), [7, 8, 9]);
        // Three bytes from two back, overlapping; and a long match of 9 + 1 from one back.
        assert_eq!(decompress(&[1, 7, 8, 1 << 5, 1], 5).unwrap(), [7, 8, 7, 8, 7]);
        assert_eq!(decompress(&[0, 5, 7 << 5, 1, 0], 11).unwrap(), [5; 11]);
        let longest = [&[0, 5][..], &[7 << 5, 255, 0].repeat(3)].concat();
        assert_eq!(decompress(&longest, 1 + 3 * 264).unwrap(), [5; 793]);
        // A distance of more than a byte: 257 back.
        let far = [&[31][..], &[1; 32], &[31], &[2; 32], &[7 << 5, 184, 0], &[(1 << 5) | 1, 0]].concat();
        assert_eq!(decompress(&far, 260).unwrap()[257..], [1, 1, 1]);
    }

    #[test]
    fn damage() {
        for (input, len, says) in [
            (&[2, 7, 8][..], 3, "end within the item at their byte 0"),
            (&[0, 1, 1 << 5], 4, "end within the item at their byte 2"),
            (&[0, 1, 7 << 5], 4, "end within"),
            (&[0, 1, 7 << 5, 0], 4, "end within"),
            (&[0, 1, 1 << 5, 1], 4, "refers to 2 bytes back, but there are only 1"),
            (&[1, 7, 8], 1, "more than the 1 bytes"),
            (&[1, 7, 8], 3, "expand to 2 bytes, not to 3"),
            (&[1, 7, 8], 1 << 40, "3 compressed bytes can't expand to"),
            (&[], 1 << 40, "0 compressed bytes can't expand to"),
        ] {
            assert!(decompress(input, len).unwrap_err().contains(says), "{input:?}");
        }
        assert!(decompress(&[], 0).unwrap().is_empty());
    }
}
