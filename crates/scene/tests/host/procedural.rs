//! The built-in scenes: reproducible, on the grids a PLY file keeps, and with the depth complexity they promise.

use glam::DVec3;
use pellucid_core::cloud::Cloud;
use pellucid_core::color::decode_srgb;
use pellucid_io::volume::Volume;
use pellucid_scene::procedural::{BUILTINS, Error, Generated, build, iso};

use pellucid_testing_host::{Clouds, clouds};

fn set(parameters: &[(&str, f64)]) -> Vec<(String, f64)> {
    parameters.iter().map(|&(name, value)| (name.to_owned(), value)).collect()
}

fn make(name: &str, parameters: &[(&str, f64)], seed: u64) -> Generated {
    build(name, &set(parameters), seed).unwrap()
}

/// Each scene small enough for a test, but random where it can be.
fn small(name: &str, seed: u64) -> Generated {
    match name {
        "garden" => make(name, &[("points", 40_000.0)], seed),
        "tori" => make(name, &[("points", 20_000.0)], seed),
        "volume" => make(name, &[("points", 20_000.0), ("layers", 8.0)], seed),
        "plane" => make(name, &[("points", 20_000.0), ("tilt", 30.0)], seed),
        "planes" => make(name, &[("planes", 3.0), ("points", 2000.0)], seed),
        "spheres" => make(name, &[("count", 50.0)], seed),
        "sign" => make(name, &[("points", 4000.0)], seed),
        "terrain" => make(name, &[("points", 20_000.0)], seed),
        _ => make(name, &[], seed),
    }
}

fn total(scene: &Generated) -> usize {
    scene.clouds.iter().map(|(_, cloud)| cloud.len()).sum()
}

fn toml(scene: &Generated) -> toml::Table {
    scene.scene_toml.parse().unwrap()
}

fn number(value: &toml::Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|i| i as f64)).unwrap()
}

#[test]
fn a_seed_makes_the_scene() {
    for builtin in BUILTINS {
        let first = small(builtin.name, 1);
        assert!(first == small(builtin.name, 1), "{}: the same seed gave another scene", builtin.name);
        assert!(first.clouds != small(builtin.name, 2).clouds, "{}: the seed changes nothing", builtin.name);
    }
}

#[test]
fn defaults_lie_within_their_ranges() {
    for builtin in BUILTINS {
        for p in builtin.parameters {
            assert!((p.min..=p.max).contains(&p.default), "{} {}", builtin.name, p.name);
            assert!(!p.integer || p.default.fract() == 0.0, "{} {}", builtin.name, p.name);
        }
    }
}

#[test]
fn point_counts_are_near_those_asked_for() {
    for points in [1000.0, 20_000.0, 300_000.0] {
        for name in ["garden", "tori", "plane", "sign"] {
            let count = total(&make(name, &[("points", points)], 3)) as f64;
            // The grids are rounded to whole rows, the scan thins at random: a few per cent on small clouds.
            let tolerance = if points < 10_000.0 { 0.15 } else { 0.03 };
            assert!((count / points - 1.0).abs() < tolerance, "{name}: {count} points instead of {points}");
        }
    }
    assert_eq!(total(&make("volume", &[("points", 12_345.0), ("layers", 8.0)], 3)), 12_345);
    assert_eq!(total(&make("terrain", &[("points", 123_456.0)], 3)), 123_456);
    for count in [1, 2, 3, 77] {
        assert_eq!(total(&make("spheres", &[("count", f64::from(count))], 3)), count as usize);
    }
}

fn assert_lossless_as_ply(name: &str, cloud: &Cloud) {
    let n = cloud.len();
    assert!(n > 0, "{name} is empty");
    assert!(cloud.alphas.is_none() && cloud.intensity.is_none() && cloud.scalars.is_empty() && cloud.non_finite == 0);
    for p in &cloud.positions {
        assert!(p.is_finite() && p.as_vec3().as_dvec3() == *p, "{name}: {p} is no float32 position");
    }
    let bytes: Vec<f32> = (0..=255u8).map(|b| decode_srgb(f32::from(b) / 255.0)).collect();
    let colors = cloud.colors.as_ref().unwrap();
    assert_eq!(colors.len(), n);
    for value in colors.iter().flat_map(|c| c.to_array()) {
        assert!(bytes.binary_search_by(|b| b.total_cmp(&value)).is_ok(), "{name}: {value} is no 8-bit color");
    }
    if let Some(normals) = &cloud.normals {
        assert_eq!(normals.len(), n);
        // Rounding of three components to float32.
        assert!(normals.iter().all(|v| (v.as_dvec3().length() - 1.0).abs() < 3e-7), "{name}: a normal is not unit");
    }
    assert!(cloud.classification.as_ref().is_none_or(|c| c.len() == n));
    assert!(cloud.radii.as_ref().is_none_or(|r| r.len() == n && r.iter().all(|r| r.is_finite() && *r > 0.0)));
}

#[test]
fn clouds_survive_ply() {
    for builtin in BUILTINS {
        for (name, cloud) in &small(builtin.name, 4).clouds {
            assert_lossless_as_ply(name, cloud);
        }
    }
}

#[test]
fn scene_files_name_their_clouds_and_known_keys_only() {
    let known = [
        ("image", vec!["size", "background"]),
        ("camera", vec!["eye", "target", "up", "fov_y", "height", "near", "far"]),
        ("shading", vec!["model", "ambient", "diffuse", "specular", "shininess"]),
        ("cloud", vec!["path", "color_by", "opacity", "radius", "class"]),
        ("method", vec!["name", "shape", "falloff"]),
    ];
    for builtin in BUILTINS {
        let scene = small(builtin.name, 5);
        let table = toml(&scene);
        let listed = table["cloud"].as_array().unwrap();
        let paths: Vec<&str> = listed.iter().map(|c| c["path"].as_str().unwrap()).collect();
        let names: Vec<&str> = scene.clouds.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(paths, names, "{}", builtin.name);
        for (section, value) in &table {
            let keys = &known.iter().find(|k| k.0 == section).unwrap_or_else(|| panic!("section {section}")).1;
            let tables: Vec<&toml::Table> = match value {
                toml::Value::Array(a) => a.iter().filter_map(|t| t.as_table()).collect(),
                other => other.as_table().into_iter().collect(),
            };
            for key in tables.iter().flat_map(|t| t.keys()) {
                assert!(keys.contains(&key.as_str()), "{}: {section}.{key}", builtin.name);
            }
        }
    }
}

/// Fragments of every pixel of an orthographic scene that looks along −z at the origin, disc by disc and pixel by
/// pixel from the coverage rule: the pixel's center within the radius, and always the pixel of the disc's center.
fn fragments(scene: &Generated) -> Vec<u32> {
    let table = toml(scene);
    let size = number(&table["image"]["size"][0]) as usize;
    let scale = size as f64 / number(&table["camera"]["height"]);
    let radius = number(&table["cloud"][0]["radius"]) * scale;
    let mut counts = vec![0; size * size];
    for p in &scene.clouds[0].1.positions {
        let (x, y) = (0.5 * size as f64 + scale * p.x, 0.5 * size as f64 - scale * p.y);
        let range =
            |c: f64| ((c - radius - 1.0).floor().max(0.0) as usize)..(((c + radius + 2.0).ceil() as usize).min(size));
        for j in range(y) {
            for i in range(x) {
                let (dx, dy) = (i as f64 + 0.5 - x, j as f64 + 0.5 - y);
                let own = x.floor() == i as f64 && y.floor() == j as f64;
                counts[j * size + i] += u32::from(own || dx * dx + dy * dy <= radius * radius);
            }
        }
    }
    counts
}

#[test]
fn volume_has_the_wanted_mean_layers() {
    for (points, layers) in [(20_000.0, 2.0), (20_000.0, 32.0), (200_000.0, 32.0), (300.0, 100.0), (7.0, 3.0)] {
        let counts = fragments(&make("volume", &[("points", points), ("layers", layers)], 6));
        let covered: Vec<u32> = counts.into_iter().filter(|&c| c > 0).collect();
        let mean = covered.iter().map(|&c| f64::from(c)).sum::<f64>() / covered.len() as f64;
        assert!((mean / layers - 1.0).abs() < 0.05, "{points} points: {mean} layers instead of {layers}");
    }
}

#[test]
fn volume_says_when_no_radius_will_do() {
    // 200 000 points on 410² pixels share pixels even without extent; and 10 points never make 11 layers.
    for (points, layers) in [(200_000.0, 1.0), (10.0, 11.0)] {
        let error = build("volume", &set(&[("points", points), ("layers", layers)]), 6).unwrap_err();
        assert!(matches!(error, Error::OutOfReach { .. }), "{error}");
    }
}

#[test]
fn stack_has_exactly_its_layers_in_every_pixel() {
    for (layers, size) in [(1.0, 1.0), (5.0, 16.0), (64.0, 37.0), (100.0, 64.0)] {
        let scene = make("stack", &[("layers", layers), ("size", size)], 7);
        assert!(fragments(&scene).iter().all(|&c| f64::from(c) == layers), "{layers} layers, {size} pixels");
    }
}

#[test]
fn mosaic_has_exactly_its_layers_in_every_pixel() {
    for (layers, size) in [(1.0, 1.0), (5.0, 16.0), (9.0, 37.0), (20.0, 63.0), (10.0, 65.0)] {
        let scene = make("mosaic", &[("layers", layers), ("size", size)], 7);
        assert!(fragments(&scene).iter().all(|&c| f64::from(c) == layers), "{layers} layers, {size} pixels");
        // No disc lies wholly outside: one more in each direction at most.
        let most = layers * (size / 3.0 + 1.0f64).ceil().powi(2);
        assert!(total(&scene) as f64 <= most, "{} discs", total(&scene));
    }
    let error = build("mosaic", &set(&[("layers", 4096.0), ("size", 4096.0)]), 7).unwrap_err();
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
}

#[test]
fn stack_depths_differ_in_float32_and_lie_between_near_and_far() {
    let scene = make("stack", &[("layers", 100_000.0)], 8);
    let table = toml(&scene);
    let (eye, near, far) = (2.0, number(&table["camera"]["near"]), number(&table["camera"]["far"]));
    let mut depths: Vec<f32> = scene.clouds[0].1.positions.iter().map(|p| (eye - p.z) as f32).collect();
    assert!(!depths.is_sorted(), "the file's order must not be the order of depth");
    depths.sort_by(f32::total_cmp);
    assert!(depths.windows(2).all(|w| w[0] < w[1]));
    assert!(near < f64::from(depths[0]) && f64::from(depths[depths.len() - 1]) < far);
}

#[test]
fn garden_has_its_classes_and_lies_on_the_ground() {
    let scene = make("garden", &[], 9);
    // Within 3% of the half million that is promised.
    assert!((485_000..515_000).contains(&total(&scene)), "{}", total(&scene));
    let classes = |file: &str| {
        let cloud = &scene.clouds.iter().find(|(name, _)| name == file).unwrap().1;
        let mut classes = cloud.classification.clone().unwrap();
        classes.sort_unstable();
        classes.dedup();
        classes
    };
    assert_eq!(classes("ground.ply"), [2, 3, 7]);
    assert_eq!(classes("structure.ply"), [6, 7]);
    assert_eq!(classes("frame.ply"), [6, 7]);
    assert_eq!(classes("furniture.ply"), [6, 7, 64]);
    assert_eq!(classes("wood.ply"), [5, 7]);
    assert_eq!(classes("leaves.ply"), [3, 4, 5, 7]);
    for (name, cloud) in &scene.clouds {
        let classes = cloud.classification.as_ref().unwrap();
        for (p, class) in cloud.positions.iter().zip(classes).filter(|(_, class)| **class != 7) {
            // The lot with its fading edge, and the tallest tree; outliers may lie anywhere.
            assert!(p.x.abs() < 14.0 && p.y.abs() < 14.0 && (-1.0..9.0).contains(&p.z), "{name}: {class} at {p}");
        }
        let strays = classes.iter().filter(|c| **c == 7).count() as f64 / classes.len() as f64;
        assert!(strays < 0.003, "{name}: {strays} are noise");
    }
}

#[test]
fn tori_lie_within_each_other_and_are_closed() {
    let scene = small("tori", 10);
    for ((name, cloud), tube) in scene.clouds.iter().zip([0.15, 0.30, 0.45]) {
        let normals = cloud.normals.as_ref().unwrap();
        for (p, n) in cloud.positions.iter().zip(normals) {
            let ring = DVec3::new(p.x, p.y, 0.0).normalize();
            // Float32 rounding of positions up to 1.45 and of normals.
            assert!(((*p - ring).length() - tube).abs() < 1e-6, "{name}: {p}");
            assert!(((*p - ring) / tube - n.as_dvec3()).length() < 2e-6, "{name}: {p} {n}");
        }
    }
    // Any place of the outer torus is within a radius of a point.
    let radius = number(&toml(&scene)["cloud"][2]["radius"]);
    for i in 0..500 {
        let (u, v) = (f64::from(i) * 0.618, f64::from(i) * 1.414);
        let out = DVec3::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin());
        let place = DVec3::new(u.cos(), u.sin(), 0.0) + 0.45 * out;
        let nearest = scene.clouds[2].1.positions.iter().map(|p| p.distance(place)).fold(f64::INFINITY, f64::min);
        assert!(nearest < radius, "{nearest} from {place}");
    }
}

#[test]
fn plane_is_a_tilted_square() {
    let scene = make("plane", &[("points", 5000.0), ("tilt", 60.0)], 11);
    let cloud = &scene.clouds[0].1;
    let normal = DVec3::new(0.75f64.sqrt(), 0.0, 0.5);
    for p in &cloud.positions {
        // The sine to 2e-10, the position to float32.
        assert!(p.dot(normal).abs() < 2e-7 && p.y.abs() <= 1.0 && p.x.abs() <= 0.5 + 1e-7, "{p}");
    }
    let flat = make("plane", &[("points", 5000.0)], 11);
    assert!(flat.clouds[0].1.positions.iter().all(|p| p.z == 0.0));
}

#[test]
fn a_sign_is_noisy_paper_with_ink_in_a_red_frame() {
    let scene = make("sign", &[("points", 50_000.0), ("noise", 2.0)], 8);
    let (_, cloud) = &scene.clouds[0];
    let spacing = (2.4 * 1.6 / 50_000f64).sqrt();
    let depths = cloud.positions.iter().map(|p| p.z);
    let variance = depths.map(|z| z * z).sum::<f64>() / cloud.len() as f64;
    // Five standard errors of the variance of that many numbers.
    assert!((variance / (2.0 * spacing).powi(2) - 1.0).abs() < 5.0 * (2.0 / 50_000f64).sqrt(), "{variance}");
    // Red at the rim, and nowhere else; dark and light inside.
    let colors = cloud.colors.as_ref().unwrap();
    for (position, color) in cloud.positions.iter().zip(colors) {
        let margin = (1.2 - position.x.abs()).min(0.8 - position.y.abs());
        let red = color.x > 2.0 * color.z && color.x > 2.0 * color.y;
        assert!(red == (margin < 0.03) || (margin - 0.03).abs() < 1e-6, "{position}: {color}");
    }
    let inked = colors.iter().filter(|color| color.max_element() < 0.1).count() as f64 / cloud.len() as f64;
    assert!((0.1..0.3).contains(&inked), "{inked}");
}

#[test]
fn planes_lie_behind_each_other_and_reach_over_the_image() {
    let scene = make("planes", &[("planes", 3.0), ("points", 4000.0), ("opacity", 0.25), ("back", 0.75)], 12);
    let table = toml(&scene);
    assert!(number(&table["camera"]["height"]) < 1.9);
    let opacities: Vec<f64> =
        table["cloud"].as_array().unwrap().iter().map(|cloud| number(&cloud["opacity"])).collect();
    assert_eq!(opacities, [0.25, 0.5, 0.75]);
    for ((name, cloud), z) in scene.clouds.iter().zip([0.0, -0.5, -1.0]) {
        assert!(cloud.positions.iter().all(|p| p.z == z && p.x.abs() <= 1.0 && p.y.abs() <= 1.0), "{name}");
        // A quarter of the points in each quarter: 1000, with a spread of 27.
        let quarter = cloud.positions.iter().filter(|p| p.x > 0.0 && p.y > 0.0).count() as f64;
        assert!((quarter - 1000.0).abs() < 5.0 * 27.4, "{name}: {quarter}");
        assert!(cloud.colors.as_ref().unwrap().windows(2).all(|pair| pair[0] == pair[1]), "{name}");
    }
    let alone = make("planes", &[("planes", 1.0), ("points", 10.0), ("opacity", 0.25)], 12);
    assert!(alone.clouds.len() == 1 && number(&toml(&alone)["cloud"][0]["opacity"]) == 0.25);
    let error = build("planes", &set(&[("planes", 64.0), ("points", 1e8)]), 12).unwrap_err();
    assert!(matches!(error, Error::TooLarge { .. }), "{error}");
}

#[test]
fn wrong_requests_are_explained() {
    let message = |name: &str, parameters: &[(&str, f64)]| build(name, &set(parameters), 1).unwrap_err().to_string();
    let unknown = message("gardn", &[]);
    assert!(unknown.contains("did you mean \"garden\"") && unknown.contains("spheres"), "{unknown}");
    assert!(!message("xyzzy", &[]).contains("did you mean"));
    let parameter = message("stack", &[("layer", 3.0)]);
    assert!(parameter.contains("did you mean \"layers\"") && parameter.contains("opacity"), "{parameter}");
    assert!(message("tori", &[("points", 1e12)]).contains("out of range"));
    assert!(message("plane", &[("tilt", f64::NAN)]).contains("out of range"));
    assert!(message("garden", &[("points", 5000.5)]).contains("whole number"));
}

/// Distances from a place in a grid of so many numbers along each side.
fn distances(count: usize, center: DVec3) -> Volume {
    let at = |i: usize| DVec3::new((i % count) as f64, (i / count % count) as f64, (i / (count * count)) as f64);
    let values = (0..count.pow(3)).map(|i| at(i).distance(center) as f32).collect();
    Volume { dims: [count; 3], values }
}

/// Points of the cloud in cells' sides from the center, and their normals.
fn around(cloud: &Cloud, count: usize, center: DVec3) -> Vec<(DVec3, DVec3)> {
    let half = 0.5 * (count - 1) as f64;
    let normals = cloud.normals.as_ref().unwrap();
    let place = |p: &DVec3| half * *p + DVec3::splat(half) - center;
    cloud.positions.iter().zip(normals).map(|(p, n)| (place(p), n.as_dvec3())).collect()
}

#[test]
fn surfaces_of_a_volume_are_where_its_values_say() {
    let (count, center, radii) = (40, DVec3::new(19.2, 19.7, 19.5), [9.0, 15.0]);
    let volume = distances(count, center);
    let made = iso::build_iso(&volume, &radii, &set(&[("points", 40_000.0)]), 3).unwrap();
    assert!(made == iso::build_iso(&volume, &radii, &set(&[("points", 40_000.0)]), 3).unwrap(), "the same seed");
    assert!(made.clouds != iso::build_iso(&volume, &radii, &set(&[("points", 40_000.0)]), 4).unwrap().clouds);
    assert_eq!(total(&made), 40_000);
    // Values grow outward: the larger sphere is the outer one. Areas are as the radii squared.
    let clouds: Vec<&Cloud> = made.clouds.iter().map(|(_, cloud)| cloud).collect();
    let share = clouds[0].len() as f64 / 40_000.0;
    assert!((share - 225.0 / (225.0 + 81.0)).abs() < 0.003, "{share}");
    for (cloud, radius) in clouds.into_iter().zip([15.0f64, 9.0]) {
        let points = around(cloud, count, center);
        // Between numbers one apart the interpolant of a function is off by an eighth of its second derivatives along
        // the three axes, together 2/r of a distance; a cell reaches √3 farther in. Its gradient is 1, so that the
        // surface is as far off; rounding to float32 is 1e-5 of a cell at most.
        let bound = 0.25 / (radius - 3f64.sqrt()) + 1e-4;
        let n = points.len() as f64;
        for (place, normal) in &points {
            assert!((place.length() - radius).abs() < bound, "{place} of {radius}");
            // Differences two apart are off by a sixth of the third derivatives, at most about 3/r²; their interpolant
            // by 1/(4 r²) and so on: far less than the twentieth that this allows.
            assert!(normal.dot(place.normalize()) > 0.995, "{place}: {normal}");
        }
        // Evenly over the sphere: of each coordinate, uniform on [−r, r] there, 20 bands with the same number of
        // points, within five standard deviations √(2·19) of their mean 19.
        for axis in 0..3 {
            let mut bands = [0f64; 20];
            for (place, _) in &points {
                let at = 10.0 * (place[axis] / place.length() + 1.0);
                bands[(at as usize).min(19)] += 1.0;
            }
            let chi: f64 = bands.iter().map(|found| (found - n / 20.0).powi(2) / (n / 20.0)).sum();
            assert!(chi < 19.0 + 5.0 * 38f64.sqrt(), "axis {axis} of {radius}: {chi}, {bands:?}");
        }
    }
    let table = toml(&made);
    assert_eq!(table["method"]["name"].as_str(), Some("peel-layers"));
    assert_eq!((number(&table["cloud"][0]["opacity"]), number(&table["cloud"][1]["opacity"])), (0.5, 1.0));
    assert_eq!(number(&table["method"]["layers"]), 6.0);
}

#[test]
fn points_off_a_surface_are_noticed() {
    // The test above must be able to fail: it does for the sphere of another value.
    let (count, center) = (40, DVec3::new(19.2, 19.7, 19.5));
    let made = iso::build_iso(&distances(count, center), &[9.3], &set(&[("points", 1000.0)]), 3).unwrap();
    let far = around(&made.clouds[0].1, count, center);
    assert!(far.iter().all(|(place, _)| (place.length() - 9.0).abs() > 0.25 / (9.0 - 3f64.sqrt()) + 1e-4));
    let table = toml(&made);
    assert_eq!((number(&table["cloud"][0]["opacity"]), number(&table["method"]["layers"])), (0.7, 4.0));
}

#[test]
fn values_are_chosen_such_that_surfaces_lie_within_each_other() {
    // High inside: a bell.
    let mut volume = distances(32, DVec3::splat(15.5));
    volume.values.iter_mut().for_each(|value| *value = (20.0 - *value).max(0.0));
    for count in [1usize, 3, 5] {
        let made = iso::build_iso(&volume, &[], &set(&[("points", 5000.0), ("surfaces", count as f64)]), 0).unwrap();
        let radii: Vec<f64> =
            made.clouds.iter().map(|(_, cloud)| around(cloud, 32, DVec3::splat(15.5))[0].0.length()).collect();
        assert!(radii.len() == count && radii.is_sorted_by(|outer, inner| outer > inner), "{radii:?}");
        let opacities: Vec<f64> =
            toml(&made)["cloud"].as_array().unwrap().iter().map(|c| number(&c["opacity"])).collect();
        let expected = match count {
            1 => vec![0.7],
            3 => vec![0.5, 0.3, 1.0],
            _ => vec![0.5, 0.3, 0.3, 0.3, 1.0],
        };
        assert_eq!(opacities, expected);
    }
    let wrong = |values: &[f64], parameters: &[(&str, f64)], part: &str| {
        let error = iso::build_iso(&volume, values, &set(parameters), 0).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    wrong(&[20.5], &[], "from 0 to");
    wrong(&[-1.0], &[], "no surface has the value -1");
    wrong(&[1.0; 9], &[], "9 values");
    wrong(&[1.0], &[("layers", 3.0)], "no parameter \"layers\"");
    wrong(&[1.0], &[("points", 1e12)], "out of range");
    let constant = Volume { dims: [2; 3], values: vec![1.0; 8] };
    assert!(matches!(iso::build_iso(&constant, &[], &[], 0), Err(Error::NoSurface { .. })));
    let nothing = Volume { dims: [2; 3], values: vec![f32::NAN; 8] };
    assert!(matches!(iso::build_iso(&nothing, &[], &[], 0), Err(Error::NoSurface { .. })));
}

#[test]
fn real_volumes_have_nested_surfaces() {
    let subset = [("neghip_32x32x32_uint8.raw", 1.0, [32; 3])];
    let whole = [("hydrogen_64x64x64_float32.raw", 3.0, [64; 3]), ("neghip_64x64x64_uint8.raw", 1.0, [64; 3])];
    let known = |clouds: Clouds| {
        let volumes = if clouds.is_subset() { &subset[..] } else { &whole[..] };
        volumes.iter().map(move |(name, surfaces, dims)| (clouds.folder().join("volumes").join(name), *surfaces, *dims))
    };
    for (path, surfaces, dims) in clouds().into_iter().flat_map(known) {
        let name = path.display();
        let volume = pellucid_io::volume::read(&path, None, None).unwrap();
        assert_eq!(volume.dims, dims);
        let made = iso::build_iso(&volume, &[], &set(&[("points", 20_000.0), ("surfaces", surfaces)]), 0).unwrap();
        assert_eq!((made.clouds.len() as f64, total(&made)), (surfaces, 20_000));
        let is_unit = |normal: &glam::Vec3| (normal.length() - 1.0).abs() < 1e-5;
        assert!(made.clouds.iter().all(|(_, cloud)| cloud.normals.as_ref().unwrap().iter().all(is_unit)), "{name}");
    }
}
