//! Scene files and options: what is read, what is refused and where; points and cameras of a scene.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3, Vec3};
use pellucid_engine::camera::{Camera, Projection};
use pellucid_engine::cloud::field::Field;
use pellucid_engine::cloud::{Cloud, UpAxis};
use pellucid_engine::points::Points;
use pellucid_engine::progress::Progress;
use pellucid_engine::scene::*;

const CLOUD: &str = "[[cloud]]\npath = \"a.ply\"\n";

fn read(text: &str) -> Result<Scene, Error> {
    Scene::from_toml(text, Path::new("dir/s.toml"))
}

/// A scene of one cloud and `text` before it.
fn with_cloud(text: &str) -> Scene {
    read(&format!("{text}\n{CLOUD}")).unwrap()
}

/// The message for a text that must be refused with status 2.
fn refused(text: &str) -> String {
    let error = read(text).expect_err(text);
    assert_eq!(error.exit_status(), 2, "{error}");
    error.to_string()
}

fn overridden(text: &str, pairs: &[&str]) -> Result<Scene, Error> {
    let mut overrides = Overrides::default();
    for pair in pairs {
        overrides.set_pair(pair)?;
    }
    Scene::from_toml_with(text, Path::new("s.toml"), &overrides)
}

#[test]
fn defaults_are_those_of_the_contract() {
    let scene = read(CLOUD).unwrap();
    assert_eq!(scene.image, ImageSettings { size: [1024, 1024], background: Vec3::ZERO, color: ColorSpace::Linear });
    assert_eq!(scene.method, MethodChoice::default());
    assert_eq!(scene.shading, Shading::default());
    let cloud = &scene.clouds[0];
    assert_eq!(cloud.path, PathBuf::from("dir/a.ply"), "relative to the scene file");
    assert_eq!((cloud.opacity, cloud.radius, cloud.scale), (1.0, None, 1.0));
    assert_eq!((cloud.neighbors, &cloud.field), (None, &None), "24 and uncertainty, unless a prepared file says more");
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn every_key_of_the_contract_is_read() {
    let scene = read(
        r#"
        [image]
        size = [640, 480]
        background = [0.0, 0.5, 1]
        color = "encoded"
        [camera]
        eye = [0.0, 0.0, 5.0]
        target = [0, 0, 0]
        up = [0.0, 1.0, 0.0]
        fov_y = 30.0
        near = 0.01
        far = 100.0
        [shading]
        model = "phong"
        ambient = 0.1
        diffuse = 0.7
        specular = 0.2
        shininess = 8
        light = { position = [1.0, 2.0, 3.0] }
        [[cloud]]
        path = "/abs/scan.laz"
        color = [1.0, 0.5, 0.25]
        opacity = 0.3
        radius = 0.01
        neighbors = 12
        translate = [500000.0, 4500000.0, 100.0]
        scale = 2.0
        [method]
        name = "abuffer"
        shape = "oriented"
        falloff = "gaussian"
        raster = "compute"
        long_lists = "in-place"
        "#,
    )
    .unwrap();
    assert_eq!(scene.image.size, [640, 480]);
    assert_eq!(scene.image.color, ColorSpace::Encoded);
    assert_eq!(scene.camera.eye, Some(DVec3::new(0.0, 0.0, 5.0)));
    assert_eq!((scene.camera.near, scene.camera.far, scene.camera.fov_y), (Some(0.01), Some(100.0), Some(30.0)));
    assert_eq!(scene.shading.light, Light::Position(DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(scene.shading.model, ShadingModel::Phong);
    let cloud = &scene.clouds[0];
    assert_eq!(cloud.path, PathBuf::from("/abs/scan.laz"));
    assert_eq!((cloud.color, cloud.radius), (Some(Vec3::new(1.0, 0.5, 0.25)), Some(0.01)));
    assert_eq!(cloud.translate, DVec3::new(500_000.0, 4_500_000.0, 100.0));
    let discs = Discs {
        shape: DiscShape::Oriented,
        falloff: Falloff::Gaussian,
        raster: Raster::Compute,
        long_lists: LongLists::InPlace,
    };
    assert_eq!(scene.method, Method::ABuffer(discs).into());
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn an_unknown_key_names_line_column_and_the_nearest_key() {
    let message = refused("[[cloud]]\npath = \"a.ply\"\n  opactiy = 0.5\n");
    assert_eq!(message, "dir/s.toml:3:3: unknown key `cloud.0.opactiy`; did you mean `opacity`?");
    assert!(refused("[imge]\n").starts_with("dir/s.toml:1:2: unknown key `imge`; did you mean `image`?"));
    assert!(refused(&format!("[method]\nname = \"abuffer\"\nshap = \"flat\"\n{CLOUD}")).contains(":3:1: "));
    assert!(refused("[shading]\nlight = { positon = [0, 0, 1] }").contains("did you mean `position`?"));
}

#[test]
fn wrong_values_name_line_column_and_what_was_expected() {
    let cases = [
        ("[image]\nsize = [0, 4]", "s.toml:2:9: `image.size` must be an integer from 1 to 16384, found 0"),
        ("[image]\nsize = [4.0, 4]", "s.toml:2:9: `image.size` must be an integer"),
        ("[image]\nsize = [4]", "s.toml:2:8: `image.size` must be an array of 2"),
        ("[image]\nsize = [16, 16385]", "s.toml:2:13: `image.size` must be an integer from 1 to 16384, found 16385"),
        ("[image]\nbackground = [0, nan, 0]", ":2:18: `image.background` must be a number from 0.0 to 1.0, found NaN"),
        ("[image]\ncolor = \"srgb\"", "must be one of \"linear\", \"encoded\", found the string \"srgb\""),
        ("image = 3", "s.toml:1:9: `image` must be a table, found 3"),
        ("[camera]\neye = [0, 0, inf]", ":2:14: `camera.eye` must be a number"),
        ("[camera]\nfov_y = 180", "between 0 and 180, both excluded, found 180"),
        ("[camera]\nheight = 0.0", "`camera.height` must be a number above 0"),
        ("[camera]\nnear = 2\nfar = 1", ":2:8: `camera.near` must lie below `camera.far`"),
        ("[camera]\nup = [0, 0, 0]", "`camera.up` must be a direction"),
        ("[shading]\nambient = -0.1", "`shading.ambient` must be a number of at least 0, found -0.1"),
        ("[shading]\nambient = 1e39", "does not fit into float32"),
        ("[shading]\nlight = [0, 0, 0]", "`shading.light` must be a direction"),
        ("[shading]\nlight = \"sun\"", "`shading.light` must be \"headlight\""),
        (
            "[[cloud]]\npath = \"a\"\nopacity = 1.5",
            ":3:11: `cloud.0.opacity` must be a number from 0.0 to 1.0, found 1.5",
        ),
        ("[[cloud]]\npath = \"a\"\nopacity = \"x\"", "found the string \"x\""),
        ("[[cloud]]\npath = \"a\"\nneighbors = 0", "`cloud.0.neighbors` must be an integer from 1"),
        ("[[cloud]]\npath = \"a\"\nscale = -1", "`cloud.0.scale` must be a number above 0"),
        ("[[cloud]]\npath = \"a\"\ncolumns = \"x,y\"", "`cloud.0.columns` names columns: no `z` in \"x,y\""),
        ("[[cloud]]\npath = \"a\"\ncolumns = [\"x\"]", "`cloud.0.columns` must be a string"),
        ("[[cloud]]\npath = 3", "`cloud.0.path` must be a string"),
        ("[[cloud]]\npath = \"a\"\nsoft_classes = [256]", "`cloud.0.soft_classes` must be an integer from 0 to 255"),
        ("[[cloud]]\npath = \"a\"\naxis = { direction = [0,0,0] }", "`cloud.0.axis.direction` must be a direction"),
        ("[cloud]\npath = \"a\"", "must be written as [[cloud]]"),
        ("[method]\nname = 3", "`method.name` must be a string"),
    ];
    for (text, expected) in cases {
        let message = refused(text);
        assert!(message.contains(expected), "{text:?}: {message}");
    }
}

#[test]
fn contradictions_are_refused() {
    let cases = [
        ("[camera]\nfov_y = 45\nheight = 2.0", ":3:10: `camera.fov_y` (perspective) and `camera.height`"),
        ("[camera]\neye = [1, 2, 3]\ntarget = [1.0, 2, 3]", ":3:10: `camera.eye` and `camera.target` are the same"),
        ("[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 0, 2]", ":4:6: `camera.up`"),
        ("[[cloud]]\nopacity = 0.5", "a [[cloud]] needs `path`"),
        ("[image]", "there is no cloud"),
    ];
    for (text, expected) in cases {
        let message = refused(text);
        assert!(message.contains(expected), "{text:?}: {message}");
    }
    assert!(refused(&format!("[method]\nlambda = 1\nsoftness = 0.5\n{CLOUD}")).contains("`method.lambda` and"));
}

#[test]
fn syntax_errors_name_line_and_column() {
    assert!(refused("[image]\nsize = [1, 2\n").starts_with("dir/s.toml:"));
    let message = refused("[image]\nsize = = 3\n");
    assert!(message.starts_with("dir/s.toml:2:8: "), "{message}");
}

#[test]
fn unknown_methods_are_named_with_what_may_be_meant() {
    let message = refused(&format!("[method]\nname = \"photons\"\n{CLOUD}"));
    assert!(message.starts_with("dir/s.toml:2:8: unknown method \"photons\""), "{message}");
    assert!(METHODS.iter().all(|name| message.contains(name)), "{message}");
    assert!(refused(&format!("[method]\nname = \"abufer\"\n{CLOUD}")).contains("did you mean `abuffer`?"));
}

#[test]
fn every_method_is_read_by_its_name() {
    for name in METHODS {
        assert_eq!(with_cloud(&format!("[method]\nname = \"{name}\"")).method.name(), *name);
    }
}

#[test]
fn filters_have_their_defaults_and_limits() {
    let of = |keys: &str| with_cloud(&format!("[method]\n{keys}")).method;
    assert_eq!(of("name = \"image-space\""), Method::ImageSpace(ImageSpace::default()).into());
    assert_eq!(of("name = \"peel-layers\""), Method::PeelLayers(PeelLayers::default()).into());
    let filters = ImageSpace {
        fill: 0,
        occlusion: 256,
        smooth: 2,
        antialias: false,
        antialias_threshold: 0.5,
        min_layer_distance: Some(0.25),
        cull: true,
    };
    let keys = "fill = 0\nocclusion = 256\nsmooth = 2\nantialias = false\nantialias_threshold = 0.5\n\
                min_layer_distance = 0.25\ncull = true";
    assert_eq!(of(&format!("name = \"image-space\"\n{keys}")), Method::ImageSpace(filters).into());
    let layers = format!("name = \"peel-layers\"\nlayers = 1024\n{keys}");
    assert_eq!(of(&layers), Method::PeelLayers(PeelLayers { filters, layers: 1024 }).into());
    for wrong in ["fill = 257", "smooth = -1", "antialias_threshold = 1.5", "min_layer_distance = 0", "layers = 0"] {
        let message = refused(&format!("[method]\nname = \"peel-layers\"\n{wrong}\n{CLOUD}"));
        assert!(message.starts_with("dir/s.toml:3:"), "{wrong}: {message}");
    }
}

#[test]
fn layers_to_peel_are_a_whole_number_within_the_limit() {
    let peel = |layers| with_cloud(&format!("[method]\nname = \"peel\"\nfalloff = \"gaussian\"{layers}")).method;
    let discs = Discs { falloff: Falloff::Gaussian, ..Discs::default() };
    assert_eq!(peel(""), Method::Peel(Peel { discs, layers: 0 }).into());
    assert_eq!(peel("\nlayers = 65536"), Method::Peel(Peel { discs, layers: 65_536 }).into());
    for wrong in ["65537", "-1", "1.5"] {
        let message = refused(&format!("[method]\nname = \"peel\"\nlayers = {wrong}\n{CLOUD}"));
        assert!(message.contains("`method.layers` must be an integer from 0 to 65536"), "{message}");
    }
}

#[test]
fn keys_of_other_methods_warn_and_keys_of_none_are_refused() {
    let scene = with_cloud("[method]\nname = \"circles\"\nsize = 2.0\nlayers = 4");
    assert_eq!(scene.method, Method::Circles(ScreenSplats { size: 2.0, ..ScreenSplats::default() }).into());
    let [warning] = scene.warnings.as_slice() else { panic!("{:?}", scene.warnings) };
    assert!(
        warning.contains(":4:1: method \"circles\" does not use `layers` (a key of peel, peel-layers)"),
        "{warning}"
    );
    assert_eq!(with_cloud("[method]\nname = \"points\"\nsize = 2").warnings.len(), 1);
    // A key of the method's own, but a value that it can't follow.
    let scene = with_cloud("[method]\nname = \"sorted\"\nraster = \"hardware\"");
    let [warning] = scene.warnings.as_slice() else { panic!("{:?}", scene.warnings) };
    assert!(warning.contains("method \"sorted\" always works in compute shaders: `raster` has no effect"), "{warning}");
    let with_hardware =
        ["abuffer", "stochastic", "circles", "cone"].map(|name| format!("name = \"{name}\"\nraster = \"hardware\""));
    for rest in with_hardware.into_iter().chain(["name = \"sorted\"\nraster = \"auto\"".to_owned()]) {
        assert_eq!(with_cloud(&format!("[method]\n{rest}")).warnings, [""; 0]);
    }
}

#[test]
fn outlines_of_opaque_splats_are_read() {
    let shape =
        |name: &str| with_cloud(&format!("[method]\nname = {name:?}\nshape = \"square\"")).method.representative();
    assert!(matches!(shape("hqs"), Method::Hqs(of) if of.shape == SplatShape::Square));
    assert!(matches!(shape("cone"), Method::Cone(of) if of.shape == SplatShape::Square));
    // Oriented splats and spheres are round.
    for name in ["splats", "sphere"] {
        let scene = with_cloud(&format!("[method]\nname = {name:?}\nshape = \"square\""));
        assert!(scene.warnings[0].contains("does not use `shape`"), "{:?}", scene.warnings);
    }
    // A file whose method was changed by an option.
    for (name, other) in [("hqs", "oriented"), ("cone", "flat"), ("abuffer", "square"), ("auto", "circle")] {
        let scene = with_cloud(&format!("[method]\nname = {name:?}\nshape = {other:?}"));
        assert!(scene.warnings[0].contains("this `shape` is of other methods"), "{:?}", scene.warnings);
        assert_eq!(scene.method, with_cloud(&format!("[method]\nname = {name:?}")).method);
    }
    assert!(refused(&format!("[method]\nname = \"hqs\"\nshape = \"round\"\n{CLOUD}")).contains("`method.shape`"));
}

#[test]
fn shadows_are_read_where_there_is_a_light_that_casts_them() {
    let lambert = |light: &str| format!("[shading]\nmodel = \"lambert\"\nlight = {light}\n");
    let shaded = lambert("[0, -1, 0]");
    let of = |head: &str, keys: &str| with_cloud(&format!("{head}[shadows]\n{keys}"));
    let default = Shadows { samples: 1, light_radius: 0.0, resolution: 1024, min_layer_distance: None };
    let given = "method = \"texture\"\nsamples = 30\nlight_radius = 2.5\nresolution = 512\nmin_layer_distance = 0.1";
    let all = Shadows { samples: 30, light_radius: 2.5, resolution: 512, min_layer_distance: Some(0.1) };
    for (keys, wanted) in [("", default), (given, all)] {
        for light in ["[0, -1, 0]", "{ position = [0, 9, 0] }"] {
            // Only once the points are known does `auto` become a method that may or may not support shadows.
            for method in ["points", "circles", "splats", "auto"] {
                let head = format!("{}[method]\nname = {method:?}\n", lambert(light));
                let scene = of(&head, keys);
                assert_eq!((scene.shadows, scene.warnings), (Some(wanted), Vec::new()), "{head}");
            }
        }
    }
    assert_eq!(with_cloud(&shaded).shadows, None);
    // A direction's area is an angle, a position's a length.
    let wide = "[shadows]\nlight_radius = 90";
    assert!(refused(&format!("{shaded}{wide}\n{CLOUD}")).contains("below 90 degrees, found 90"));
    let lamp = format!("{}[method]\nname = \"points\"\n", lambert("{ position = [0, 9, 0] }"));
    assert_eq!(with_cloud(&format!("{lamp}{wide}")).shadows, Some(Shadows { light_radius: 90.0, ..default }));
    assert!(refused(&format!("[shadows]\nsample = 3\n{CLOUD}")).contains("did you mean `samples`?"));
}

#[test]
fn shadows_without_effect_warn() {
    let lambert = "[shading]\nmodel = \"lambert\"\n";
    let down = format!("{lambert}light = [0, -1, 0]\n");
    for (head, line, why) in [
        ("", 1, "a headlight casts no shadows"),
        ("[shading]\nmodel = \"none\"\nlight = [0, -1, 0]\n", 4, "without shading there are no shadows"),
        (lambert, 3, "a headlight casts no shadows"),
        (&format!("{down}[method]\nname = \"abuffer\"\n"), 6, "method \"abuffer\" takes no shadows"),
        (&format!("{down}[method]\nname = \"spbr\"\n"), 6, "method \"spbr\" takes no shadows"),
    ] {
        let scene = with_cloud(&format!("{head}[shadows]\nresolution = 512"));
        let [warning] = scene.warnings.as_slice() else { panic!("{:?}", scene.warnings) };
        assert!(warning.contains(&format!(":{line}:")) && warning.contains(why), "{warning}");
        assert_eq!(scene.shadows, None);
    }
}

/// The settings of a cloud with these keys, under a method that reads them, and the warnings.
fn field_of(keys: &str) -> (Option<Field>, Vec<String>) {
    let scene = with_method("soft-base", keys);
    (scene.clouds[0].field.clone(), scene.warnings)
}

fn with_method(method: &str, keys: &str) -> Scene {
    read(&format!("[method]\nname = {method:?}\n{CLOUD}{keys}\n")).unwrap()
}

#[test]
fn fields_are_read() {
    let quiet = |field| (Some(field), Vec::new());
    assert_eq!(field_of(""), (None, Vec::new()));
    assert_eq!(field_of("field = \"uncertainty\""), quiet(Field::Uncertainty));
    assert_eq!(field_of("field = \"intensity\""), quiet(Field::Intensity));
    assert_eq!(field_of("field = \"height\""), quiet(Field::Property { name: "height".into() }));
    let classes = field_of("field = \"classification\"\nsoft_classes = [5, 3, 3, 255]");
    assert_eq!(classes, quiet(Field::Classification { classes: vec![3, 5, 255] }));
    let axis = |point, direction| quiet(Field::DistanceToAxis { point, direction });
    assert_eq!(field_of("field = \"distance-to-axis\""), axis(None, None));
    let both = field_of("field = \"distance-to-axis\"\naxis = { point = [1, 2, 3.5], direction = [0, 0, 2] }");
    assert_eq!(both, axis(Some([1.0, 2.0, 3.5]), Some([0.0, 0.0, 2.0])));
}

#[test]
fn keys_of_fields_that_have_no_effect_warn() {
    let warning = |keys: &str| {
        let (_, warnings) = field_of(keys);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        warnings[0].clone()
    };
    assert!(warning("soft_classes = [3]").contains(":5:16: `soft_classes` has no effect without field = "));
    assert!(warning("field = \"intensity\"\naxis = {}").contains("`axis` has no effect without field = "));
    let scene = with_method("abuffer", "field = \"classification\"\nsoft_classes = [3, 4]");
    assert_eq!(scene.warnings.len(), 2);
    assert!(scene.warnings[0].contains("method \"abuffer\" does not use `field`"), "{:?}", scene.warnings);
    // Wrong all the same.
    assert!(refused(&format!("{CLOUD}field = \"classification\"\n")).contains("needs soft_classes"));
    assert!(refused(&format!("{CLOUD}field = \"\"\n")).contains("a string that is not empty"));
}

#[test]
fn options_win_over_the_file_and_are_checked_alike() {
    let text = format!("[image]\nsize = [8, 8]\n{CLOUD}{CLOUD}");
    let scene = overridden(
        &text,
        &[
            "image.size=[64, 32]",
            "cloud.*.opacity=0.5",
            "cloud.1.opacity=0.25",
            "method.name=abuffer",
            "method.shape=oriented",
        ],
    )
    .unwrap();
    assert_eq!(scene.image.size, [64, 32]);
    assert_eq!(scene.clouds.iter().map(|cloud| cloud.opacity).collect::<Vec<_>>(), [0.5, 0.25]);
    assert!(matches!(scene.method.fixed(), Some(Method::ABuffer(discs)) if discs.shape == DiscShape::Oriented));
    assert!(scene.settings.contains("\"size\":[64,32]"), "{}", scene.settings);

    let refused = |pair: &str| overridden(&text, &[pair]).expect_err(pair).to_string();
    assert!(refused("cloud.0.opacity=2").starts_with("--set cloud.0.opacity=2: `cloud.0.opacity` must be a number"));
    assert!(refused("cloud.0.opactiy=2").contains("did you mean `opacity`?"));
    assert!(refused("cloud.2.opacity=1").contains("needs a number below 2"));
    assert!(refused("image.size.x=1").contains("needs a number below 2"));
    assert!(refused("image.color.x=1").starts_with("--set image.color.x=1: `image.color` must be one of"));
    assert!(refused("image..size=1").contains("is no key"));
    assert!(refused("image.size").contains("expected KEY=VALUE"));
    // One step of a recursion for each segment would be more than a stack holds.
    let deep = "a.".repeat(60_000) + "a=1";
    assert!(refused(&deep).contains("a key of 60001 segments (at most 32)"));
}

#[test]
fn an_option_replaces_the_rival_key_of_the_file() {
    let text = format!("[camera]\nfov_y = 30\n{CLOUD}");
    let scene = overridden(&text, &["camera.height=2"]).unwrap();
    assert_eq!((scene.camera.height, scene.camera.fov_y), (Some(2.0), None));
    assert!(overridden(CLOUD, &["camera.height=2", "camera.fov_y=30"]).is_err(), "two options still contradict");
}

fn scene_of(text: &str) -> Scene {
    overridden(text, &[]).unwrap()
}

fn assembled(text: &str, clouds: Vec<Cloud>, needs_radii: bool) -> Points {
    assemble(&scene_of(text), clouds, needs_radii, &Progress::hidden()).unwrap()
}

/// The point at a position, as (color, opacity, radius, normal): the order of points is not this test's business.
fn at(points: &Points, position: DVec3) -> (Vec3, f32, f32, Option<Vec3>) {
    let i = points.positions.iter().position(|p| *p == position).expect("a point at that position");
    (points.colors[i], points.opacities[i], points.radii[i], points.normals.as_ref().map(|normals| normals[i]))
}

#[test]
fn settings_apply_to_points() {
    let own = Cloud {
        positions: vec![DVec3::new(1.0, 0.0, 0.0)],
        colors: Some(vec![Vec3::new(0.1, 0.2, 0.3)]),
        alphas: Some(vec![0.5]),
        radii: Some(vec![0.25]),
        normals: Some(vec![Vec3::Z]),
        ..Cloud::default()
    };
    let bare = Cloud { positions: vec![DVec3::new(7.0, 7.0, 7.0)], ..Cloud::default() };
    let text = "[[cloud]]\npath = \"a\"\nopacity = 0.5\ntranslate = [500000, 4500000, 100]\nscale = 2\n\
                [[cloud]]\npath = \"b\"\nradius = 3.0\ncolor_by = \"uniform\"\n";
    let points = assembled(text, vec![own.clone(), bare.clone()], true);
    let moved = DVec3::new(500_002.0, 4_500_000.0, 100.0);
    // Alpha 0.5·0.5; the file's radius 0.25 times scale 2.
    assert_eq!(at(&points, moved), (Vec3::new(0.1, 0.2, 0.3), 0.25, 0.5, Some(Vec3::Z)));
    // White, opaque, the scene's radius, no normal beside one that has.
    assert_eq!(at(&points, DVec3::splat(7.0)), (Vec3::ONE, 1.0, 3.0, Some(Vec3::ZERO)));

    let points = assembled("[[cloud]]\npath = \"a\"\nradius = 3.0\nscale = 2\ncolor = [1, 0, 0]", vec![own], true);
    // A radius of the scene is not scaled, its color wins.
    assert_eq!(at(&points, DVec3::new(2.0, 0.0, 0.0)), (Vec3::X, 0.5, 3.0, Some(Vec3::Z)));
    let points = assembled("[[cloud]]\npath = \"b\"\ncolor_by = \"uniform\"", vec![bare], false);
    assert_eq!(at(&points, DVec3::splat(7.0)), (Vec3::ONE, 1.0, 0.0, None));
}

#[test]
fn radii_are_estimated_after_the_scale() {
    let line = Cloud { positions: (0..5).map(|i| DVec3::X * f64::from(i)).collect(), ..Cloud::default() };
    let radius = |scale: f64| {
        let text = format!("[[cloud]]\npath = \"a\"\nneighbors = 4\nscale = {scale}");
        at(&assembled(&text, vec![line.clone()], true), DVec3::ZERO).2
    };
    // Eq. 20 at the end of the line: its 4 neighbors reach to 4, so 2·4/sqrt(4).
    assert_eq!(radius(1.0), 4.0);
    assert_eq!(radius(1000.0), 4000.0);
}

#[test]
fn a_factor_multiplies_radii_from_anywhere() {
    let line = Cloud { positions: (0..5).map(|i| DVec3::X * f64::from(i)).collect(), ..Cloud::default() };
    let own = Cloud { radii: Some(vec![0.5; 5]), ..line.clone() };
    let radius = |cloud: &Cloud, keys: &str| {
        let text = format!("[[cloud]]\npath = \"a\"\nneighbors = 4\nradius_factor = 0.25\n{keys}");
        at(&assembled(&text, vec![cloud.clone()], true), DVec3::ZERO).2
    };
    // Estimated 4, as above; the file's 0.5, scaled; the scene's, not scaled.
    assert_eq!(radius(&line, ""), 1.0);
    assert_eq!(radius(&own, "scale = 1000"), 125.0);
    assert_eq!(radius(&own, "scale = 1000\nradius = 8"), 2.0);
    assert!(refused(&format!("{CLOUD}radius_factor = -1")).contains("cloud.0.radius_factor"));
}

const SOFT: &str = "[method]\nname = \"soft-base\"\n[[cloud]]\npath = \"a\"\n";

/// F of the points of one cloud by their x, under a soft method.
fn fields(cloud: &Cloud, keys: &str) -> Vec<f32> {
    let points = assembled(&format!("{SOFT}{keys}"), vec![cloud.clone()], true);
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points.positions[a].x.total_cmp(&points.positions[b].x));
    order.into_iter().map(|i| points.fields[i]).collect()
}

fn with_properties() -> Cloud {
    Cloud {
        positions: (0..5).map(|i| DVec3::new(f64::from(i), 2.0, f64::from(i % 2))).collect(),
        classification: Some(vec![2, 3, 4, 5, 3]),
        intensity: Some(vec![0.0, 100.0, 50.0, 200.0, 25.0]),
        scalars: vec![
            ("share".into(), vec![0.5, 0.25, 1.0, 0.75, 0.5]),
            ("pulse width".into(), vec![-1.0, 0.0, 3.0, f32::NAN, f32::INFINITY]),
            ("constant".into(), vec![7.0; 5]),
        ],
        ..Cloud::default()
    }
}

#[test]
fn fields_of_every_kind() {
    let cloud = with_properties();
    assert_eq!(fields(&cloud, "field = \"classification\"\nsoft_classes = [3, 5]"), [0.0, 1.0, 0.0, 1.0, 1.0]);
    assert_eq!(fields(&cloud, "field = \"classification\"\nsoft_classes = []"), [0.0; 5]);
    assert_eq!(fields(&cloud, "field = \"intensity\""), [0.0, 0.5, 0.25, 1.0, 0.125]);
    assert_eq!(fields(&cloud, "field = \"share\""), [0.5, 0.25, 1.0, 0.75, 0.5], "within [0, 1]: as stored");
    assert_eq!(fields(&cloud, "field = \"pulse width\""), [0.0, 0.25, 1.0, 0.0, 1.0], "NaN 0, infinity 1");
    assert_eq!(fields(&cloud, "field = \"pulse_width\""), [0.0, 0.25, 1.0, 0.0, 1.0], "as PLY files spell it");
    assert_eq!(fields(&cloud, "field = \"constant\""), [0.0; 5]);
    assert_eq!(fields(&cloud, "field = \"x\""), [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(fields(&cloud, "field = \"label\""), [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0, 1.0 / 3.0], "the codes");
    // The vertical through the centre (2, 2, 0.5) is along Y: distances √(4.25), √(1.25), 0.5, √(1.25), √(4.25).
    let [near, middle, far] = [0.5f64, 1.25f64.sqrt(), 4.25f64.sqrt()];
    let share = ((middle - near) / (far - near)) as f32;
    assert_eq!(fields(&cloud, "field = \"distance-to-axis\""), [1.0, share, 0.0, share, 1.0]);
    let axis = "field = \"distance-to-axis\"\naxis = { point = [0, 7, 0], direction = [0, 0, -3] }";
    assert!(fields(&cloud, axis).is_sorted(), "5 from each, and x beside");
}

#[test]
fn an_axis_is_in_the_scenes_coordinates() {
    let cloud = with_properties();
    let keys = |point: &str, more: &str| {
        format!("field = \"distance-to-axis\"\naxis = {{ point = {point}, direction = [0, 0, 1] }}\n{more}")
    };
    let moved = keys("[500004, 4500008, 0]", "scale = 2\ntranslate = [500000, 4500000, 100]");
    assert_eq!(fields(&cloud, &moved), fields(&cloud, &keys("[2, 4, 0]", "")));
    assert_ne!(fields(&cloud, &moved), fields(&cloud, &keys("[2, 5, 0]", "")));
}

#[test]
fn methods_without_soft_points_get_no_fields() {
    let cloud = with_properties();
    assert!(assembled("[[cloud]]\npath = \"a\"\nfield = \"nonsense\"", vec![cloud], true).fields.is_empty());
}

#[test]
fn fields_are_scaled_cloud_by_cloud_and_dropped_with_their_points() {
    let cloud = |values: [f32; 2]| Cloud {
        positions: vec![DVec3::X, DVec3::X * 1e300],
        scalars: vec![("v".into(), values.to_vec())],
        ..Cloud::default()
    };
    let text = format!("{SOFT}field = \"v\"\n[[cloud]]\npath = \"b\"\nfield = \"v\"\nscale = 1e10");
    let points = assembled(&text, vec![cloud([0.0, 2.0]), cloud([9.0, 3.0])], true);
    let field = |x: f64| points.fields[points.positions.iter().position(|p| p.x == x).unwrap()];
    assert_eq!((points.len(), points.fields.len()), (3, 3));
    assert_eq!([1.0, 1e300, 1e10].map(field), [0.0, 1.0, 1.0]);
}

#[test]
fn clouds_that_lack_what_a_field_needs_are_refused_by_name() {
    let refused = |cloud: Cloud, keys: &str| {
        let scene = scene_of(&format!("{SOFT}{keys}"));
        let error = assemble(&scene, vec![cloud], true, &Progress::hidden()).unwrap_err();
        assert_eq!(error.exit_status(), 1, "the scene is fine, the file lacks something: {error}");
        error.to_string()
    };
    let bare = || Cloud { classification: None, intensity: None, ..with_properties() };
    let message = refused(bare(), "field = \"classification\"\nsoft_classes = [3]");
    let there = "it has share, pulse width, constant, x, y, z";
    assert_eq!(message, format!("a: field = \"classification\" needs classes, but the file has none; {there}"));
    assert_eq!(
        refused(bare(), "field = \"intensity\""),
        format!("a: field = \"intensity\", but the file has none; {there}")
    );
    let message = refused(with_properties(), "field = \"shape\"");
    assert_eq!(message, "a: no scalar property `shape` for field; did you mean `share`?");
    let message = refused(with_properties(), "field = \"temperature\"");
    let all = "classification, intensity, share, pulse width, constant, x, y, z";
    assert_eq!(message, format!("a: no scalar property `temperature` for field; the file has: {all}"));
}

#[test]
fn points_that_leave_float64_are_dropped_with_their_attributes() {
    let cloud = Cloud {
        positions: vec![DVec3::X, DVec3::new(1e300, 0.0, 0.0), DVec3::Y],
        colors: Some(vec![Vec3::X, Vec3::Y, Vec3::Z]),
        ..Cloud::default()
    };
    let text = "[[cloud]]\npath = \"a\"\nscale = 1e10";
    let points = assembled(text, vec![cloud], false);
    assert_eq!(points.len(), 2);
    assert_eq!(at(&points, DVec3::Y * 1e10).0, Vec3::Z);
    let far = Cloud { positions: vec![DVec3::X * 1e300], ..Cloud::default() };
    let error = assemble(&scene_of(text), vec![far], false, &Progress::hidden()).unwrap_err();
    assert_eq!(error.exit_status(), 1);
}

fn points(positions: &[DVec3], radius: f32) -> Points {
    Points {
        positions: positions.to_vec(),
        colors: vec![Vec3::ONE; positions.len()],
        opacities: vec![1.0; positions.len()],
        radii: vec![radius; positions.len()],
        ..Points::default()
    }
}

fn camera_of(text: &str, points: &Points, up: UpAxis, view: View) -> (Camera, Vec<String>) {
    let mut scene = scene_of(&format!("{text}\n{CLOUD}"));
    scene.camera.view = view;
    camera(&scene, points, up).unwrap()
}

/// Asserts that every point's disc lies inside the image and the depth range.
fn assert_frames(camera: &Camera, points: &Points, size: [u32; 2]) {
    for (position, radius) in points.positions.iter().zip(&points.radii) {
        let (pixel, z) = camera.project(*position, size);
        let radius_px = f64::from(*radius) * camera.pixels_per_unit(z, size[1]);
        assert!(z >= camera.near && z <= camera.far, "{z} in {}..{}", camera.near, camera.far);
        for (at, side) in [(pixel.x, size[0]), (pixel.y, size[1])] {
            assert!(at - radius_px >= 0.0 && at + radius_px <= f64::from(side), "{pixel} ± {radius_px} in {size:?}");
        }
    }
}

#[test]
fn automatic_cameras_frame_any_scene_at_any_shape_of_image() {
    let scenes: [(&[DVec3], f32); 6] = [
        (&[DVec3::new(-3.0, 0.0, 1.0), DVec3::new(5.0, 2.0, 9.0)], 0.1),
        (&[DVec3::new(636_000.0, 850_500.0, 411.0), DVec3::new(638_000.0, 852_500.0, 598.0)], 2.0),
        (&[DVec3::ZERO, DVec3::Z * 10.0], 0.0),
        (&[DVec3::new(5e5, 4.5e6, 1e2)], 0.0),
        (&[DVec3::ZERO], 7.0),
        (&[DVec3::ZERO, DVec3::X * 1e-9], 0.0),
    ];
    let views = [None, Some(ViewName::Front), Some(ViewName::Top), Some(ViewName::Left), Some(ViewName::Iso)];
    for (positions, radius) in scenes {
        for (size, name) in [[100, 100], [400, 100], [100, 400], [1, 16384]].iter().zip(views.iter().cycle()) {
            for up in [UpAxis::Y, UpAxis::Z] {
                let points = points(positions, radius);
                let text = format!("[image]\nsize = {size:?}");
                let (camera, warnings) = camera_of(&text, &points, up, View { name: *name, ..View::default() });
                assert!(warnings.is_empty(), "{warnings:?}");
                assert_frames(&camera, &points, *size);
            }
        }
    }
}

#[test]
fn a_camera_that_is_given_in_full_needs_no_points() {
    let points = points(&[DVec3::new(-3.0, 0.0, 1.0), DVec3::new(5.0, 2.0, 9.0)], 0.1);
    let bounds = points.bounds().unwrap();
    let given = "eye = [4500000.3, -20.1, 7.7]\ntarget = [4500000.1, 0.3, 0.2]\nup = [0.1, 0.2, 0.9]\n";
    for lens in ["fov_y = 33.3", "height = 12.5", "near = 0.5", "far = 77"] {
        let scene = with_cloud(&format!("[camera]\n{given}{lens}\n"));
        let (found, _) = camera(&scene, &points, UpAxis::Z).unwrap();
        assert_eq!(camera_at(&scene.camera, &bounds, f64::from(0.1f32)), Some(found), "{lens}");
    }
    for missing in ["eye = [1, 2, 3]\ntarget = [0, 0, 0]", "eye = [1, 2, 3]\nup = [0, 0, 1]", "up = [0, 0, 1]"] {
        let scene = with_cloud(&format!("[camera]\n{missing}\n"));
        assert_eq!(camera_at(&scene.camera, &bounds, 0.1), None, "{missing}");
    }
}

#[test]
fn framing_fills_the_image_up_to_the_margin() {
    // A square of side 2 across the view: 95% of 100 pixels.
    let square = points(&[DVec3::new(-1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, 0.0)], 0.0);
    let (camera, _) = camera_of(
        "[image]\nsize = [100, 100]",
        &square,
        UpAxis::Y,
        View { name: Some(ViewName::Front), ..View::default() },
    );
    let (corner, _) = camera.project(DVec3::new(-1.0, 1.0, 0.0), [100, 100]);
    assert!((corner.x - 2.5).abs() < 1e-9 && (corner.y - 2.5).abs() < 1e-9, "{corner}");
    assert_eq!(camera.projection, Projection::Perspective { fov_y: 45f64.to_radians() });
}

#[test]
fn framing_follows_the_points_and_not_the_corners_of_their_box() {
    // The diagonal of a long box, and one larger sphere in the middle that reaches nowhere.
    let mut line = points(&[DVec3::new(-40.0, 0.0, -5.0), DVec3::ZERO, DVec3::new(40.0, 1.0, 5.0)], 0.0);
    line.radii[1] = 0.5;
    let size = [300, 100];
    for name in [ViewName::Front, ViewName::Back, ViewName::Top] {
        let view = View { name: Some(name), ..View::default() };
        let (camera, _) = camera_of("[image]\nsize = [300, 100]", &line, UpAxis::Y, view);
        assert_frames(&camera, &line, size);
        let pixels = [0, 2].map(|i| camera.project(line.positions[i], size).0);
        let (min, max) = (pixels[0].min(pixels[1]), pixels[0].max(pixels[1]));
        // Both ends lie on the margin, 2.5% of the width or of the height.
        let wide = (min.x - 7.5).abs() < 1e-6 && (max.x - 292.5).abs() < 1e-6;
        let high = (min.y - 2.5).abs() < 1e-6 && (max.y - 97.5).abs() < 1e-6;
        assert!(wide || high, "{name:?}: {min} to {max}");
    }
}

#[test]
fn framing_centers_what_does_not_fill_the_image() {
    // A flat square of ground from above its front edge: the far edge is shorter and higher in the image.
    let mut ground: Vec<_> = (0..400).map(|i| DVec3::new(f64::from(i % 20), f64::from(i / 20), 0.0)).collect();
    ground.push(DVec3::new(3.0, 4.0, 2.0));
    let ground = points(&ground, 0.0);
    for text in ["", "[camera]\nfov_y = 100.0", "[camera]\nheight = 60.0"] {
        for elevation in [Some(5.0), Some(35.0), Some(80.0)] {
            let size = [200, 200];
            let view = View { elevation, ..View::default() };
            let (camera, _) = camera_of(&format!("[image]\nsize = [200, 200]\n{text}"), &ground, UpAxis::Z, view);
            assert_frames(&camera, &ground, size);
            let pixels = || ground.positions.iter().map(|p| camera.project(*p, size).0);
            let (min, max) = pixels().fold((DVec2::INFINITY, -DVec2::INFINITY), |(a, b), p| (a.min(p), b.max(p)));
            // The last step of the search is below a ten-thousandth of the distance: 0.03 pixels at 45°.
            let off = (0.5 * (min + max) - 100.0).abs();
            assert!(off.max_element() < 0.05, "{text} {elevation:?}: {min} to {max}");
        }
    }
}

#[test]
fn surveys_stand_on_z_and_models_on_y() {
    let cube = points(&[DVec3::ZERO, DVec3::ONE], 0.0);
    let up = |axis| camera_of("", &cube, axis, View::default()).0;
    assert!(up(UpAxis::Z).up.z > 0.5 && up(UpAxis::Z).eye.y < 0.0, "from the south, Z up");
    assert!(up(UpAxis::Y).up.y > 0.5 && up(UpAxis::Y).eye.z > 1.0, "from the front, Y up");
    let cloud = |up| Cloud { up, ..Cloud::default() };
    assert_eq!(up_axis(&[cloud(UpAxis::Y), cloud(UpAxis::Z)]), UpAxis::Z);
    assert_eq!(up_axis(&[cloud(UpAxis::Y), cloud(UpAxis::Y), cloud(UpAxis::Z)]), UpAxis::Y);
}

#[test]
fn a_given_camera_is_taken_as_it_is_with_the_default_depths() {
    let cube = points(&[DVec3::splat(-1.0), DVec3::ONE], 0.5);
    let (camera, warnings) =
        camera_of("[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 1, 0]", &cube, UpAxis::Z, View::default());
    assert_eq!((camera.eye, camera.forward, camera.up), (DVec3::Z * 5.0, -DVec3::Z, DVec3::Y));
    // z runs from 4 to 6 over the corners, r_max is 0.5.
    assert!((camera.far - 1.001 * 6.5).abs() < 1e-12 && (camera.near - 0.999 * 3.5).abs() < 1e-12);
    assert_eq!(warnings, [""; 0]);
    // Inside the box z_min is negative: near is far·1e-5.
    let (camera, _) = camera_of("[camera]\neye = [0, 0, 0]\ntarget = [0, 0, -1]", &cube, UpAxis::Y, View::default());
    assert!((camera.far - 1.001 * 1.5).abs() < 1e-12 && (camera.near - camera.far * 1e-5).abs() < 1e-15);
}

#[test]
fn a_camera_that_sees_nothing_says_so() {
    let cube = points(&[DVec3::splat(-1.0), DVec3::ONE], 0.1);
    let away = "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 10]";
    let (camera, warnings) = camera_of(away, &cube, UpAxis::Y, View::default());
    assert!(camera.near > 0.0 && camera.near < camera.far);
    assert!(warnings[0].contains("the camera sees nothing"), "{warnings:?}");
    let (_, warnings) = camera_of("[camera]\nfar = 0.01", &cube, UpAxis::Y, View::default());
    assert!(warnings[0].contains("the camera sees nothing"), "{warnings:?}");
    let beside = "[camera]\neye = [0, 0, 5]\ntarget = [100, 0, 5]\nup = [0, 1, 0]";
    assert_eq!(camera_of(beside, &cube, UpAxis::Y, View::default()).1.len(), 1);
}

#[test]
fn a_camera_moved_with_its_cloud_is_the_same_camera() {
    let shift = DVec3::new(500_000.0, 4_500_000.0, 100.0);
    let camera = |shift: DVec3| {
        let [eye, target] = [shift + DVec3::new(1.0, 2.0, 5.0), shift].map(|v| format!("{:?}", v.to_array()));
        let cube = points(&[shift - DVec3::ONE, shift + DVec3::ONE], 0.5);
        camera_of(&format!("[camera]\neye = {eye}\ntarget = {target}"), &cube, UpAxis::Y, View::default()).0
    };
    let (here, there) = (camera(DVec3::ZERO), camera(shift));
    assert_eq!(Camera { eye: here.eye, ..there }, here);
}

#[test]
fn coordinates_that_no_camera_can_hold_are_an_error() {
    let huge = points(&[DVec3::ZERO, DVec3::X * 1e200], 0.0);
    let error = camera(&scene_of(CLOUD), &huge, UpAxis::Y).unwrap_err();
    assert_eq!(error.exit_status(), 1, "{error}");
}

#[test]
fn the_up_of_the_file_says_which_axis_views_take_as_the_vertical() {
    let cube = points(&[DVec3::splat(-1.0), DVec3::ONE], 0.0);
    let front = View { name: Some(ViewName::Front), ..View::default() };
    let up = |text, axis| camera_of(text, &cube, axis, front).0.up;
    assert_eq!(up("[camera]\nup = [0, 0.1, 1]", UpAxis::Y), DVec3::Z);
    assert_eq!(up("[camera]\nup = [0, 2, 0]", UpAxis::Z), DVec3::Y);
    assert_eq!(up("[camera]\nup = [0, -1, 0.5]", UpAxis::Z), -DVec3::Y);
    assert_eq!(up("[camera]\nup = [1, 0, 0]", UpAxis::Z), DVec3::X);
    assert_eq!(up("[camera]\nup = [1, 1, 0]", UpAxis::Z), DVec3::Z, "between two axes: the clouds' own");
    let (_, warnings) = camera_of("[camera]\nup = [1, 0, 0]", &cube, UpAxis::Z, front);
    assert_eq!(warnings, [""; 0], "a view heeds it");
}

#[test]
fn an_orthographic_camera_shows_the_whole_scene() {
    // 6 wide and 4 high from the front, 2 deep.
    let flat = points(&[DVec3::new(-3.0, -2.0, -1.0), DVec3::new(3.0, 2.0, 1.0)], 0.0);
    let front = View { name: Some(ViewName::Front), ..View::default() };
    let of = |text: &str, size: [u32; 2], view| {
        let text = format!("[image]\nsize = {size:?}\n[camera]\northo = true\n{text}");
        let (camera, _) = camera_of(&text, &flat, UpAxis::Y, view);
        let Projection::Orthographic { height } = camera.projection else { panic!("{camera:?}") };
        (camera, height)
    };
    // The width decides in a square and in a high image, the height in a wide one.
    for (size, wanted) in [([100, 100], 6.0), ([100, 200], 12.0), ([400, 100], 4.0)] {
        let (camera, height) = of("", size, front);
        assert!((height - wanted / 0.95).abs() < 1e-12, "{size:?}: {height}");
        assert_frames(&camera, &flat, size);
        assert_frames(&of("", size, View::default()).0, &flat, size);
    }
    assert_eq!(of("height = 5", [100, 100], front).1, 5.0);
    // Around a point of the left edge: the right edge is 6 away, on both sides of the image.
    let aside = "eye = [-3, 0, 9]\ntarget = [-3, 0, 0]\nup = [0, 1, 0]";
    assert!((of(aside, [100, 100], View::default()).1 - 12.0 / 0.95).abs() < 1e-12);
    let refused = Scene::from_toml(&format!("[camera]\northo = true\nfov_y = 30\n{CLOUD}"), "s.toml".as_ref());
    assert!(refused.unwrap_err().to_string().contains("keep one"));
}

#[test]
fn a_printed_camera_gives_its_picture_again() {
    let cloud = points(&[DVec3::new(5e5, 4.5e6, 100.0), DVec3::new(5e5 + 7.0, 4.5e6 + 3.0, 104.0)], 0.25);
    for text in ["", "[camera]\nfov_y = 33.3", "[camera]\northo = true"] {
        let (camera, _) = camera_of(text, &cloud, UpAxis::Z, View::default());
        let (again, warnings) = camera_of(&camera.to_toml(9.0), &cloud, UpAxis::Z, View::default());
        assert_eq!(warnings, [""; 0]);
        for position in &cloud.positions {
            let [(pixel, z), (wanted, depth)] = [again, camera].map(|camera| camera.project(*position, [1000, 1000]));
            // A target 9 away at 4.5e6 is rounded to 1e-10 of its distance.
            assert!((pixel - wanted).length() < 1e-6 && (z - depth).abs() < 1e-8, "{text}: {pixel}, not {wanted}");
        }
        assert_eq!((again.near, again.far), (camera.near, camera.far));
    }
}

#[test]
fn a_view_replaces_the_eye_but_keeps_the_projection() {
    let cube = points(&[DVec3::splat(-1.0), DVec3::ONE], 0.0);
    let view = View { name: Some(ViewName::Right), ..View::default() };
    let (camera, warnings) = camera_of("[camera]\neye = [0, 0, 5]\nheight = 4", &cube, UpAxis::Y, view);
    assert_eq!((camera.forward, camera.projection), (-DVec3::X, Projection::Orthographic { height: 4.0 }));
    assert!(warnings[0].contains("replaces `eye`"), "{warnings:?}");
}
