//! Puts a shader's source together from files and what a variant asks for.

use std::collections::HashSet;
use std::fmt::Write as _;

use include_dir::Dir;

use super::network::comparator_text;
use super::{Variant, error};
use crate::{Declaration, Error, Shape};

/// The WGSL of a crate that declares passes, embedded, and the numbers that its shaders share with Rust.
#[derive(Debug)]
pub struct Sources {
    /// The files.
    pub files: Dir<'static>,
    /// Names and values of constants of type u32. A shader that mentions one gets it, and so must not declare it.
    pub constants: &'static [&'static [(&'static str, u32)]],
    /// Names and values of constants of type f32.
    pub floats: &'static [&'static [(&'static str, f32)]],
}

impl Sources {
    /// Returns the shader files by stem (`abuffer/store`), the shared pieces left out.
    pub fn stems(&self) -> Vec<String> {
        let mut found = Vec::new();
        let mut folders = vec![&self.files];
        while let Some(folder) = folders.pop() {
            folders.extend(folder.dirs().filter(|d| !d.path().ends_with("shared")));
            found.extend(folder.files().filter_map(|f| Some(f.path().to_str()?.strip_suffix(".wgsl")?.to_owned())));
        }
        found.sort();
        found
    }

    /// A file; the shared pieces of the device layer serve everybody.
    fn file(&self, stem: &str) -> Option<&str> {
        let name = format!("{stem}.wgsl");
        self.files.get_file(&name).or_else(|| crate::SHADERS.files.get_file(&name))?.contents_utf8()
    }

    /// Names of all constants, and their values as WGSL writes them.
    fn values(&self) -> impl Iterator<Item = (&'static str, String)> {
        let integers = self.constants.iter().copied().flatten().map(|(name, value)| (*name, format!("{value}u")));
        let floats = self.floats.iter().copied().flatten().map(|(name, value)| (*name, format!("{value:?}f")));
        integers.chain(floats)
    }

    /// The constants that a source mentions, as WGSL.
    fn constants_in(&self, source: &str) -> String {
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let code = source.lines().map(|line| line.split("//").next().unwrap_or_default());
        let words: HashSet<&str> = code.flat_map(|line| line.split(|c: char| !is_part(c))).collect();
        let own = (!std::ptr::eq(self, &raw const crate::SHADERS)).then_some(self);
        let mut out = String::new();
        for (name, value) in std::iter::once(&crate::SHADERS).chain(own).flat_map(Self::values) {
            if words.contains(name) {
                let _ = writeln!(out, "const {name} = {value};");
            }
        }
        out
    }
}

/// Returns the whole source of a pass's shader, or of another one that goes with it.
pub(super) fn source(pass: &Declaration, stem: &str, variant: &Variant) -> Result<String, Error> {
    let sources = pass.sources;
    let text = sources.file(stem).ok_or_else(|| error(stem, "no such file under shaders/"))?;
    let mut out = String::new();
    for (name, value) in &variant.constants {
        let _ = writeln!(out, "const {name} = {value};");
    }
    if let Some(size) = variant.subgroup {
        let _ = writeln!(out, "const SUBGROUP = {size}u;");
    }
    out.push_str(&variant.text);
    let (piece, push) = (pass.piece, (pass.push_shape)());
    let composer = Composer { sources, stem, piece, push, variant, out, pasted: Vec::new(), index: None };
    let composed = composer.composed(text)?;
    Ok(sources.constants_in(&composed) + &composed)
}

/// Head of an entry point with the common workgroup.
const MAIN: &str = "@compute @workgroup_size(WG_SIZE)
fn main(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
";

struct Composer<'a> {
    sources: &'a Sources,
    stem: &'a str,
    piece: Option<&'a str>,
    push: Option<Shape>,
    variant: &'a Variant,
    out: String,
    /// Names of the shared pieces that are there.
    pasted: Vec<&'a str>,
    /// Name of the invocation's number among all, if the entry point wants it.
    index: Option<&'a str>,
}

impl<'a> Composer<'a> {
    fn composed(mut self, text: &'a str) -> Result<String, Error> {
        self.paste(text)?;
        match self.index {
            Some(index) if !self.pasted.contains(&"dispatch") => {
                Err(error(self.stem, format!("#main {index} {{ needs #import dispatch")))
            }
            _ => Ok(self.out),
        }
    }

    fn paste(&mut self, text: &'a str) -> Result<(), Error> {
        for line in text.lines() {
            let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
            match word {
                "#import" => self.paste_shared(rest.trim())?,
                "#push" => self.write_push(rest)?,
                "#main" => self.write_main(rest)?,
                "#walker" => self.paste_shared(self.wanted(self.variant.walker, "the variant names no walker")?)?,
                "#piece" => self.paste_shared(self.wanted(self.piece, "the pass names no piece")?)?,
                "#comparators" => self.out.push_str(&comparator_text(self.inputs()?)),
                "#repeat" => self.write_lines(rest, "i", self.inputs()?),
                "#each" => {
                    let (name, line) = rest.split_once(' ').unwrap_or_default();
                    let count = self.variant.counts.iter().find(|(known, _)| *known == name).map(|(_, count)| *count);
                    let missing = || error(self.stem, format!("the variant does not say how often {name:?}"));
                    self.write_lines(line, name, count.ok_or_else(missing)?);
                }
                _ if word.starts_with('#') => return Err(error(self.stem, format!("no directive {word:?}"))),
                _ => {
                    self.out.push_str(line);
                    self.out.push('\n');
                }
            }
        }
        Ok(())
    }

    fn paste_shared(&mut self, name: &'a str) -> Result<(), Error> {
        if self.pasted.contains(&name) {
            return Ok(());
        }
        let shared = self.sources.file(&format!("shared/{name}"));
        self.pasted.push(name);
        self.paste(shared.ok_or_else(|| error(self.stem, format!("no shared piece {name:?}")))?)
    }

    fn write_push(&mut self, rest: &str) -> Result<(), Error> {
        let members = match &self.push {
            _ if !rest.is_empty() || self.out.contains("\nstruct Push {") => {
                return Err(error(self.stem, "#push stands alone on its line, and once"));
            }
            Some(Shape::Struct { members, .. }) => members,
            Some(_) => return Err(error(self.stem, "#push needs a struct of push constants")),
            None => return Err(error(self.stem, "the pass declares no push constants")),
        };
        let members: Vec<String> = members.iter().map(|m| format!("{}: {}", m.name, m.shape.wgsl())).collect();
        let _ = writeln!(self.out, "\nstruct Push {{ {} }}\nvar<immediate> push: Push;", members.join(", "));
        Ok(())
    }

    /// Writes the head of an entry point.
    fn write_main(&mut self, rest: &'a str) -> Result<(), Error> {
        let index = rest.strip_suffix('{').map(str::trim);
        let Some(index) = index.filter(|index| index.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')) else {
            return Err(error(self.stem, format!("#main {rest}: expected #main {{ or #main NAME {{")));
        };
        self.out.push_str(MAIN);
        if !index.is_empty() {
            self.index = Some(index);
            let _ = writeln!(self.out, "    let {index} = invocation_index(workgroup, groups, local);");
        }
        Ok(())
    }

    /// Writes a line `count` times with `{name}` = 0, 1, ….
    fn write_lines(&mut self, line: &str, name: &str, count: u32) {
        let place = format!("{{{name}}}");
        for i in 0..count {
            self.out.push_str(&line.replace(&place, &i.to_string()));
            self.out.push('\n');
        }
    }

    fn inputs(&self) -> Result<u32, Error> {
        self.wanted(self.variant.network, "the variant has no sorting network")
    }

    fn wanted<T>(&self, choice: Option<T>, missing: &str) -> Result<T, Error> {
        choice.ok_or_else(|| error(self.stem, missing))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PushConstants;

    fn composed(text: &str, push: Option<Shape>) -> Result<String, String> {
        let (sources, variant) = (&crate::SHADERS, Variant::plain());
        let (stem, out, pasted) = ("test", String::new(), Vec::new());
        let composer = Composer { sources, stem, piece: None, push, variant: &variant, out, pasted, index: None };
        composer.composed(text).map_err(|e| e.to_string())
    }

    #[test]
    fn directives_that_make_no_sense_are_refused_by_name() {
        crate::gpu_struct! {
            struct Count {
                count: u32,
            }
        }
        let count = Count::push_shape;
        let text = composed("#push\n#main {\n}", count()).expect("push constants and an entry point");
        assert!(text.contains("struct Push { count: u32 }\nvar<immediate> push: Push;\n@compute"), "{text}");
        for (text, push, part) in [
            ("#no", None, "no directive \"#no\""),
            ("#push", None, "the pass declares no push constants"),
            ("#push", Some(Shape::Plain("u32")), "#push needs a struct"),
            ("#push here", count(), "#push stands alone"),
            ("#push\n#push", count(), "and once"),
            ("#main", None, "expected #main {"),
            ("#main i", None, "expected #main {"),
            ("#main a b {", None, "expected #main {"),
            ("#main i {", None, "needs #import dispatch"),
            ("#import nothing", None, "no shared piece \"nothing\""),
            ("#piece", None, "the pass names no piece"),
            ("#walker", None, "the variant names no walker"),
            ("#comparators", None, "no sorting network"),
            ("#each X {X}", None, "how often \"X\""),
        ] {
            let message = composed(text, push).expect_err(part);
            assert!(message.contains(part), "{message:?} should say {part:?}");
        }
    }
}
