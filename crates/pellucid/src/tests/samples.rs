//! Samples of a pixel's area.

use pellucid::{Camera, Cloud, ErrorKind, Renderer, Result, Samples, Scene};
use pellucid_testing::has_device;

/// A disc of 500 pixels whose left edge cuts a column of pixels at a quarter of their width: it strays by less than
/// 4²/(2 · 500) of a pixel within the picture. Of N columns of samples, none so near that edge, ¾ are covered where N
/// is a multiple of 4, and a half of 2, of which one lies on the edge's outer side.
#[test]
fn a_pixel_that_is_three_quarters_covered_has_three_quarters_of_the_opacity() -> Result<()> {
    if !has_device() {
        return Ok(());
    }
    let radius = 500.0;
    let cloud =
        Cloud::from_positions([[radius + 0.25, 0.0, 0.0]]).radius(radius as f32).color([1.0, 1.0, 1.0]).build()?;
    let mut scene = Scene::from_clouds([cloud])?;
    scene.set("image.size", [8, 8])?;
    scene.set("method.name", "circles")?;
    scene.set("method.max_pixel_radius", 1000.0)?;
    scene.set("shading.model", "none")?;
    let camera = Camera::look_at([0.0, 0.0, 10_000.0], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]).orthographic(8.0);
    let mut loaded = Renderer::open()?.load(&scene)?;
    // Pixels are 1 wide, and column 4 begins at x = 0.
    let of = |picture: &pellucid::Picture| picture.pixels()[4 * 8 + 4][3];
    for (samples, covered) in [(1, 1.0), (4, 0.75), (16, 0.75)] {
        let picture = loaded.frame().camera(camera).samples(samples).render()?;
        assert_eq!((picture.samples(), of(&picture)), (samples, covered));
    }
    // 2 samples differ from 4, and 4 from 8 no more.
    let picture = loaded.frame().camera(camera).samples(Samples::Auto).render()?;
    assert_eq!((picture.samples(), of(&picture)), (8, 0.75));
    let refused = loaded.frame().samples(3).render().err().expect("3 is no power of 2");
    assert_eq!(refused.kind(), ErrorKind::Argument);
    assert!(refused.to_string().contains("samples: expected 1, 2, 4, 8, 16, 32 or 64, found 3"), "{refused}");
    Ok(())
}
