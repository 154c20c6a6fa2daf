//! Choice of the methods that are followed, and of the exact method for each.

use pellucid_core::points::Points;
use pellucid_engine::plan;
use pellucid_scene::{Discs, Family, GaussianSettings, Method, Order};

/// A method with its setting.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The method to render.
    pub method: Method,
    /// Setting as options of the command line would give it, in addition to `--method`; empty for the scene's own.
    pub setting: String,
}

/// The method whose frames are exact for a method of discs, Gaussians or soft spheres; `None` for others. Gaussians are
/// ordered in each pixel whatever the method's own order is, since an order by centers is what pops.
pub fn exact(method: &Method, points: &Points) -> Option<Method> {
    match plan::exact(method, points)? {
        Method::ABuffer(discs) if points.gaussians.is_some() => Some(Method::ABuffer(ordered(discs, Order::Pixel))),
        found @ (Method::ABuffer(_) | Method::SoftBase(_)) => Some(found),
        _ => None,
    }
}

/// The methods of a scene's image formation with its settings: those named, or all that are not exact. Of Gaussians
/// that are sorted once both orders.
pub fn candidates(method: &Method, points: &Points, only: &[String]) -> Vec<Candidate> {
    let own = |method: Method| Candidate { method, setting: String::new() };
    let mut all = match plan::exact(method, points) {
        Some(Method::ABuffer(discs)) if points.gaussians.is_some() => {
            let family = Family::Discs.methods().map(|method| method.with_keys(&discs.keys()));
            let others = family.filter(|method| !matches!(method, Method::Sorted(_))).map(own);
            sorted(discs).into_iter().chain(others).collect()
        }
        Some(Method::ABuffer(discs)) => {
            Family::Discs.methods().map(|method| own(method.with_keys(&discs.keys()))).collect::<Vec<_>>()
        }
        Some(Method::SoftBase(soft)) => {
            Family::Soft.methods().map(|method| own(method.with_keys(&soft.keys()))).collect()
        }
        _ => Vec::new(),
    };
    all.retain(|candidate| match only {
        [] => !is_exact(&candidate.method, points),
        names => names.iter().any(|name| name == candidate.method.name()),
    });
    all
}

/// Gaussians sorted once, in both ways.
fn sorted(discs: Discs) -> [Candidate; 2] {
    [Order::Center, Order::Distance].map(|order| Candidate {
        method: Method::Sorted(ordered(discs, order)),
        setting: format!("method.order={}", order.word()),
    })
}

fn ordered(discs: Discs, order: Order) -> Discs {
    Discs { gaussians: GaussianSettings { order: Some(order), ..discs.gaussians }, ..discs }
}

/// True if the frames are those of the exact method, except for rounding.
fn is_exact(method: &Method, points: &Points) -> bool {
    let has_gaussians = points.gaussians.is_some();
    let crossing = has_gaussians || points.normals.is_some();
    method.is_exact(crossing) && (!has_gaussians || method.order() == Order::Pixel)
}

#[cfg(test)]
mod tests {
    use pellucid_core::cloud::gaussians::Gaussians;
    use pellucid_scene::Spbr;

    use super::*;

    fn names(method: Method, points: &Points, only: &[&str]) -> Vec<String> {
        let only: Vec<String> = only.iter().map(|name| (*name).to_owned()).collect();
        let name = |c: &Candidate| format!("{} {}", c.method.name(), c.setting).trim_end().to_owned();
        candidates(&method, points, &only).iter().map(name).collect()
    }

    #[test]
    fn exact_methods_are_followed_only_if_they_are_named() {
        let discs = Method::ABuffer(Discs::default());
        let approximate = ["stochastic", "hybrid", "mlab", "moments", "wavelet", "weighted", "average", "unsorted"];
        assert_eq!(names(discs, &Points::default(), &[]), approximate);
        assert_eq!(names(discs, &Points::default(), &["peel", "sorted"]), ["sorted", "peel"]);
        let gaussians = Points { gaussians: Some(Gaussians::default()), ..Points::default() };
        let sorted = ["sorted method.order=center", "sorted method.order=distance"];
        assert_eq!(names(discs, &gaussians, &[]), [&sorted[..], &approximate].concat());
        // An order by centers is not exact, whichever method has it.
        let centers = Method::ABuffer(ordered(Discs::default(), Order::Center));
        assert!(names(centers, &gaussians, &[]).contains(&"abuffer".to_owned()));
        assert_eq!(exact(&centers, &gaussians).unwrap().order(), Order::Pixel);
        assert_eq!(exact(&Method::Spbr(Spbr::default()), &gaussians), None);
        assert_eq!(names(Method::Spbr(Spbr::default()), &gaussians, &[]), Vec::<String>::new());
    }
}
