//! Corrections to naga's SPIR-V, word by word.

use spirv::{BuiltIn, Decoration, Op, StorageClass};

use super::guard;

const HEADER_WORDS: usize = 5;
/// Instructions whose results are not to be contracted.
const FLOAT_ARITHMETIC: [Op; 14] = [
    Op::FNegate,
    Op::FAdd,
    Op::FSub,
    Op::FMul,
    Op::FDiv,
    Op::FRem,
    Op::FMod,
    Op::VectorTimesScalar,
    Op::MatrixTimesScalar,
    Op::VectorTimesMatrix,
    Op::MatrixTimesVector,
    Op::MatrixTimesMatrix,
    Op::OuterProduct,
    Op::Dot,
];
/// Index of the id bound in the header.
const BOUND: usize = 3;

/// Goes up with each change of the corrections, so that nobody takes what earlier ones left in a cache.
pub const REVISION: u32 = 4;

/// Instructions, each as its opcode and all its words, including the first. Unknown ones count as [`Op::Nop`].
fn instructions(words: &[u32]) -> impl Iterator<Item = (Op, &[u32])> {
    let mut rest = words.get(HEADER_WORDS..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let (instruction, tail) = rest.split_at_checked((first >> 16).max(1) as usize)?;
        rest = tail;
        Some((Op::from_u32(first & 0xffff).unwrap_or(Op::Nop), instruction))
    })
}

fn emit(out: &mut Vec<u32>, opcode: Op, operands: &[u32]) {
    out.push((operands.len() as u32 + 1) << 16 | opcode as u32);
    out.extend_from_slice(operands);
}

/// Returns all corrections.
pub fn correct(words: &[u32]) -> Vec<u32> {
    let words = forbid_contraction(&correct_sample_mask(&drop_array_initializers(words, guard::checks())));
    if guard::checks() { hide_bytes(&words, guard::bytes()) } else { words }
}

/// Subtracts `bytes` from the length of every runtime-sized array: bound ranges end with a guard that is invisible to
/// shaders.
fn hide_bytes(words: &[u32], bytes: u64) -> Vec<u32> {
    let lengths: Vec<&[u32]> = instructions(words).filter(|(op, _)| *op == Op::ArrayLength).map(|(_, i)| i).collect();
    let mut next = words[BOUND];
    let mut fresh = || {
        next += 1;
        next - 1
    };
    // For each length: its instruction, its old id, and the constant to subtract.
    let hidden: Vec<(&[u32], u32, u32, u32)> = lengths
        .into_iter()
        .map(|i| (i, fresh(), fresh(), array_stride(words, i).map_or(0, |stride| (bytes / u64::from(stride)) as u32)))
        .collect();
    let mut out = words[..HEADER_WORDS].to_vec();
    let mut declared = false;
    for (op, instruction) in instructions(words) {
        if op == Op::Function && !declared {
            for (length, _, constant, elements) in &hidden {
                emit(&mut out, Op::Constant, &[length[1], *constant, *elements]);
            }
            declared = true;
        }
        match hidden.iter().find(|(length, ..)| op == Op::ArrayLength && length[2] == instruction[2]) {
            Some((length, whole, constant, _)) => {
                emit(&mut out, Op::ArrayLength, &[length[1], *whole, length[3], length[4]]);
                emit(&mut out, Op::ISub, &[length[1], length[2], *whole, *constant]);
            }
            None => out.extend_from_slice(instruction),
        }
    }
    out[BOUND] = next;
    out
}

/// Bytes from element to element of the array that an OpArrayLength asks about.
fn array_stride(words: &[u32], length: &[u32]) -> Option<u32> {
    let operand = |op: Op, place: usize, id: u32, operand: usize| {
        instructions(words)
            .find(|(found, i)| *found == op && i.get(place) == Some(&id))
            .and_then(|(_, i)| i.get(operand).copied())
    };
    let pointer = operand(Op::Variable, 2, length[3], 1)?;
    let block = operand(Op::TypePointer, 1, pointer, 3)?;
    let array = operand(Op::TypeStruct, 1, block, 2 + length[4] as usize)?;
    let stride = |i: &[u32]| i.len() == 4 && i[1] == array && i[2] == Decoration::ArrayStride as u32;
    instructions(words).find(|(op, i)| *op == Op::Decorate && stride(i)).map(|(_, i)| i[3])
}

/// Decorates all floating-point arithmetic NoContraction, which naga cannot say.
///
/// Without it a driver may fuse a multiplication with an addition in one shader and not in another: the pass that
/// stores fragments would then see other pixels than the one that counted them. Sums of two floats need it anyway.
fn forbid_contraction(words: &[u32]) -> Vec<u32> {
    let results: Vec<u32> =
        instructions(words).filter(|(op, _)| FLOAT_ARITHMETIC.contains(op)).map(|(_, i)| i[2]).collect();
    let mut out = words[..HEADER_WORDS.min(words.len())].to_vec();
    let mut decorated = false;
    for (op, instruction) in instructions(words) {
        // Annotations end where types begin.
        if !decorated && (Op::TypeVoid..=Op::TypeFunction).contains(&op) {
            for id in &results {
                emit(&mut out, Op::Decorate, &[*id, Decoration::NoContraction as u32]);
            }
            decorated = true;
        }
        out.extend_from_slice(instruction);
    }
    out
}

/// Drops the initializer that naga gives function-local arrays of its own accord.
///
/// naga zero-initializes every local variable. For an array of 256 that means 256 stores which lavapipe unrolls: 24 s
/// of compilation against 0.2 s. Only arrays are touched, and not those with values of their own: a scalar's
/// initializer is part of the program.
///
/// A GPU then finds there whatever an earlier shader left, which a CPU driver hardly ever does. So in debug builds
/// short arrays are spoiled instead (`spoil`): a shader that reads an element before it writes one shows it on every
/// driver.
fn drop_array_initializers(words: &[u32], spoil: bool) -> Vec<u32> {
    let arrays: Vec<u32> = instructions(words).filter(|(op, _)| *op == Op::TypeArray).map(|(_, i)| i[1]).collect();
    let pointers: Vec<(u32, u32)> = instructions(words)
        .filter(|(op, i)| *op == Op::TypePointer && i[2] == StorageClass::Function as u32 && arrays.contains(&i[3]))
        .map(|(_, i)| (i[1], i[3]))
        .collect();
    let nulls: Vec<u32> = instructions(words).filter(|(op, _)| *op == Op::ConstantNull).map(|(_, i)| i[2]).collect();
    let mut constants = Spoiled { words, next: words[BOUND], declared: Vec::new() };
    let spoiled: Vec<Option<u32>> =
        pointers.iter().map(|(_, array)| if spoil { constants.of_array(*array) } else { None }).collect();
    let mut out = words[..HEADER_WORDS].to_vec();
    let mut declared = false;
    for (op, instruction) in instructions(words) {
        if op == Op::Function && !declared {
            out.extend_from_slice(&constants.declared);
            declared = true;
        }
        let place = pointers.iter().position(|(pointer, _)| instruction.get(1) == Some(pointer));
        match place.filter(|_| op == Op::Variable && instruction.len() == 5 && nulls.contains(&instruction[4])) {
            Some(place) => {
                let variable: Vec<u32> = instruction[1..4].iter().copied().chain(spoiled[place]).collect();
                emit(&mut out, Op::Variable, &variable);
            }
            None => out.extend_from_slice(instruction),
        }
    }
    out[BOUND] = constants.next;
    out
}

/// Constants that no shader computes with by intention.
struct Spoiled<'a> {
    words: &'a [u32],
    /// The next id.
    next: u32,
    /// Instructions that declare the constants.
    declared: Vec<u32>,
}

impl Spoiled<'_> {
    /// More scalars take drivers long to compile.
    const MOST: u32 = 64;
    /// No number as a float, and no index of anything as an integer.
    const WORD: u32 = u32::MAX;

    /// Returns the constant of an array type; `None` for one that is long, or not of numbers and vectors.
    fn of_array(&mut self, array: u32) -> Option<u32> {
        self.scalars(array).filter(|scalars| *scalars <= Self::MOST)?;
        self.of(array)
    }

    fn of(&mut self, kind: u32) -> Option<u32> {
        let (op, parts) = match self.elements(kind)? {
            (_, 0) => (Op::Constant, vec![Self::WORD]),
            (element, count) => (Op::ConstantComposite, vec![self.of(element)?; count as usize]),
        };
        let id = self.next;
        self.next += 1;
        let operands: Vec<u32> = [kind, id].into_iter().chain(parts).collect();
        emit(&mut self.declared, op, &operands);
        Some(id)
    }

    fn scalars(&self, kind: u32) -> Option<u32> {
        match self.elements(kind)? {
            (_, 0) => Some(1),
            (element, count) => self.scalars(element)?.checked_mul(count),
        }
    }

    /// The type of an array's or a vector's elements and their number; none of a scalar of 32 bits.
    fn elements(&self, kind: u32) -> Option<(u32, u32)> {
        let (op, i) = instructions(self.words)
            .find(|(op, i)| [Op::TypeInt, Op::TypeFloat, Op::TypeVector, Op::TypeArray].contains(op) && i[1] == kind)?;
        match op {
            Op::TypeVector => Some((i[2], i[3])),
            Op::TypeArray => {
                let length = instructions(self.words).find(|(op, c)| *op == Op::Constant && c[2] == i[3])?;
                Some((i[2], length.1[3]))
            }
            _ => (i[2] == 32).then_some((kind, 0)),
        }
    }
}

/// Makes a `sample_mask` variable an array of one u32, as VUID-SampleMask-SampleMask-04359 demands; naga emits a bare
/// u32.
fn correct_sample_mask(words: &[u32]) -> Vec<u32> {
    let masks: Vec<u32> = instructions(words)
        .filter(|(op, i)| {
            *op == Op::Decorate
                && i.len() == 4
                && i[2] == Decoration::BuiltIn as u32
                && i[3] == BuiltIn::SampleMask as u32
        })
        .map(|(_, i)| i[1])
        .collect();
    let uint = instructions(words).find(|(op, i)| *op == Op::TypeInt && i[2] == 32 && i[3] == 0).map(|(_, i)| i[1]);
    let (false, Some(uint)) = (masks.is_empty(), uint) else { return words.to_vec() };
    let mut next = words[BOUND];
    let mut fresh = || {
        next += 1;
        next - 1
    };
    let (one, zero, array) = (fresh(), fresh(), fresh());
    let mut out = words[..HEADER_WORDS].to_vec();
    let mut declared = false;
    for (op, instruction) in instructions(words) {
        let variable = (op == Op::Variable && masks.contains(&instruction[2])).then(|| instruction[3]);
        let accessed = match op {
            Op::Load if masks.contains(&instruction[3]) => Some(instruction[3]),
            Op::Store if masks.contains(&instruction[1]) => Some(instruction[1]),
            _ => None,
        };
        if let Some(storage) = variable {
            if !declared {
                emit(&mut out, Op::Constant, &[uint, one, 1]);
                emit(&mut out, Op::Constant, &[uint, zero, 0]);
                emit(&mut out, Op::TypeArray, &[array, uint, one]);
                declared = true;
            }
            let pointer = fresh();
            emit(&mut out, Op::TypePointer, &[pointer, storage, array]);
            emit(&mut out, Op::Variable, &[pointer, instruction[2], storage]);
        } else if let Some(mask) = accessed {
            let element_pointer = pointer_to(words, mask);
            let element = fresh();
            emit(&mut out, Op::AccessChain, &[element_pointer, element, mask, zero]);
            match op {
                Op::Load => emit(&mut out, Op::Load, &[instruction[1], instruction[2], element]),
                _ => emit(&mut out, Op::Store, &[element, instruction[2]]),
            }
        } else {
            out.extend_from_slice(instruction);
        }
    }
    out[BOUND] = next;
    out
}

/// The pointer type a variable was declared with: after the correction it is the type of the array's element.
fn pointer_to(words: &[u32], variable: u32) -> u32 {
    instructions(words)
        .take_while(|(op, _)| *op != Op::Function)
        .find(|(op, i)| *op == Op::Variable && i[2] == variable)
        .map_or(0, |(_, i)| i[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(words: &[u32], wanted: impl Fn(Op, &[u32]) -> bool) -> usize {
        instructions(words).filter(|(op, i)| wanted(*op, i)).count()
    }

    fn compiled(source: &str) -> Vec<u32> {
        crate::shader::to_spirv("test", source, &[], false).expect("a valid shader")
    }

    const ARRAY: &str = "@group(0) @binding(0) var<storage, read_write> data: array<u32>;
        @compute @workgroup_size(1) fn main() {
            var a: array<u32, 64>;
            var s = 7u;
            for (var i = 0u; i < 64u; i++) { a[i] = data[i]; s += a[63u - i]; }
            data[0] = s;
        }";

    #[test]
    fn array_initializers_are_dropped_and_scalars_keep_theirs() {
        let words = compiled(ARRAY);
        let initialized = |op: Op, i: &[u32]| op == Op::Variable && i.len() == 5;
        let before = count(&words, initialized);
        let after = count(&drop_array_initializers(&words, false), initialized);
        assert!(before >= 2, "the shader has an initialized array and scalar");
        assert_eq!(after, before - 1);
    }

    #[test]
    fn values_that_a_shader_gives_an_array_stay() {
        let words = compiled(
            "@group(0) @binding(0) var<storage, read_write> data: array<f32>;
            @compute @workgroup_size(1) fn main() {
                var slopes = array<f32, 2>(0.0, 0.0);
                if data[0] > 1.0 { slopes[0] = data[1]; }
                data[2] = slopes[u32(data[3])];
            }",
        );
        let initialized = |w: &[u32]| count(w, |op, i| op == Op::Variable && i.len() == 5);
        for spoil in [false, true] {
            assert_eq!(initialized(&drop_array_initializers(&words, spoil)), initialized(&words));
        }
    }

    const LOCAL: &str = "@group(0) @binding(0) var<storage, read_write> data: array<f32>;
        @compute @workgroup_size(1) fn main() {
            var short: array<vec2<f32>, 3>;
            var long: array<u32, 65>;
            for (var i = 0u; i < 3u; i++) { short[i].x = data[i]; long[i] = i; }
            data[0] = short[u32(data[3])].y + f32(long[u32(data[4])]);
        }";

    #[test]
    fn short_arrays_are_spoiled() {
        let words = compiled(LOCAL);
        let spoiled = drop_array_initializers(&words, true);
        // A float, a vector of two and an array of three; the long array has no initializer.
        let added = |op: Op| count(&spoiled, |o, _| o == op) - count(&words, |o, _| o == op);
        assert_eq!((added(Op::Constant), added(Op::ConstantComposite)), (1, 2));
        let initialized = |w: &[u32]| count(w, |op, i| op == Op::Variable && i.len() == 5);
        assert_eq!(initialized(&spoiled), initialized(&words) - 1);
    }

    #[test]
    fn float_arithmetic_is_not_contracted_and_integers_stay() {
        let words = compiled(
            "@group(0) @binding(0) var<storage, read_write> data: array<f32>;
            @compute @workgroup_size(1) fn main() { data[0] = data[1] * data[2] + data[3]; data[4] = f32(7u + u32(data[5])); }",
        );
        let decorated = |w: &[u32]| count(w, |op, i| op == Op::Decorate && i[2] == Decoration::NoContraction as u32);
        assert_eq!(decorated(&words), 0);
        assert_eq!(decorated(&forbid_contraction(&words)), 2);
    }

    const MASK: &str = "struct Out { @location(0) color: vec4<f32>, @builtin(sample_mask) mask: u32 }
        @fragment fn main(@builtin(sample_mask) covered: u32) -> Out {
            return Out(vec4<f32>(1.0), covered & 5u);
        }";

    #[test]
    fn sample_masks_become_arrays_of_one() {
        let words = compiled(MASK);
        let fixed = correct_sample_mask(&words);
        assert_eq!(count(&words, |op, _| op == Op::TypeArray), 0);
        assert_eq!(count(&fixed, |op, _| op == Op::TypeArray), 1);
        // One load of the input and one store of the output, each through an access chain.
        let chains = |w: &[u32]| count(w, |op, _| op == Op::AccessChain);
        assert_eq!(chains(&fixed), chains(&words) + 2);
    }

    const LENGTHS: &str = "struct Wide { a: vec4<f32>, b: f32 }
        @group(0) @binding(0) var<storage, read_write> words: array<u32>;
        @group(0) @binding(1) var<storage, read> wide: array<Wide>;
        @compute @workgroup_size(1) fn main() {
            words[0] = arrayLength(&words) + arrayLength(&wide) + arrayLength(&words);
        }";

    #[test]
    fn lengths_of_arrays_leave_the_guard_out() {
        let words = compiled(LENGTHS);
        let hidden = hide_bytes(&words, 100);
        assert_eq!(count(&hidden, |op, _| op == Op::ArrayLength), 3);
        let constants: Vec<u32> = instructions(&hidden)
            .filter(|(op, _)| *op == Op::ISub)
            .filter_map(|(_, sub)| {
                let is_subtrahend = |op: Op, i: &[u32]| op == Op::Constant && i[2] == sub[4];
                instructions(&hidden).find(|(op, i)| is_subtrahend(*op, i)).map(|(_, i)| i[3])
            })
            .collect();
        // 100 bytes are 25 words, and 3 whole elements of 32 bytes.
        assert_eq!(constants, [25, 3, 25]);
    }

    #[test]
    fn corrections_are_the_same_with_names_and_source() {
        for source in [ARRAY, LOCAL, MASK, LENGTHS] {
            let [plain, debug] = [compiled(source), named(source)];
            assert!(count(&debug, |op, _| op == Op::Name) > 0 && count(&debug, |op, _| op == Op::Line) > 0);
            let counts = |words: &[u32]| {
                let corrected = correct(words);
                let of = |wanted: fn(Op, &[u32]) -> bool| count(&corrected, wanted);
                [
                    of(|op, i| op == Op::Decorate && i[2] == Decoration::NoContraction as u32),
                    of(|op, i| op == Op::Variable && i.len() == 5),
                    of(|op, _| op == Op::TypeArray),
                    of(|op, _| op == Op::AccessChain),
                    of(|op, _| op == Op::ISub),
                ]
            };
            assert_eq!(counts(&plain), counts(&debug));
        }
    }

    /// SPIR-V with names and source.
    fn named(source: &str) -> Vec<u32> {
        crate::shader::to_debug_spirv("test", source).expect("a valid shader")
    }

    /// The number of the validation layers' messages about a shader module.
    fn messages(device: &crate::Device, words: &[u32]) -> usize {
        let before = device.validation_messages().len();
        let info = ash::vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: the layers see the words first; a module that they complain about is destroyed unused.
        unsafe {
            if let Ok(module) = device.0.device.create_shader_module(&info, None) {
                device.0.device.destroy_shader_module(module, None);
            }
        }
        device.validation_messages().len() - before
    }

    #[test]
    fn the_layers_accept_what_is_corrected_and_refuse_a_bare_sample_mask() {
        let options = crate::DeviceOptions::validated();
        let device = match crate::Device::open(&options) {
            Ok(device) => device,
            Err(e) => return pellucid_testing::skip::skip(pellucid_testing::skip::NO_DEVICE, &e.to_string()),
        };
        for source in [ARRAY, LOCAL, MASK, LENGTHS] {
            assert_eq!(messages(&device, &correct(&compiled(source))), 0, "{:?}", device.validation_messages());
            assert_eq!(messages(&device, &correct(&named(source))), 0, "{:?}", device.validation_messages());
        }
        assert!(messages(&device, &compiled(MASK)) > 0);
    }
}
