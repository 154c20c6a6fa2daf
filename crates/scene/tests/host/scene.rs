//! Scene files and options: what is read, what is refused and where.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use pellucid_core::cloud::field::Field;
use pellucid_scene::*;

pub const CLOUD: &str = "[[cloud]]\npath = \"a.ply\"\n";

fn read(text: &str) -> Result<Scene, Error> {
    Scene::from_toml(text, Path::new("dir/s.toml"))
}

/// A scene of one cloud and `text` before it.
pub fn with_cloud(text: &str) -> Scene {
    read(&format!("{text}\n{CLOUD}")).unwrap()
}

/// The message for a text that must be refused with status 2.
pub fn refused(text: &str) -> String {
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
    assert_eq!(
        scene.image,
        ImageSettings {
            size: [1024, 1024],
            background: Background::Color(Vec3::ZERO),
            samples: Samples::Count(1),
            sampling_error: 0.003,
            color: None,
        }
    );
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
    assert_eq!(scene.image.color, Some(ColorSpace::Encoded));
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
        ..Discs::default()
    };
    assert_eq!(scene.method, Method::ABuffer(discs).into());
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn an_unknown_key_names_line_column_and_the_nearest_key() {
    let message = refused("[[cloud]]\npath = \"a.ply\"\n  opactiy = 0.5\n");
    assert_eq!(message, "dir/s.toml:3:3: unknown key `cloud.0.opactiy`; did you mean `opacity`?");
    assert!(refused("[imge]\n").starts_with("dir/s.toml:1:2: unknown key `imge`; did you mean `image`?"));
    for (text, paths) in [
        ("shape = 'flat'\n", "`method.shape`"),
        ("opacity = 0.5\n", "`cloud.*.opacity`"),
        ("[image]\neye = [0, 0, 0]\n", "`camera.eye`"),
        ("[[cloud]]\npath = 'a'\nsize = 2\n", "`image.size` or `method.size`"),
    ] {
        let message = refused(text);
        assert!(message.ends_with(&format!("; it should be {paths}")), "{message}");
    }
    let message = refused("[[cloud]]\npath = \"C:\\temp.las\"\n");
    assert!(message.contains("names no file: \"C:\\temp.las\" has a control character"), "{message}");
    assert!(message.contains("single quotes"), "{message}");
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
        ("[image]", "no cloud: add"),
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
        fill: Iterations::Count(0),
        occlusion: Iterations::Count(256),
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
    assert_eq!(of(&layers), Method::PeelLayers(PeelLayers { filters, layers: 1024, ..PeelLayers::default() }).into());
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
fn iterations_are_a_number_or_auto() {
    for name in ["image-space", "peel-layers"] {
        let scene = with_cloud(&format!("[method]\nname = {name:?}\nfill = \"auto\"\nocclusion = \"auto\""));
        let method = scene.method.representative();
        let filters = method.filters().expect("it has filters");
        assert_eq!([filters.fill, filters.occlusion], [Iterations::Auto; 2]);
        assert_eq!(method.key("fill").and_then(|key| key.value), Some(Setting::from("auto")));
        for wrong in ["\"all\"", "-1", "1.5", "257"] {
            let message = refused(&format!("[method]\nname = {name:?}\nfill = {wrong}\n{CLOUD}"));
            assert!(message.starts_with("dir/s.toml:3:8: `method.fill`"), "{wrong}: {message}");
        }
    }
}

#[test]
fn a_layer_shown_alone_is_peeled_whatever_the_number_of_layers() {
    let peeled = |keys: &str| with_cloud(&format!("[method]\nname = \"peel-layers\"\n{keys}")).method.representative();
    let of = |only, layers| Method::PeelLayers(PeelLayers { only, layers, ..PeelLayers::default() });
    assert_eq!(peeled(""), of(None, 4));
    assert_eq!(peeled("only = 1"), of(Some(1), 4));
    assert_eq!(peeled("only = 4"), of(Some(4), 4));
    assert_eq!(peeled("layers = 9\nonly = 9"), of(Some(9), 9));
    assert_eq!(peeled("layers = 2\nonly = 9"), of(Some(9), 2));
    let peels = |keys: &str| match peeled(keys) {
        Method::PeelLayers(settings) => settings.peeled(),
        other => panic!("{other:?}"),
    };
    assert_eq!(["", "only = 1", "layers = 2\nonly = 9"].map(peels), [4, 1, 9]);
    let message = refused(&format!("[method]\nname = \"peel-layers\"\nonly = 0\n{CLOUD}"));
    assert!(message.contains(":3:8: `method.only` must be an integer from 1 to 1024"), "{message}");
}

#[test]
fn a_radius_in_pixels_excludes_one_in_the_world() {
    for name in ["squares", "circles", "paraboloid", "cone", "sphere"] {
        let scene = with_cloud(&format!("[method]\nname = {name:?}\npixel_radius = 2.5"));
        assert_eq!((scene.method.representative().pixel_radius(), scene.warnings.len()), (Some(2.5), 0), "{name}");
        // So none has to be estimated.
        assert!(!scene.method.needs_radii());
        let refused = refused(&format!("[method]\nname = {name:?}\npixel_radius = 2\n{CLOUD}\nradius = 0.5"));
        assert!(refused.contains(":7:10: `method.pixel_radius`") && refused.contains("`radius`"), "{refused}");
    }
    // Splats that are blended have none.
    for name in ["hqs", "splats", "points", "abuffer"] {
        let scene = read(&format!("[method]\nname = {name:?}\npixel_radius = 2.5\n{CLOUD}\nradius = 1.0")).unwrap();
        assert_eq!(scene.method.representative().pixel_radius(), None);
        assert!(scene.warnings[0].contains("does not use `pixel_radius`"), "{:?}", scene.warnings);
    }
    let circles = "[method]\nname = \"circles\"\npixel_radius = 2";
    // The radius of a class is one in the world too.
    let of_class = refused(&format!("{circles}\n{CLOUD}\n[[cloud.class]]\nid = 2\nradius = 0.5"));
    assert!(of_class.contains("exclude each other"), "{of_class}");
    let factors = read(&format!("{circles}\nsize = 3\n{CLOUD}\nradius_factor = 2")).unwrap();
    let [size, factor] = factors.warnings.as_slice() else { panic!("{:?}", factors.warnings) };
    assert!(size.contains("`size` has no effect with method.pixel_radius"), "{size}");
    assert!(factor.contains("`radius_factor` has no effect with method.pixel_radius"), "{factor}");
    assert!(refused(&format!("[method]\nname = \"circles\"\npixel_radius = -1\n{CLOUD}")).contains("pixel_radius"));
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
        assert!(scene.warnings[0].contains("this value of `shape` is for other methods"), "{:?}", scene.warnings);
        assert_eq!(scene.method, with_cloud(&format!("[method]\nname = {name:?}")).method);
    }
    assert!(refused(&format!("[method]\nname = \"hqs\"\nshape = \"round\"\n{CLOUD}")).contains("`method.shape`"));
}

#[test]
fn shadows_are_read_where_there_is_a_light_that_casts_them() {
    let lambert = |light: &str| format!("[shading]\nmodel = \"lambert\"\nlight = {light}\n");
    let shaded = lambert("[0, -1, 0]");
    let of = |head: &str, keys: &str| with_cloud(&format!("{head}[shadows]\n{keys}"));
    let default = Shadows {
        samples: 1,
        light_radius: 0.0,
        resolution: MapResolution::Auto,
        fill: Iterations::Count(1),
        occlusion: Iterations::Count(1),
        min_layer_distance: None,
    };
    let given = "method = \"texture\"\nsamples = 30\nlight_radius = 2.5\nresolution = 512\nfill = 0\nocclusion = 256\nmin_layer_distance = 0.1";
    let all = Shadows {
        samples: 30,
        light_radius: 2.5,
        resolution: MapResolution::Pixels(512),
        fill: Iterations::Count(0),
        occlusion: Iterations::Count(256),
        min_layer_distance: Some(0.1),
    };
    let words = "resolution = \"auto\"\nfill = \"auto\"\nocclusion = \"auto\"";
    let auto = Shadows { fill: Iterations::Auto, occlusion: Iterations::Auto, ..default };
    for (keys, wanted) in [("", default), (given, all), (words, auto)] {
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
    for (keys, why) in [("resolution = 0", "1 to 16384"), ("fill = 257", "0 to 256"), ("occlusion = -1", "0 to 256")] {
        let said = refused(&format!("[shadows]\n{keys}\n{CLOUD}"));
        assert!(said.contains(why), "{said}");
    }
    assert!(refused(&format!("[shadows]\nsample = 3\n{CLOUD}")).contains("did you mean `samples`?"));
}

#[test]
fn shadows_without_effect_warn() {
    let lambert = "[shading]\nmodel = \"lambert\"\n";
    let down = format!("{lambert}light = [0, -1, 0]\n");
    for (head, line, why) in [
        ("", 1, "a headlight casts no shadows"),
        ("[shading]\nmodel = \"none\"\nlight = [0, -1, 0]\n", 4, "shadows need shading"),
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
    assert!(refused("image..size=1").contains("is not a key"));
    assert!(refused("image.size").contains("expected KEY=VALUE"));
    // One step of a recursion for each segment would be more than a stack holds.
    let deep = "a.".repeat(60_000) + "a=1";
    assert!(refused(&deep).contains("a key with 60001 segments (at most 32)"));
}

#[test]
fn an_option_replaces_the_rival_key_of_the_file() {
    let text = format!("[camera]\nfov_y = 30\n{CLOUD}");
    let scene = overridden(&text, &["camera.height=2"]).unwrap();
    assert_eq!((scene.camera.height, scene.camera.fov_y), (Some(2.0), None));
    assert!(overridden(CLOUD, &["camera.height=2", "camera.fov_y=30"]).is_err(), "two options still contradict");
}

pub fn scene_of(text: &str) -> Scene {
    overridden(text, &[]).unwrap()
}
