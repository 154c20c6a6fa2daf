//! Recipes by name: `--preset`. A preset stands for keys of the scene file, and for `--see-through` and `--view`; all
//! are printed.

use pellucid_engine::Result;
use pellucid_scene::Overrides;
use pellucid_session::{SeeThrough, SeeThroughBy};

/// A recipe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    pub name: &'static str,
    /// Purpose, as a phrase.
    purpose: &'static str,
    /// Keys of the scene file with values in TOML; a key that ends in `+` gets one more entry.
    keys: &'static [(&'static str, &'static str)],
    /// Value of `--see-through` where no option gives an opacity.
    pub see_through: Option<SeeThrough>,
    /// True if `--view iso` is taken where nothing says from where to look: from outside, whatever surrounds the
    /// middle.
    pub from_outside: bool,
}

/// The value of `--preset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Asked {
    /// Print all of them.
    List,
    Of(Preset),
}

/// Keys that come between an option and what it asks for, each with the option's key: they are left out where that is
/// given.
const IN_THE_WAY: [(&str, &str); 3] =
    [("cloud.*.color", "color_by"), ("cloud.*.opacity", "surface_opacity"), ("cloud.*.radius_factor", "radius")];

/// The key of an entry about a class.
const CLASS: &str = "cloud.*.class+";

/// All presets.
const PRESETS: [Preset; 6] = [
    Preset {
        name: "canopy",
        purpose: "ground, trunks and walls under trees; without classes all points become faint",
        keys: &[
            ("cloud.*.opacity", "0.05"),
            ("cloud.*.radius_factor", "0.8"),
            ("cloud.*.outliers", "\"drop\""),
            (CLASS, "{ id = \"ground\", opacity = 1.0 }"),
            (CLASS, "{ id = \"water\", opacity = 1.0 }"),
            (CLASS, "{ id = \"road\", opacity = 1.0 }"),
            (CLASS, "{ id = \"building\", opacity = 0.3 }"),
            (CLASS, "{ id = \"low-vegetation\", opacity = 0.1 }"),
            (CLASS, "{ id = \"medium-vegetation\", opacity = 0.05 }"),
            (CLASS, "{ id = \"high-vegetation\", opacity = 0.03 }"),
            (CLASS, "{ id = \"low-noise\", visible = false }"),
            (CLASS, "{ id = \"high-noise\", visible = false }"),
        ],
        see_through: Some(SeeThrough { share: 0.5, by: SeeThroughBy::PresetWithoutClasses }),
        from_outside: false,
    },
    Preset {
        name: "building",
        purpose: "rooms under roofs, for scans with classes: faint buildings, fainter trees, solid ground",
        keys: &[
            ("image.background", "[1.0, 1.0, 1.0]"),
            ("cloud.*.opacity", "0.02"),
            ("cloud.*.outliers", "\"drop\""),
            (CLASS, "{ id = \"ground\", opacity = 1.0 }"),
            (CLASS, "{ id = \"water\", opacity = 1.0 }"),
            (CLASS, "{ id = \"road\", opacity = 1.0 }"),
            (CLASS, "{ id = \"building\", opacity = 0.12 }"),
            (CLASS, "{ id = \"low-vegetation\", opacity = 0.02 }"),
            (CLASS, "{ id = \"medium-vegetation\", opacity = 0.02 }"),
            (CLASS, "{ id = \"high-vegetation\", opacity = 0.02 }"),
            (CLASS, "{ id = \"low-noise\", visible = false }"),
            (CLASS, "{ id = \"high-noise\", visible = false }"),
        ],
        see_through: Some(SeeThrough { share: 0.6, by: SeeThroughBy::PresetWithoutClasses }),
        from_outside: false,
    },
    Preset {
        name: "indoor",
        purpose: "rooms and halls from outside, through walls and ceiling",
        keys: &[("image.background", "\"#5b6b7b\""), ("cloud.*.opacity", "0.1"), ("cloud.*.outliers", "\"drop\"")],
        see_through: Some(SeeThrough { share: 0.4, by: SeeThroughBy::Preset }),
        from_outside: true,
    },
    Preset {
        name: "heritage",
        purpose: "inner and outer shape as in an X-ray, dark on white, without the file's colors",
        keys: &[
            ("image.background", "[1.0, 1.0, 1.0]"),
            ("cloud.*.color", "[0.02, 0.05, 0.1]"),
            ("cloud.*.opacity", "0.1"),
            ("cloud.*.radius_factor", "0.8"),
            ("cloud.*.outliers", "\"drop\""),
        ],
        see_through: Some(SeeThrough { share: 0.5, by: SeeThroughBy::Preset }),
        from_outside: false,
    },
    Preset {
        name: "model",
        purpose: "an opaque surface, closed, smooth and shaded",
        keys: &[
            ("image.background", "[1.0, 1.0, 1.0]"),
            ("method.name", "\"hqs\""),
            ("cloud.*.outliers", "\"drop\""),
            ("cloud.*.radius_factor", "1.5"),
            ("shading.model", "\"lambert\""),
            ("shading.edl", "true"),
            ("shading.edl_strength", "0.5"),
        ],
        see_through: None,
        from_outside: false,
    },
    Preset {
        name: "print",
        purpose: "smooth edges and thin things on white paper: 16 samples of each pixel's area",
        keys: &[("image.samples", "16"), ("image.background", "[1.0, 1.0, 1.0]")],
        see_through: None,
        from_outside: false,
    },
];

/// Reads the value of `--preset`.
pub fn asked(name: &str) -> Result<Asked, String> {
    if name == "list" {
        return Ok(Asked::List);
    }
    let found = PRESETS.into_iter().find(|preset| preset.name == name).map(Asked::Of);
    found.ok_or_else(|| {
        let names = PRESETS.map(|preset| preset.name);
        format!("unknown preset; expected one of {}, or list to print them", names.join(", "))
    })
}

/// All presets with what they are for and the keys that they set.
pub fn list() -> String {
    let text = |preset: &Preset| {
        let keys: String = preset.settings().map(|line| format!("  {line}\n")).collect();
        format!("{}: {}\n{keys}", preset.name, preset.purpose)
    };
    PRESETS.iter().map(text).collect::<Vec<_>>().join("\n")
}

/// Returns the condition under which a preset leaves a key out, as a phrase; empty if there is none.
fn unless(key: &str) -> String {
    let rival = IN_THE_WAY.iter().find(|(known, _)| *known == key);
    rival.map(|(_, rival)| format!(", unless an option gives {rival}")).unwrap_or_default()
}

impl Preset {
    /// Lays its keys over those of a file. `is_given` returns true if an option gives a key of clouds.
    pub fn apply(&self, overrides: &mut Overrides, is_given: impl Fn(&str) -> bool) -> Result<()> {
        let option = format!("--preset {}", self.name);
        for (key, value) in self.keys {
            if IN_THE_WAY.iter().any(|(known, rival)| known == key && is_given(rival)) {
                continue;
            }
            match key.strip_suffix('+') {
                Some(key) => overrides.append(&option, key, value)?,
                None => overrides.set(&option, key, value)?,
            }
        }
        Ok(())
    }

    /// A phrase for each of its keys, and for the options that it stands for.
    fn settings(&self) -> impl Iterator<Item = String> {
        let key = |(key, value): &(&str, &str)| match key.strip_suffix('+') {
            Some(key) => format!("{key} += {value}"),
            None => format!("{key} = {value}{}", unless(key)),
        };
        let see_through = self.see_through.map(|SeeThrough { share, by }| {
            let when = if by == SeeThroughBy::PresetWithoutClasses { ", for files without classes" } else { "" };
            format!("--see-through {share}{when}, unless an option gives an opacity")
        });
        let view =
            self.from_outside.then(|| "--view iso, unless the scene file or an option places the camera".to_owned());
        self.keys.iter().map(key).chain(see_through).chain(view)
    }

    /// Says which keys it sets, one on a line.
    pub fn note(&self) -> String {
        format!("preset {}:\n  {}", self.name, self.settings().collect::<Vec<_>>().join("\n  "))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use pellucid_scene::{Scene, procedural};

    use super::*;

    fn overrides(preset: &Preset) -> Overrides {
        let mut overrides = Overrides::default();
        preset.apply(&mut overrides, |_| false).unwrap();
        overrides
    }

    #[test]
    fn every_preset_suits_every_built_in_scene() {
        for builtin in procedural::BUILTINS {
            let toml = procedural::build(builtin.name, &[], 0).unwrap().scene_toml;
            for preset in &PRESETS {
                let scene = Scene::from_toml_with(&toml, Path::new(builtin.name), &overrides(preset)).unwrap();
                let entries = preset.keys.iter().filter(|(key, _)| *key == CLASS).count();
                let all = scene.clouds.iter().all(|cloud| cloud.class.len() >= entries);
                assert!(all, "{} {}", preset.name, builtin.name);
            }
        }
    }

    #[test]
    fn the_list_names_every_preset_and_key() {
        let list = list();
        for preset in &PRESETS {
            assert!(list.contains(&format!("{}: {}\n", preset.name, preset.purpose)), "{list}");
            for (key, value) in preset.keys {
                let (key, sign) = key.strip_suffix('+').map_or((*key, "="), |key| (key, "+="));
                assert!(list.contains(&format!("  {key} {sign} {value}")), "{key} {value}: {list}");
                assert!(preset.note().contains(&format!("{key} {sign} {value}")));
            }
        }
    }

    #[test]
    fn names_are_those_of_the_list() {
        assert_eq!(asked("list"), Ok(Asked::List));
        for preset in PRESETS {
            assert_eq!(asked(preset.name), Ok(Asked::Of(preset)));
        }
        assert!(asked("Canopy").unwrap_err().contains("canopy, building, indoor, heritage, model, print"));
    }

    #[test]
    fn keys_in_the_way_of_an_option_are_left_out() {
        let [.., heritage, _, _] = &PRESETS;
        let colored = |given: &[&str]| {
            let mut overrides = Overrides::default();
            heritage.apply(&mut overrides, |key| given.contains(&key)).unwrap();
            let scene = Scene::from_toml_with("[[cloud]]\npath = 'a.ply'", Path::new("s.toml"), &overrides).unwrap();
            (scene.clouds[0].color.is_some(), scene.clouds[0].radius_factor)
        };
        assert_eq!(colored(&[]), (true, 0.8));
        assert_eq!(colored(&["color_by"]), (false, 0.8));
        assert_eq!(colored(&["radius"]), (true, 1.0));
        for preset in &PRESETS {
            let mut overrides = Overrides::default();
            preset.apply(&mut overrides, |key| key == "surface_opacity").unwrap();
            overrides.set("--surface-opacity 0.3", "cloud.*.surface_opacity", "0.3").unwrap();
            Scene::from_toml_with("[[cloud]]\npath = 'a.ply'", Path::new("s.toml"), &overrides).unwrap();
        }
    }
}
