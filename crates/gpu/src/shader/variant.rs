//! Choice of one of a shader's variants, and lists of all of them.

use std::collections::{HashMap, HashSet};

use super::{Reflection, check, reflection};
use crate::{Compiled, Declaration, Device, Error, Outputs, Pass};

/// A variant of a shader: values of overrides by name, and text constants.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Variant {
    /// Overrides.
    pub overrides: Vec<(&'static str, f64)>,
    /// Text constants with their WGSL value, as `("CAPACITY", "256u")`.
    pub constants: Vec<(&'static str, String)>,
    /// Declarations that the host writes, put before the source.
    pub text: String,
    /// Inputs of the sorting network that `#comparators` and `#repeat` write out; a power of two.
    pub network: Option<u32>,
    /// The shared piece that stands in for `#walker`: mostly who visits the pixels of splats.
    pub walker: Option<&'static str>,
    /// Names and counts for `#each`.
    pub counts: Vec<(&'static str, u32)>,
    /// Invocations of a subgroup, for shaders whose workgroup is one subgroup or several; also the constant `SUBGROUP`
    /// in WGSL.
    pub subgroup: Option<u32>,
}

impl Variant {
    /// Returns the one variant of a shader that has no choices.
    pub fn plain() -> Self {
        Self::default()
    }

    /// Adds an override.
    pub fn with(mut self, name: &'static str, value: impl Into<f64>) -> Self {
        self.overrides.push((name, value.into()));
        self
    }

    /// Adds a text constant of type u32.
    pub fn constant(mut self, name: &'static str, value: u32) -> Self {
        self.constants.push((name, format!("{value}u")));
        self
    }

    /// Adds declarations.
    pub fn text(mut self, text: &str) -> Self {
        self.text.push_str(text);
        self
    }

    /// Sets the size of the sorting network.
    pub fn network(mut self, inputs: u32) -> Self {
        self.network = Some(inputs);
        self
    }

    /// Sets the walker.
    pub fn walker(mut self, name: &'static str) -> Self {
        self.walker = Some(name);
        self
    }

    /// Sets how often `#each name` writes its lines.
    pub fn each(mut self, name: &'static str, count: u32) -> Self {
        self.counts.push((name, count));
        self
    }

    /// Sets the size of subgroups.
    pub fn subgroup(mut self, size: u32) -> Self {
        self.subgroup = Some(size);
        self
    }

    /// Returns a key that differs for every variant.
    pub fn key(&self) -> String {
        format!("{self:?}")
    }
}

/// Sizes of subgroups that a device may have.
pub const SUBGROUPS: [u32; 4] = [4, 8, 16, 32];

/// A pass with all its variants.
pub struct Shader {
    /// The pass.
    pub pass: Declaration,
    /// Every variant that is ever run; of numbers that a frame decides some.
    pub variants: Vec<Variant>,
}

impl Shader {
    /// Returns a pass that runs in these variants.
    pub fn new<P: Pass>(variants: impl IntoIterator<Item = Variant>) -> Self {
        let mut known = HashSet::new();
        Self {
            pass: P::DECLARATION,
            variants: variants.into_iter().filter(|variant| known.insert(variant.key())).collect(),
        }
    }

    /// Returns a pass without a choice.
    pub fn plain<P: Pass>() -> Self {
        Self::new::<P>([Variant::plain()])
    }

    /// Compiles its variants and compares them with the declaration.
    ///
    /// # Errors
    /// Returns an error if [`check`] fails.
    pub fn check(&self) -> Result<(), Error> {
        check(&self.pass, &self.variants)
    }

    /// Returns the pass in fewer variants: in all of them together, each pair of values that two overrides have in one
    /// variant of a text occurs, and so does each value.
    pub fn in_pairs_of_choices(self) -> Self {
        let mut numbers = HashMap::new();
        let mut number = |pair| {
            let next = numbers.len();
            *numbers.entry(pair).or_insert(next)
        };
        let mut rest: Vec<(Variant, Vec<usize>)> =
            self.variants.into_iter().map(|v| (v.clone(), pairs(&v).map(&mut number).collect())).collect();
        let mut taken = vec![false; numbers.len()];
        let mut variants = Vec::new();
        // The one with the most pairs that no other has yet, until none has any.
        while let Some(at) = (0..rest.len()).max_by_key(|at| rest[*at].1.len()).filter(|at| !rest[*at].1.is_empty()) {
            let (variant, new) = rest.swap_remove(at);
            new.into_iter().for_each(|pair| taken[pair] = true);
            rest.iter_mut().for_each(|(_, pairs)| pairs.retain(|pair| !taken[*pair]));
            variants.push(variant);
        }
        Self { variants, ..self }
    }

    /// Entry point and overrides of a variant.
    ///
    /// # Errors
    /// Returns an error if [`reflection`] fails.
    pub fn reflection(&self, variant: &Variant) -> Result<Reflection, Error> {
        reflection(&self.pass, variant)
    }

    /// Compiles a variant on a device that was opened for statistics, to draw where there are `outputs`; nothing runs.
    ///
    /// # Errors
    /// The shader does not compile, or the device has no statistics.
    pub fn compiled(&self, device: &Device, variant: &Variant, outputs: Option<Outputs>) -> Result<Compiled, Error> {
        device.compiled(&self.pass, variant, outputs)
    }
}

/// Names and values, as bits, of two overrides.
type Pair = Option<[(&'static str, u64); 2]>;

/// Returns the pairs of choices of a variant, each with its text and the overrides that it sets. A choice pairs with
/// itself as well, and a variant without one has a pair of none.
fn pairs(variant: &Variant) -> impl Iterator<Item = (String, Pair)> {
    let unset = variant.overrides.iter().map(|(name, _)| (*name, 0.0)).collect();
    let text = Variant { overrides: unset, ..variant.clone() }.key();
    let choices: Vec<_> = variant.overrides.iter().map(|(name, value)| (*name, value.to_bits())).collect();
    let of_two = choices.iter().enumerate().flat_map(|(i, a)| choices[i..].iter().map(|b| Some([*a, *b])));
    let all: Vec<Pair> = of_two.chain([None]).collect();
    all.into_iter().map(move |pair| (text.clone(), pair))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_variants_have_every_pair_of_choices_of_each_text() {
        let choices = |names: &'static [&'static str]| {
            (0..1u32 << names.len()).map(move |bits| {
                let on = |i: usize| f64::from(bits >> i & 1);
                names.iter().enumerate().fold(Variant::plain(), |variant, (i, name)| variant.with(name, on(i)))
            })
        };
        const FIVE: &[&str] = &["A", "B", "C", "D", "E"];
        let walked = choices(&FIVE[..2]).map(|variant| variant.walker("walk"));
        let all = Shader {
            pass: crate::Agree::DECLARATION,
            variants: choices(FIVE).chain(walked).chain([Variant::plain()]).collect(),
        };
        let fewer = all.in_pairs_of_choices().variants;
        for (i, a) in FIVE.iter().enumerate() {
            for b in &FIVE[i + 1..] {
                for pair in [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0], [1.0, 1.0]] {
                    let has =
                        |v: &Variant| v.overrides.contains(&(*a, pair[0])) && v.overrides.contains(&(*b, pair[1]));
                    assert!(fewer.iter().any(has), "{a} {b} {pair:?}");
                }
            }
        }
        assert_eq!(fewer.iter().filter(|v| v.walker.is_some()).count(), 4);
        assert!(fewer.contains(&Variant::plain()) && fewer.len() < 16, "{}", fewer.len());
    }
}
