//! Helpers of the stage's tests: clouds, a scene, comparisons.

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::*;
use pellucid_engine::passes::project::{DeviceCloud, Footprint, Projecting};
use pellucid_gpu::Buffer;

/// Points in a flat box, some of them in the same place, with all that settings pick from but radii.
pub fn cloud(seed: u64, count: usize) -> Cloud {
    let mut r = Pcg64::seed_from_u64(seed);
    let mut cloud = Cloud::default();
    for i in 0..count {
        let place = DVec3::new(r.random_range(-1.0..1.0), r.random_range(-1.0..1.0), r.random_range(-0.3..0.3));
        cloud.positions.push(if i % 5 == 4 { cloud.positions[i - 2] } else { place });
    }
    let mut column = || -> Vec<f32> { (0..count).map(|_| r.random_range(0.0..1.0)).collect() };
    cloud.colors = Some(column().iter().zip(column()).map(|(a, b)| Vec3::new(*a, b, 1.0 - a)).collect());
    cloud.normals = Some(column().iter().map(|a| Vec3::new(*a, 0.5, 1.0).normalize()).collect());
    cloud.classification = Some(column().iter().map(|a| (4.0 * a) as u8).collect());
    cloud.scalars = vec![("height".into(), column())];
    cloud
}

/// Two clouds: the first has alpha, the second has radii.
pub fn clouds() -> Vec<Cloud> {
    let (mut one, mut two) = (cloud(1, 60), cloud(2, 50));
    one.alphas = Some((0..60).map(|i| 0.3 + 0.01 * i as f32).collect());
    two.radii = Some((0..50).map(|i| 0.05 + 0.002 * i as f32).collect());
    (two.colors, two.normals) = (None, None);
    vec![one, two]
}

pub fn document() -> Document {
    let text = "
        [image]
        size = [28, 18]
        [shading]
        model = 'lambert'
        light = [0.3, -1, -0.5]
        [shadows]
        resolution = 32
        [[cloud]]
        path = 'a.ply'
        opacity = 0.8
        neighbors = 6
        [[cloud]]
        path = 'b.ply'
        opacity = 0.6
        neighbors = 6
    ";
    Document::from_toml(text, Path::new("/scans/s.toml"), &Overrides::default()).unwrap()
}

/// Compares all of two pictures that a window shows or a file gets; two errors are equal if they say the same.
#[track_caller]
pub fn assert_same(live: &TakenPicture, fresh: &TakenPicture, what: &str) {
    let frame = |taken: &TakenPicture| format!("{:?}, {:?}, {:?}", taken.frame, taken.subject, taken.brightness);
    assert_eq!(frame(live), frame(fresh), "{what}");
    let bits = |taken: &TakenPicture| {
        let image = &taken.rendered.image;
        let colors: Vec<_> = image.rgba.iter().map(|rgba| rgba.map(f32::to_bits)).collect();
        (colors, image.depth.iter().map(|depth| depth.to_bits()).collect::<Vec<_>>())
    };
    assert!(bits(live) == bits(fresh), "{what}: pixels differ");
    let facts = |taken: &TakenPicture| {
        let facts = &taken.rendered.facts;
        (facts.visible, facts.solid_points, facts.soft_visible, facts.slots, facts.max_list, facts.thin.clone())
    };
    assert_eq!(facts(live), facts(fresh), "{what}");
}

/// Compares what two stages have on the device after a picture.
#[track_caller]
pub fn assert_same_clouds(live: &mut SceneRenderer, fresh: &mut SceneRenderer, what: &str) {
    let [live, fresh] = [live, fresh].map(|stage| &mut stage.session().unwrap().uploaded.cloud);
    let how = Projecting { max_radius_px: 1.0, ..Projecting::plain(Footprint::Disc) };
    let most = |cloud: &DeviceCloud| (cloud.max_opacity(), cloud.max_color(&how), cloud.max_radius());
    assert_eq!(most(live), most(fresh), "{what}");
    assert_eq!((live.parts(0.4), live.columns()), (fresh.parts(0.4), fresh.columns()), "{what}");
    let bits = |buffer: &Buffer<[f32; 4]>| -> Vec<[u32; 4]> {
        buffer.read(0, buffer.len()).unwrap().into_iter().map(|v| v.map(f32::to_bits)).collect()
    };
    let all = |cloud: &DeviceCloud| [bits(&cloud.points_hi), bits(&cloud.points_lo), bits(&cloud.point_colors)];
    assert_eq!(all(live), all(fresh), "{what}");
    // Without a field the buffer has one undefined element.
    assert_eq!(live.fields.len(), fresh.fields.len(), "{what}");
    if live.fields.len() == live.len() {
        let fields = |cloud: &DeviceCloud| cloud.fields.read(0, cloud.len()).unwrap();
        assert_eq!(fields(live), fields(fresh), "{what}");
    }
    // Cast shadows survive methods that don't use them.
    if live.has_normals() {
        let normals = |cloud: &DeviceCloud| bits(&cloud.normals).into_iter().map(|[x, y, z, _]| [x, y, z]).collect();
        let [live, fresh]: [Vec<[u32; 3]>; 2] = [normals(live), normals(fresh)];
        assert_eq!(live, fresh, "{what}");
    }
    if live.casting() == fresh.casting() {
        assert_eq!(live.lit().unwrap(), fresh.lit().unwrap(), "{what}");
    }
}

pub fn words(key: &str, word: &str) -> (String, Setting) {
    (key.into(), Setting::Word(word.into()))
}

pub fn number(key: &str, value: f64) -> (String, Setting) {
    (key.into(), Setting::Number(value))
}

pub fn numbers(key: &str, values: [f64; 3]) -> (String, Setting) {
    (key.into(), Setting::Numbers(values.to_vec()))
}
