//! A pass's declaration compared with its shader, as naga's reflection sees that.

use naga::{AddressSpace, ArraySize, ImageClass, ImageDimension, StorageAccess, TypeInner};

use crate::layout::{array_text, struct_text};
use crate::{Access, Binding, Error, Shape};

/// Compares names, numbers, access and types of group 0, and the push constants.
///
/// # Errors
/// If anything differs; with `all_bindings` also if the shader lacks a binding.
pub(super) fn check_declaration(
    stem: &str,
    module: &naga::Module,
    declared: &[Binding],
    push: Option<&Shape>,
    all_bindings: bool,
) -> Result<(), Error> {
    let error = |message: String| Error::Shader { name: stem.to_owned(), message };
    let mut seen = vec![false; declared.len()];
    for (_, variable) in module.global_variables.iter() {
        let name = variable.name.as_deref().unwrap_or_default();
        if variable.space == AddressSpace::Immediate {
            let shape = push.ok_or_else(|| error(format!("{name}: the pass declares no push constants")))?;
            check_type(name, module, variable.ty, shape).map_err(error)?;
            continue;
        }
        let Some(place) = &variable.binding else { continue };
        let index = place.binding as usize;
        let Some(binding) = declared.get(index).filter(|_| place.group == 0) else {
            return Err(error(format!("{name}: the pass has no binding {index} in group {}", place.group)));
        };
        if binding.name != name {
            return Err(error(format!("binding {index} is {name:?} in WGSL and {:?} in the pass", binding.name)));
        }
        let access =
            access_of(variable.space).ok_or_else(|| error(format!("{name}: neither a buffer nor a texture")))?;
        if access != binding.access {
            return Err(error(format!("{name}: {access:?} in WGSL, {:?} in the pass", binding.access)));
        }
        check_type(name, module, element(module, variable.ty), &binding.shape).map_err(error)?;
        seen[index] = true;
    }
    match seen.iter().position(|s| !s) {
        Some(missing) if all_bindings => Err(error(format!("binding {:?} is missing in WGSL", declared[missing].name))),
        _ => Ok(()),
    }
}

fn access_of(space: AddressSpace) -> Option<Access> {
    match space {
        AddressSpace::Uniform => Some(Access::Uniform),
        AddressSpace::Storage { access } if access.contains(StorageAccess::STORE) => Some(Access::ReadWrite),
        AddressSpace::Storage { .. } => Some(Access::Read),
        AddressSpace::Handle => Some(Access::Texture),
        _ => None,
    }
}

/// The element of a runtime-sized array, else the type itself.
fn element(module: &naga::Module, ty: naga::Handle<naga::Type>) -> naga::Handle<naga::Type> {
    match module.types[ty].inner {
        TypeInner::Array { base, size: ArraySize::Dynamic, .. } => base,
        _ => ty,
    }
}

fn check_type(name: &str, module: &naga::Module, ty: naga::Handle<naga::Type>, declared: &Shape) -> Result<(), String> {
    let (found, declared) = (description(module, ty), declared.to_string());
    if found == declared { Ok(()) } else { Err(format!("{name}: {found} in WGSL, {declared} in Rust")) }
}

/// A type in WGSL's words, with the offsets of members, as [`Shape`] displays its own. An atomic counts as its scalar:
/// the host sees no difference.
fn description(module: &naga::Module, ty: naga::Handle<naga::Type>) -> String {
    match &module.types[ty].inner {
        TypeInner::Struct { members, span } => {
            let members = members
                .iter()
                .map(|m| (m.name.as_deref().unwrap_or_default(), m.offset as usize, description(module, m.ty)));
            struct_text(members, *span as usize)
        }
        TypeInner::Array { base, size: ArraySize::Constant(count), stride } => {
            array_text(&description(module, *base), count.get() as usize, *stride as usize)
        }
        inner => plain_name(inner).unwrap_or_else(|| format!("{inner:?}")),
    }
}

/// WGSL's name of a scalar, vector or matrix of 32- or 64-bit components, or of a texture of floats.
fn plain_name(inner: &TypeInner) -> Option<String> {
    let scalar_name = |s: naga::Scalar| match (s.kind, s.width) {
        (naga::ScalarKind::Float, 4) => Some("f32"),
        (naga::ScalarKind::Uint, 4) => Some("u32"),
        (naga::ScalarKind::Uint, 8) => Some("u64"),
        (naga::ScalarKind::Sint, 4) => Some("i32"),
        _ => None,
    };
    match *inner {
        TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => scalar_name(scalar).map(str::to_owned),
        TypeInner::Vector { size, scalar } => Some(format!("vec{}<{}>", size as u8, scalar_name(scalar)?)),
        TypeInner::Matrix { columns, rows, scalar } => {
            Some(format!("mat{}x{}<{}>", columns as u8, rows as u8, scalar_name(scalar)?))
        }
        TypeInner::Image { dim: ImageDimension::D2, arrayed: false, class } => texture_name(class).map(str::to_owned),
        _ => None,
    }
}

/// WGSL's name of a two-dimensional texture.
fn texture_name(class: ImageClass) -> Option<&'static str> {
    match class {
        ImageClass::Sampled { kind: naga::ScalarKind::Float, multi: false } => Some("texture_2d<f32>"),
        ImageClass::Sampled { kind: naga::ScalarKind::Float, multi: true } => Some("texture_multisampled_2d<f32>"),
        ImageClass::Depth { multi: true } => Some("texture_depth_multisampled_2d"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GpuType, gpu_struct};

    const WGSL: &str = "
        struct Inner { at: vec2<f32>, sign: i32, rest: u32 }
        struct All { turn: mat4x4<f32>, groups: array<u32, 3>, count: atomic<u32>, inner: Inner, scale: f32, more: array<u32, 3> }
        @group(0) @binding(0) var<storage, read_write> all: array<All>;
        @compute @workgroup_size(1) fn main() { atomicAdd(&all[0].count, 1u); }";

    gpu_struct! {
        struct Inner {
            at: [f32; 2],
            sign: i32,
            rest: u32,
        }
    }

    /// Compares a struct, one member's type given, with WGSL.
    macro_rules! compared {
        ($turn:ty, $groups:ty, $count:ty, $inner:ty, $scale:ty) => {{
            gpu_struct! {
                struct All {
                    turn: $turn,
                    groups: $groups,
                    count: $count,
                    inner: $inner,
                    scale: $scale,
                    more: [u32; 3],
                }
            }
            let module = naga::front::wgsl::parse_str(WGSL).expect("valid WGSL");
            let binding = Binding { name: "all", access: Access::ReadWrite, shape: All::shape() };
            check_declaration("test", &module, &[binding], None, true).map_err(|e| e.to_string())
        }};
    }

    #[test]
    fn members_are_compared_by_type_and_not_by_place_alone() {
        gpu_struct! {
            struct Signed {
                at: [f32; 2],
                sign: u32,
                rest: u32,
            }
        }
        compared!([[f32; 4]; 4], [u32; 3], u32, Inner, f32).expect("the declaration in earnest");
        gpu_struct! {
            struct Sixteen {
                rows: [[f32; 4]; 4],
            }
        }
        // Each of these lies as the declaration in earnest does: the same names, offsets and size.
        let refusals = [
            (compared!(Sixteen, [u32; 3], u32, Inner, f32), "turn: { rows: mat4x4<f32> at 0 } of 64 bytes at 0"),
            (compared!([[f32; 4]; 4], Three, u32, Inner, f32), "groups: { x: u32 at 0"),
            (compared!([[f32; 4]; 4], [u32; 3], f32, Inner, f32), "count: f32 at 76"),
            (compared!([[f32; 4]; 4], [u32; 3], u32, [u32; 4], f32), "inner: vec4<u32> at 80"),
            (compared!([[f32; 4]; 4], [u32; 3], u32, Signed, f32), "sign: u32 at 8"),
            (compared!([[f32; 4]; 4], [u32; 3], u32, Inner, u32), "scale: u32 at 96"),
        ];
        for (result, part) in refusals {
            let message = result.expect_err(part);
            assert!(message.contains(part) && message.contains("scale: f32 at 96"), "{message:?} should say {part:?}");
        }
    }

    gpu_struct! {
        struct Three {
            x: u32,
            y: u32,
            z: u32,
        }
    }

    #[test]
    fn push_constants_are_compared_by_name_type_and_size() {
        gpu_struct! {
            struct Right {
                count: u32,
            }

            struct Renamed {
                amount: u32,
            }

            struct Longer {
                count: u32,
                more: u32,
            }

            struct Floating {
                count: f32,
            }
        }
        let wgsl = "struct Push { count: u32 } var<immediate> push: Push; @compute @workgroup_size(1) fn main() {}";
        let module = naga::front::wgsl::parse_str(wgsl).expect("valid WGSL");
        let compared = |push: Option<Shape>| {
            check_declaration("test", &module, &[], push.as_ref(), true).map_err(|e| e.to_string())
        };
        compared(Some(Right::shape())).expect("the declaration in earnest");
        let refusals = [
            (Some(Renamed::shape()), "amount"),
            (Some(Longer::shape()), "of 8 bytes"),
            (Some(Floating::shape()), "{ count: u32 at 0 } of 4 bytes in WGSL, { count: f32 at 0 } of 4 bytes in Rust"),
            (None, "no push constants"),
        ];
        for (push, part) in refusals {
            let message = compared(push).expect_err(part);
            assert!(message.contains(part), "{message:?} should say {part:?}");
        }
    }

    #[test]
    fn a_runtime_sized_array_is_its_element_and_a_fixed_one_is_not() {
        let compared = |wgsl: &str| {
            let source = format!(
                "@group(0) @binding(0) var<storage, read> a: {wgsl}; @compute @workgroup_size(1) fn main() {{}}"
            );
            let module = naga::front::wgsl::parse_str(&source).expect("valid WGSL");
            let binding = Binding { name: "a", access: Access::Read, shape: u32::shape() };
            check_declaration("test", &module, &[binding], None, true).map_err(|e| e.to_string())
        };
        compared("array<u32>").expect("its element");
        compared("u32").expect("itself");
        for wrong in ["array<u32, 4>", "array<vec2<u32>>", "array<f32>", "array<array<u32, 3>>"] {
            assert!(compared(wrong).expect_err(wrong).ends_with("in WGSL, u32 in Rust"), "{wrong}");
        }
    }
}
