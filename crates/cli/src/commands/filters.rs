//! Short options that leave points out or make them see-through: `--class`, `--classes`, `--without`, `--slice`.

use pellucid_core::color::classes;
use pellucid_engine::Result;
use pellucid_scene::Overrides;

use super::limit::usage;

/// Adds entries of `[[cloud.class]]` for the options. Those of the scene file come first, so that options win.
pub fn classes(overrides: &mut Overrides, class: &[String], only: Option<&str>, without: Option<&str>) -> Result<()> {
    let mut add = |option: &str, entry: String| overrides.append(option, "cloud.*.class", &entry);
    for pair in class {
        let option = format!("--class {pair}");
        let Some((name, opacity)) = pair.split_once('=') else {
            return Err(usage(format!("{option}: expected NAME=OPACITY, as in high-vegetation=0.05")));
        };
        let code = code(&option, name)?;
        // TOML rejects a form like .5; what is no number is refused as the key's value.
        let number = opacity.trim().parse().ok().filter(|x: &f64| x.is_finite());
        let opacity = number.map_or_else(|| format!("{opacity:?}"), |x| format!("{x:?}"));
        add(&option, format!("{{ id = {code}, opacity = {opacity} }}"))?;
    }
    if let Some(list) = only {
        let option = format!("--classes {list}");
        for [first, last] in others(&codes(&option, list)?) {
            add(&option, format!("{{ scalar = \"classification\", range = [{first}, {last}], visible = false }}"))?;
        }
    }
    if let Some(list) = without {
        let option = format!("--without {list}");
        for code in codes(&option, list)? {
            add(&option, format!("{{ id = {code}, visible = false }}"))?;
        }
    }
    Ok(())
}

/// Adds entries of `[[clip]]` for `--slice`, each as in z=2..4.
pub fn slices(overrides: &mut Overrides, slices: &[String]) -> Result<()> {
    for slice in slices {
        let option = format!("--slice {slice}");
        let Some(slab) = slab(slice) else {
            return Err(usage(format!("{option}: expected AXIS=FROM..TO, as in z=2..4, z=2.. or z=..4")));
        };
        overrides.append(&option, "clip", &slab)?;
    }
    Ok(())
}

/// A slab as a scene file has it; `None` for a text of another form.
fn slab(slice: &str) -> Option<String> {
    let (axis, range) = slice.split_once('=')?;
    let (from, to) = range.split_once("..")?;
    let axis = axis.trim().to_lowercase();
    let end = |key: &str, text: &str| match text.trim() {
        "" => Some(String::new()),
        text => text.parse().ok().filter(|x: &f64| x.is_finite()).map(|x| format!(", {key} = {x:?}")),
    };
    let ends = end("min", from)? + &end("max", to)?;
    (["x", "y", "z"].contains(&&*axis) && !ends.is_empty())
        .then(|| format!("{{ slab = {{ axis = \"{axis}\"{ends} }} }}"))
}

/// The classes of a list, by their numbers or names.
fn codes(option: &str, list: &str) -> Result<Vec<u8>> {
    list.split(',').map(|word| code(option, word)).collect()
}

fn code(option: &str, word: &str) -> Result<u8> {
    let word = word.trim();
    let found = word.parse().ok().or_else(|| classes::code(word));
    let names: Vec<_> = classes::names().collect();
    found.ok_or_else(|| {
        usage(format!(
            "{option}: unknown class {word:?}; expected a number from 0 to 255, or one of {}",
            names.join(", ")
        ))
    })
}

/// The runs of classes that a list lacks.
fn others(codes: &[u8]) -> Vec<[u8; 2]> {
    let lacking: Vec<u8> = (0..=u8::MAX).filter(|code| !codes.contains(code)).collect();
    let runs = lacking.chunk_by(|a, b| a + 1 == *b);
    runs.filter_map(|run| Some([*run.first()?, *run.last()?])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_are_slabs_with_open_ends() {
        for (slice, wanted) in [
            ("z=2..4", Some("{ slab = { axis = \"z\", min = 2.0, max = 4.0 } }")),
            ("X=-.5..", Some("{ slab = { axis = \"x\", min = -0.5 } }")),
            ("y = ..1e3", Some("{ slab = { axis = \"y\", max = 1000.0 } }")),
            ("z=..", None),
            ("w=1..2", None),
            ("z=1", None),
            ("z=a..2", None),
            ("z=1..inf", None),
            ("1..2", None),
        ] {
            assert_eq!(slab(slice).as_deref(), wanted, "{slice}");
        }
    }

    #[test]
    fn classes_missing_from_a_list_come_in_runs() {
        assert_eq!(others(&[6, 2]), [[0, 1], [3, 5], [7, 255]]);
        assert_eq!(others(&[0, 255]), [[1, 254]]);
        assert_eq!(others(&(0..=255).collect::<Vec<_>>()), [[0u8; 2]; 0]);
    }
}
