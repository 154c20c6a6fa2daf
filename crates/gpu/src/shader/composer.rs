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
    pasted: Vec<String>,
    /// Name of the invocation's number among all, if the entry point wants it.
    index: Option<String>,
}

impl Composer<'_> {
    fn composed(mut self, text: &str) -> Result<String, Error> {
        self.paste(text)?;
        match self.index {
            Some(index) if !self.pasted.iter().any(|name| name == "dispatch") => {
                Err(error(self.stem, format!("#main {index} {{ needs #import dispatch")))
            }
            _ => Ok(self.out),
        }
    }

    fn paste(&mut self, text: &str) -> Result<(), Error> {
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
            match word {
                "#import" => self.paste_shared(rest.trim())?,
                "#push" => self.write_push(rest)?,
                "#main" => self.write_main(rest)?,
                "#walker" => self.paste_shared(self.wanted(self.variant.walker, "the variant names no walker")?)?,
                "#piece" => self.paste_shared(self.wanted(self.piece, "the pass names no piece")?)?,
                "#comparators" => self.out.push_str(&comparator_text(self.inputs()?)),
                "#repeat" => self.write_lines(rest, "i", self.inputs()?),
                "#each" => match rest.split_once(' ') {
                    Some((name, line)) => self.write_lines(line, name, self.count(name)?),
                    None => self.paste_each(rest, &mut lines)?,
                },
                _ if word.starts_with('#') => return Err(error(self.stem, format!("no directive {word:?}"))),
                _ => {
                    self.out.push_str(line);
                    self.out.push('\n');
                }
            }
        }
        Ok(())
    }

    /// Pastes the lines up to `#end` as often as the variant says of a name.
    fn paste_each<'t>(&mut self, name: &str, lines: &mut impl Iterator<Item = &'t str>) -> Result<(), Error> {
        let (mut block, mut ended) = (String::new(), false);
        for line in lines.by_ref() {
            ended = line == "#end";
            if ended {
                break;
            }
            block.push_str(line);
            block.push('\n');
        }
        if !ended {
            return Err(error(self.stem, format!("#each {name}: expected #end behind its lines")));
        }
        let place = format!("{{{name}}}");
        (0..self.count(name)?).try_for_each(|i| self.paste(&block.replace(&place, &i.to_string())))
    }

    /// Returns how often `#each` writes what it says of a name.
    fn count(&self, name: &str) -> Result<u32, Error> {
        let known = self.variant.counts.iter().find(|(known, _)| *known == name);
        self.wanted(known.map(|(_, count)| *count), &format!("the variant does not say how often {name:?}"))
    }

    fn paste_shared(&mut self, name: &str) -> Result<(), Error> {
        if self.pasted.iter().any(|pasted| pasted == name) {
            return Ok(());
        }
        let shared = self.sources.file(&format!("shared/{name}"));
        self.pasted.push(name.to_owned());
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
    fn write_main(&mut self, rest: &str) -> Result<(), Error> {
        let index = rest.strip_suffix('{').map(str::trim);
        let Some(index) = index.filter(|index| index.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')) else {
            return Err(error(self.stem, format!("#main {rest}: expected #main {{ or #main NAME {{")));
        };
        self.out.push_str(MAIN);
        if !index.is_empty() {
            let _ = writeln!(self.out, "    let {index} = invocation_index(workgroup, groups, local);");
            self.index = Some(index.to_owned());
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
        let (sources, variant) = (&crate::SHADERS, Variant::plain().each("row", 2).each("column", 2));
        let (stem, out, pasted) = ("test", String::new(), Vec::new());
        let composer = Composer { sources, stem, piece: None, push, variant: &variant, out, pasted, index: None };
        composer.composed(text).map_err(|e| e.to_string())
    }

    #[test]
    fn lines_up_to_end_are_repeated_with_what_they_repeat() {
        let text = "#each row\na{row};\n#each column b{row}{column};\n#end\nc;";
        assert_eq!(composed(text, None).expect("text"), "a0;\nb00;\nb01;\na1;\nb10;\nb11;\nc;\n");
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
            ("#each X\n#end", None, "how often \"X\""),
            ("#each row\n{row}", None, "expected #end"),
            ("#end", None, "no directive \"#end\""),
        ] {
            let message = composed(text, push).expect_err(part);
            assert!(message.contains(part), "{message:?} should say {part:?}");
        }
    }
}
