//! The methods that a case is run for, by their properties: a new method of a family joins the cases of that family.

use pellucid_scene::{Family, Method, Setting, Soft};

/// The methods of some families with their defaults, family after family.
pub(super) fn of_families(families: &[Family]) -> Vec<Method> {
    families.iter().flat_map(|family| family.methods()).collect()
}

/// Removes the methods that work like another one of them.
pub(super) fn except(like: fn(&Method) -> bool, mut methods: Vec<Method>) -> Vec<Method> {
    methods.retain(|method| !like(method));
    methods
}

/// Sets the number of samples per pixel, where methods take samples.
pub(super) fn with_samples(samples: u32, methods: Vec<Method>) -> Vec<Method> {
    let with = |method: Method| method.with("samples", Setting::Integer(samples)).unwrap_or(method);
    methods.into_iter().map(with).collect()
}

/// The methods of flat discs that are exact for any number of layers.
pub(super) fn with_peel() -> Vec<Method> {
    Family::Discs.methods().filter(|method| method.is_exact(false)).collect()
}

/// Returns the exact methods that keep every fragment, and don't process all points once for each layer.
pub(super) fn exact() -> Vec<Method> {
    with_peel().into_iter().filter(|method| method.key("layers").is_none()).collect()
}

/// The methods of discs that approximate, for any order of the points.
pub(super) fn approximations() -> Vec<Method> {
    let follows_files = |method: &Method| matches!(method, Method::Unsorted(_) | Method::Mlab(_));
    Family::Discs.methods().filter(|method| !method.is_exact(false) && !follows_files(method)).collect()
}

/// A method with the values of these settings, if it is of soft spheres.
pub(super) fn with_soft(method: Method, soft: Soft) -> Method {
    if method.family() == Family::Soft { method.with_keys(&soft.keys()) } else { method }
}

/// A method of discs, with discs in tangent planes.
pub(super) fn tilted(method: Method) -> Method {
    method.with("shape", Setting::Word("oriented".to_owned())).unwrap_or(method)
}
