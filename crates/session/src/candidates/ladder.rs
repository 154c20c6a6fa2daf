//! The settings of opaque points.

use super::{Ladders, Setting, Skipped, Surfaces};
use pellucid_scene::{ImageSpace, Iterations, Method, Relief, SplatShape};

/// All of them, cloud after cloud; and the methods of opaque points that are left out.
pub(super) fn settings(surfaces: &Surfaces, ladders: &Ladders) -> (Vec<Setting>, Vec<Skipped>) {
    let settings = ladders.thinning.iter().flat_map(|thinning| of_cloud(surfaces, ladders, *thinning)).collect();
    (settings, skipped(surfaces))
}

fn of_cloud(surfaces: &Surfaces, ladders: &Ladders, thinning: u32) -> Vec<Setting> {
    let rest = if thinning == 1 { String::new() } else { format!("thinning={thinning}") };
    let mut settings = vec![Setting::single(Method::Points, &rest)];
    for method in sized(surfaces) {
        settings.extend(ladders.sizes.iter().map(|size| Setting {
            // The pixels of a splat, plus the fixed cost.
            effort: Some(1.0 + size * size),
            ..Setting::step(method(surfaces, *size), ("size", *size), &rest)
        }));
    }
    let filtered = |count: &u32| {
        let filters =
            ImageSpace { fill: Iterations::Count(*count), occlusion: Iterations::Count(*count), ..surfaces.filters };
        let step = Setting::step(Method::ImageSpace(filters), ("fill+occlusion", *count), &rest);
        Setting { effort: Some(1.0 + f64::from(*count)), ..step }
    };
    settings.extend(ladders.iterations.iter().map(filtered));
    settings.into_iter().map(|setting| Setting { thinning, ..setting }).collect()
}

/// A method for each size.
type Sized = fn(&Surfaces, f64) -> Method;

fn sized(surfaces: &Surfaces) -> Vec<Sized> {
    let mut methods: Vec<Sized> =
        vec![|s, size| Method::Squares(s.sized(size)), |s, size| Method::Circles(s.sized(size)), |s, size| {
            Method::Paraboloid(s.interpolated(size))
        }];
    match surfaces.relief {
        Relief::Cone => methods.push(|s, size| Method::Cone(s.interpolated(size))),
        Relief::Sphere => methods.push(|s, size| Method::Sphere(s.sized(size))),
        Relief::Flat | Relief::Paraboloid => {}
    }
    methods.push(|s, size| Method::Hqs(s.blended(size, s.shape)));
    if surfaces.normals {
        methods.push(|s, size| Method::Splats(s.blended(size, SplatShape::default())));
    }
    methods
}

fn skipped(surfaces: &Surfaces) -> Vec<Skipped> {
    let relief = "its relief is like that of paraboloid; it is compared only if it is the scene's method";
    let others = [
        (Method::Cone(surfaces.interpolated(1.0)), relief, surfaces.relief != Relief::Cone),
        (Method::Sphere(surfaces.splats), relief, surfaces.relief != Relief::Sphere),
        (Method::Splats(Default::default()), "no point has a normal, so the image is that of hqs", !surfaces.normals),
    ];
    let skipped = others.into_iter().filter(|(.., is_skipped)| *is_skipped);
    skipped.map(|(method, reason, _)| Setting::single(method, "").skipped(reason)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_core::points::Points;

    fn ladder_of(method: Method, normals: bool) -> (Vec<Setting>, Vec<Skipped>) {
        let points = Points { normals: normals.then(Vec::new), ..Points::default() };
        settings(&Surfaces::for_method(&method, &points).unwrap(), &Ladders::QUICK)
    }

    #[test]
    fn every_cloud_has_every_ladder() {
        let (all, skipped) = ladder_of(Method::Points, true);
        // Points, three sizes of five methods, three numbers of iterations; of all points and of a sixteenth.
        assert_eq!(all.len(), 2 * (1 + 5 * 3 + 3));
        let keys: Vec<String> = all[..19].iter().map(Setting::key).collect();
        assert_eq!(keys[0], "points");
        assert_eq!(keys[3], "squares method.size=2");
        assert_eq!(keys[18], "image-space method.fill=4 method.occlusion=4");
        let thin: Vec<String> = all[19..].iter().map(Setting::key).collect();
        let same = keys.iter().map(|key| format!("{key} thinning=16"));
        assert_eq!(thin, same.collect::<Vec<_>>());
        assert!(all[..19].iter().all(|s| s.thinning == 1) && all[19..].iter().all(|s| s.thinning == 16));
        assert!(matches!(
            all[18].method,
            Method::ImageSpace(ImageSpace {
                fill: Iterations::Count(4),
                occlusion: Iterations::Count(4),
                smooth: 1,
                ..
            })
        ));
        assert_eq!(all[37].stem(), "image-space-fill-4-occlusion-4-thinning-16");
        let names: Vec<&str> = skipped.iter().map(|skipped| skipped.method.as_str()).collect();
        assert_eq!(names, ["cone", "sphere"]);
    }

    #[test]
    fn names_differ_and_ladders_ascend() {
        let (all, _) = ladder_of(Method::Cone(Default::default()), true);
        assert!(all.iter().any(|setting| setting.method.name() == "cone"));
        let mut keys: Vec<String> = all.iter().map(Setting::key).chain(all.iter().map(Setting::stem)).collect();
        let count = keys.len();
        keys.sort();
        keys.dedup();
        // `points` is key and file name both.
        assert_eq!(keys.len(), count - 1);
        for pair in all.windows(2).filter(|pair| pair[0].series == pair[1].series) {
            assert!(pair[0].effort < pair[1].effort && pair[0].step.unwrap().1 < pair[1].step.unwrap().1, "{pair:?}");
        }
        let (flat, skipped) = ladder_of(Method::Sphere(Default::default()), false);
        assert!(flat.iter().all(|setting| setting.method.name() != "splats"));
        assert!(skipped.iter().any(|skipped| skipped.method == "splats" && skipped.reason.contains("no point")));
    }
}
