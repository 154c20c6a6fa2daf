//! Choice of the settings that apply to a scene, with reasons for the others.

use super::{Formation, Ladders, Occasion, Setting, Skipped, ladder};
use pellucid_engine::methods::abuffer::LOCAL_LENGTH;
use pellucid_scene::{self as scene, Density, Family, Key, Ladder, Method, ScreenSplats, Soft, SoftLayout, ValueKind};

/// Points from which levels of detail are compared: fewer are drawn in no time.
const LEAST_FOR_LEVELS: u64 = 1 << 18;

/// The softness as an option, where it is not as the scene has it.
fn softness(soft: &Soft, from_lambda: bool) -> String {
    match soft.density {
        Density::Softness(peak) if from_lambda => format!("method.softness={peak}"),
        _ => String::new(),
    }
}

/// Settings that apply, and those that don't, with the reason.
#[derive(Default)]
struct ApplicableSettings {
    settings: Vec<Setting>,
    skipped: Vec<Skipped>,
}

/// All settings that apply, exact methods first, each ladder ascending; and those that don't, with the reason. Every
/// method is among the ones or the others.
pub fn settings(occasion: &Occasion, ladders: &Ladders) -> (Vec<Setting>, Vec<Skipped>) {
    let mut found = ApplicableSettings::default();
    match occasion.formation {
        Formation::Discs(discs) => {
            for method in Family::Discs.methods() {
                found.try_all(occasion, ladders, method.with_keys(&discs.keys()), "");
            }
            found.circles(occasion);
        }
        Formation::Ensembles(spbr) => {
            found.try_all(occasion, ladders, Method::Spbr(spbr), "");
            let reason = "its opacity depends on the number of ensembles, so there is no single image to compare with";
            found.skip(Method::SpbrSimplified(Default::default()), reason);
        }
        Formation::Soft { soft, from_lambda } => {
            let rest = softness(&soft, from_lambda);
            for method in Family::Soft.methods() {
                found.try_all(occasion, ladders, method.with_keys(&soft.keys()), &rest);
            }
        }
        Formation::Surfaces(surfaces) => (found.settings, found.skipped) = ladder::settings(&surfaces, ladders),
    }
    found.levels(occasion, ladders);
    found.skip_the_others(&occasion.formation);
    (found.settings, found.skipped)
}

/// Limit on radii in pixels that is above those of all discs of an image, but for discs that cover it whole.
const UNCLAMPED: f32 = 1e9;

impl ApplicableSettings {
    fn skip(&mut self, method: Method, reason: &str) {
        self.skipped.push(Setting::single(method, "").skipped(reason));
    }

    /// A method as it is, and by every other setting that is compared, each with the ladder of its key.
    fn try_all(&mut self, occasion: &Occasion, ladders: &Ladders, method: Method, rest: &str) {
        self.climb(occasion, ladders, method, rest);
        for also in method.also() {
            let Some((key, value)) = also.split_once('=') else { continue };
            let text = format!("method.{also} {rest}").trim_end().to_owned();
            let other = method.with(key, value_of(value)).unwrap_or(method);
            match pointless(occasion, &other, also) {
                Some(reason) => self.skipped.push(Setting::single(other, &text).skipped(reason)),
                None => self.climb(occasion, ladders, other, &text),
            }
        }
    }

    /// A method with every value of the key that is compared, if it has one; and with its default, if that is none of
    /// them.
    fn climb(&mut self, occasion: &Occasion, ladders: &Ladders, method: Method, rest: &str) {
        let applies = |ladder: &Ladder| ladder.only.is_empty() || ladder.only.contains(&method.name());
        let compared = method.keys().into_iter().find_map(|key| key.tried.filter(applies).map(|ladder| (key, ladder)));
        let Some((key, ladder)) = compared else {
            self.settings.push(Setting::single(method, rest));
            return;
        };
        let longest = occasion.max_list;
        let mut reached = false;
        for value in ladders.steps(&ladder) {
            let Ok(stepped) = method.with(key.name, scene::Setting::Integer(*value)) else { continue };
            let setting = Setting {
                effort: Some(value.div_ceil(ladder.at_once).into()),
                ..Setting::step(stepped, (key.name, *value), rest)
            };
            if reached {
                let reason = format!(
                    "the longest list has {longest} fragments, and the previous step already holds all of them"
                );
                self.skipped.push(setting.skipped(reason));
            } else {
                reached = ladder.ends_at_longest_list && *value >= longest;
                self.settings.push(setting);
            }
        }
        self.settings.extend(on_top(occasion, method, &key, &ladder, rest));
    }

    /// Opaque discs that face the screen: without the clamp of opaque splats their image is that of the A-buffer.
    fn circles(&mut self, occasion: &Occasion) {
        let unclamped = ScreenSplats { max_pixel_radius: UNCLAMPED, ..ScreenSplats::default() };
        let circles = Setting::single(Method::Circles(unclamped), &format!("method.max_pixel_radius={UNCLAMPED:e}"));
        if !occasion.opaque {
            self.skipped.push(circles.skipped("draws opaque discs, but some of this scene are transparent"));
        } else if occasion.oriented {
            self.skipped.push(circles.skipped("draws discs that face the screen, but those of this scene don't"));
        } else {
            // Before the ladders, with the other exact ones.
            let at = self.settings.iter().position(|setting| setting.step.is_some()).unwrap_or(self.settings.len());
            self.settings.insert(at, circles);
        }
    }

    /// Levels of detail of the methods that draw all points exactly, or of opaque points of their own size: of clouds
    /// that are large enough for it to matter.
    fn levels(&mut self, occasion: &Occasion, ladders: &Ladders) {
        let (methods, rest) = match occasion.formation {
            Formation::Discs(discs) => (vec![Method::ABuffer(discs), Method::Sorted(discs)], String::new()),
            Formation::Soft { soft, from_lambda } => (vec![Method::SoftBase(soft)], softness(&soft, from_lambda)),
            Formation::Surfaces(surfaces) => (vec![Method::Circles(surfaces.sized(1.0))], "method.size=1".to_owned()),
            Formation::Ensembles(_) => return,
        };
        if occasion.points < LEAST_FOR_LEVELS {
            return;
        }
        for method in methods {
            self.settings.extend(ladders.spacings.iter().map(|px| Setting::spaced(method, *px, &rest)));
            let some = |one_of: &u32| u32::try_from(occasion.points / u64::from(*one_of)).unwrap_or(u32::MAX);
            self.settings.extend(ladders.one_of.iter().map(|one_of| Setting::limited(method, some(one_of), &rest)));
        }
    }

    /// The methods that draw something else.
    fn skip_the_others(&mut self, formation: &Formation) {
        for method in Method::all() {
            let name = method.name();
            let is_tried = self.settings.iter().any(|setting| setting.method.name() == name);
            if !is_tried && self.skipped.iter().all(|skipped| skipped.method != name) {
                self.skip(method, why_not(formation, method.family()));
            }
        }
    }
}

/// The default of a key whose values are compared, where it is none of them: all layers, adaptive shells.
fn on_top(occasion: &Occasion, method: Method, key: &Key, ladder: &Ladder, rest: &str) -> Option<Setting> {
    match (&key.value, key.kind) {
        (Some(scene::Setting::Integer(0)), _) => {
            let effort = ladder.ends_at_longest_list.then(|| occasion.max_list.into());
            Some(Setting { effort, ..Setting::single(method, rest) })
        }
        (None, ValueKind::WordOr(word, _)) => {
            let text = format!("method.{}={word} {rest}", key.name);
            Some(Setting::single(method, text.trim_end()))
        }
        _ => None,
    }
}

fn value_of(text: &str) -> scene::Setting {
    match (text.parse(), text.parse()) {
        (Ok(flag), _) => scene::Setting::Flag(flag),
        (_, Ok(number)) => scene::Setting::Number(number),
        _ => scene::Setting::Word(text.to_owned()),
    }
}

/// Returns the reason why a setting would draw nothing else, or can't draw this scene.
fn pointless(occasion: &Occasion, method: &Method, also: &str) -> Option<String> {
    let longest = occasion.max_list;
    match (also, method.soft()) {
        ("long_lists=in-place", _) if longest <= LOCAL_LENGTH => {
            Some(format!("the longest list has {longest} fragments, so none is long"))
        }
        (_, Some(Soft { layout: SoftLayout::Paper, modulation: Some(_), .. })) => {
            Some("does not store what method.modulation needs".to_owned())
        }
        _ => None,
    }
}

/// Returns the reason why a family of methods is not compared with an image formation.
fn why_not(formation: &Formation, family: Family) -> &'static str {
    match (formation, family) {
        (Formation::Ensembles(_), Family::Discs) => {
            "draws discs that cover each other, each with the opacity that spbr gives to their surface"
        }
        (Formation::Surfaces(_), Family::Opaque) => "is not among those whose surfaces are compared",
        (_, Family::Opaque) => "draws opaque points of another shape: its image is not meant to be the same",
        (Formation::Surfaces(_), Family::Surfaces | Family::OneLayer) => {
            "draws transparent layers, which is another image formation"
        }
        (_, Family::Surfaces) => "draws surfaces of points, which is another image formation",
        (_, Family::Discs) => "draws transparent discs, which is another image formation",
        (_, Family::Soft) => "draws soft spheres, which is another image formation",
        (_, Family::OneLayer) => "draws one transparent layer, which is another image formation",
        (_, Family::Ensembles) => "draws transparent surfaces, which is another image formation",
        (_, _) => "draws something else",
    }
}
