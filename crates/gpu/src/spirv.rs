//! Corrections to naga's SPIR-V, word by word.

use super::guard;

const OP_VARIABLE: u32 = 59;
const OP_TYPE_INT: u32 = 21;
const OP_TYPE_FLOAT: u32 = 22;
const OP_TYPE_VECTOR: u32 = 23;
const OP_TYPE_ARRAY: u32 = 28;
const OP_TYPE_POINTER: u32 = 32;
const OP_CONSTANT: u32 = 43;
const OP_CONSTANT_COMPOSITE: u32 = 44;
const OP_CONSTANT_NULL: u32 = 46;
const OP_LOAD: u32 = 61;
const OP_STORE: u32 = 62;
const OP_ACCESS_CHAIN: u32 = 65;
const OP_DECORATE: u32 = 71;
const OP_FUNCTION: u32 = 54;
const STORAGE_FUNCTION: u32 = 7;
const DECORATION_BUILT_IN: u32 = 11;
const BUILT_IN_SAMPLE_MASK: u32 = 20;
const OP_TYPE_STRUCT: u32 = 30;
const OP_ARRAY_LENGTH: u32 = 68;
const OP_I_SUB: u32 = 130;
const DECORATION_ARRAY_STRIDE: u32 = 6;
const HEADER_WORDS: usize = 5;
const DECORATION_NO_CONTRACTION: u32 = 42;
/// OpTypeVoid to OpTypeFunction.
const FIRST_TYPES: std::ops::RangeInclusive<u32> = 19..=33;
/// OpFNegate, OpFAdd, OpFSub, OpFMul, OpFDiv, OpFRem, OpFMod, and OpVectorTimesScalar to OpDot.
const FLOAT_ARITHMETIC: [u32; 14] = [127, 129, 131, 133, 136, 140, 141, 142, 143, 144, 145, 146, 147, 148];
/// Index of the id bound in the header.
const BOUND: usize = 3;

/// Goes up with each change of the corrections, so that nobody takes what earlier ones left in a cache.
pub const REVISION: u32 = 3;

/// Instructions, each as its opcode and all its words, including the first.
fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words.get(HEADER_WORDS..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let (instruction, tail) = rest.split_at_checked((first >> 16).max(1) as usize)?;
        rest = tail;
        Some((first & 0xffff, instruction))
    })
}

fn emit(out: &mut Vec<u32>, opcode: u32, operands: &[u32]) {
    out.push((operands.len() as u32 + 1) << 16 | opcode);
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
    let lengths: Vec<&[u32]> = instructions(words).filter(|(op, _)| *op == OP_ARRAY_LENGTH).map(|(_, i)| i).collect();
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
        if op == OP_FUNCTION && !declared {
            for (length, _, constant, elements) in &hidden {
                emit(&mut out, OP_CONSTANT, &[length[1], *constant, *elements]);
            }
            declared = true;
        }
        match hidden.iter().find(|(length, ..)| op == OP_ARRAY_LENGTH && length[2] == instruction[2]) {
            Some((length, whole, constant, _)) => {
                emit(&mut out, OP_ARRAY_LENGTH, &[length[1], *whole, length[3], length[4]]);
                emit(&mut out, OP_I_SUB, &[length[1], length[2], *whole, *constant]);
            }
            None => out.extend_from_slice(instruction),
        }
    }
    out[BOUND] = next;
    out
}

/// Bytes from element to element of the array that an OpArrayLength asks about.
fn array_stride(words: &[u32], length: &[u32]) -> Option<u32> {
    let operand = |op: u32, place: usize, id: u32, operand: usize| {
        instructions(words)
            .find(|(found, i)| *found == op && i.get(place) == Some(&id))
            .and_then(|(_, i)| i.get(operand).copied())
    };
    let pointer = operand(OP_VARIABLE, 2, length[3], 1)?;
    let block = operand(OP_TYPE_POINTER, 1, pointer, 3)?;
    let array = operand(OP_TYPE_STRUCT, 1, block, 2 + length[4] as usize)?;
    let stride = |i: &[u32]| i.len() == 4 && i[1] == array && i[2] == DECORATION_ARRAY_STRIDE;
    instructions(words).find(|(op, i)| *op == OP_DECORATE && stride(i)).map(|(_, i)| i[3])
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
        if !decorated && FIRST_TYPES.contains(&op) {
            for id in &results {
                emit(&mut out, OP_DECORATE, &[*id, DECORATION_NO_CONTRACTION]);
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
    let arrays: Vec<u32> = instructions(words).filter(|(op, _)| *op == OP_TYPE_ARRAY).map(|(_, i)| i[1]).collect();
    let pointers: Vec<(u32, u32)> = instructions(words)
        .filter(|(op, i)| *op == OP_TYPE_POINTER && i[2] == STORAGE_FUNCTION && arrays.contains(&i[3]))
        .map(|(_, i)| (i[1], i[3]))
        .collect();
    let nulls: Vec<u32> = instructions(words).filter(|(op, _)| *op == OP_CONSTANT_NULL).map(|(_, i)| i[2]).collect();
    let mut constants = Spoiled { words, next: words[BOUND], declared: Vec::new() };
    let spoiled: Vec<Option<u32>> =
        pointers.iter().map(|(_, array)| if spoil { constants.of_array(*array) } else { None }).collect();
    let mut out = words[..HEADER_WORDS].to_vec();
    let mut declared = false;
    for (op, instruction) in instructions(words) {
        if op == OP_FUNCTION && !declared {
            out.extend_from_slice(&constants.declared);
            declared = true;
        }
        let place = pointers.iter().position(|(pointer, _)| instruction.get(1) == Some(pointer));
        match place.filter(|_| op == OP_VARIABLE && instruction.len() == 5 && nulls.contains(&instruction[4])) {
            Some(place) => {
                let variable: Vec<u32> = instruction[1..4].iter().copied().chain(spoiled[place]).collect();
                emit(&mut out, OP_VARIABLE, &variable);
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
            (_, 0) => (OP_CONSTANT, vec![Self::WORD]),
            (element, count) => (OP_CONSTANT_COMPOSITE, vec![self.of(element)?; count as usize]),
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
            .find(|(op, i)| [OP_TYPE_INT, OP_TYPE_FLOAT, OP_TYPE_VECTOR, OP_TYPE_ARRAY].contains(op) && i[1] == kind)?;
        match op {
            OP_TYPE_VECTOR => Some((i[2], i[3])),
            OP_TYPE_ARRAY => {
                let length = instructions(self.words).find(|(op, c)| *op == OP_CONSTANT && c[2] == i[3])?;
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
            *op == OP_DECORATE && i.len() == 4 && i[2] == DECORATION_BUILT_IN && i[3] == BUILT_IN_SAMPLE_MASK
        })
        .map(|(_, i)| i[1])
        .collect();
    let uint = instructions(words).find(|(op, i)| *op == OP_TYPE_INT && i[2] == 32 && i[3] == 0).map(|(_, i)| i[1]);
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
        let variable = (op == OP_VARIABLE && masks.contains(&instruction[2])).then(|| instruction[3]);
        let accessed = match op {
            OP_LOAD if masks.contains(&instruction[3]) => Some(instruction[3]),
            OP_STORE if masks.contains(&instruction[1]) => Some(instruction[1]),
            _ => None,
        };
        if let Some(storage) = variable {
            if !declared {
                emit(&mut out, OP_CONSTANT, &[uint, one, 1]);
                emit(&mut out, OP_CONSTANT, &[uint, zero, 0]);
                emit(&mut out, OP_TYPE_ARRAY, &[array, uint, one]);
                declared = true;
            }
            let pointer = fresh();
            emit(&mut out, OP_TYPE_POINTER, &[pointer, storage, array]);
            emit(&mut out, OP_VARIABLE, &[pointer, instruction[2], storage]);
        } else if let Some(mask) = accessed {
            let element_pointer = pointer_to(words, mask);
            let element = fresh();
            emit(&mut out, OP_ACCESS_CHAIN, &[element_pointer, element, mask, zero]);
            match op {
                OP_LOAD => emit(&mut out, OP_LOAD, &[instruction[1], instruction[2], element]),
                _ => emit(&mut out, OP_STORE, &[element, instruction[2]]),
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
        .take_while(|(op, _)| *op != OP_FUNCTION)
        .find(|(op, i)| *op == OP_VARIABLE && i[2] == variable)
        .map_or(0, |(_, i)| i[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count(words: &[u32], wanted: impl Fn(u32, &[u32]) -> bool) -> usize {
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
        let initialized = |op: u32, i: &[u32]| op == OP_VARIABLE && i.len() == 5;
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
        let initialized = |w: &[u32]| count(w, |op, i| op == OP_VARIABLE && i.len() == 5);
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
        let added = |op: u32| count(&spoiled, |o, _| o == op) - count(&words, |o, _| o == op);
        assert_eq!((added(OP_CONSTANT), added(OP_CONSTANT_COMPOSITE)), (1, 2));
        let initialized = |w: &[u32]| count(w, |op, i| op == OP_VARIABLE && i.len() == 5);
        assert_eq!(initialized(&spoiled), initialized(&words) - 1);
    }

    #[test]
    fn float_arithmetic_is_not_contracted_and_integers_stay() {
        let words = compiled(
            "@group(0) @binding(0) var<storage, read_write> data: array<f32>;
            @compute @workgroup_size(1) fn main() { data[0] = data[1] * data[2] + data[3]; data[4] = f32(7u + u32(data[5])); }",
        );
        let decorated = |w: &[u32]| count(w, |op, i| op == OP_DECORATE && i[2] == DECORATION_NO_CONTRACTION);
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
        assert_eq!(count(&words, |op, _| op == OP_TYPE_ARRAY), 0);
        assert_eq!(count(&fixed, |op, _| op == OP_TYPE_ARRAY), 1);
        // One load of the input and one store of the output, each through an access chain.
        let chains = |w: &[u32]| count(w, |op, _| op == OP_ACCESS_CHAIN);
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
        assert_eq!(count(&hidden, |op, _| op == OP_ARRAY_LENGTH), 3);
        let constants: Vec<u32> = instructions(&hidden)
            .filter(|(op, _)| *op == OP_I_SUB)
            .filter_map(|(_, sub)| {
                let is_subtrahend = |op: u32, i: &[u32]| op == OP_CONSTANT && i[2] == sub[4];
                instructions(&hidden).find(|(op, i)| is_subtrahend(*op, i)).map(|(_, i)| i[3])
            })
            .collect();
        // 100 bytes are 25 words, and 3 whole elements of 32 bytes.
        assert_eq!(constants, [25, 3, 25]);
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
        }
        assert!(messages(&device, &compiled(MASK)) > 0);
    }
}
