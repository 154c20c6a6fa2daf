//! Renders arrays in a loop with a moving camera: one upload, many frames.

use pellucid::{Camera, Cloud, Renderer, Result, Scene};

pub(crate) fn main() -> Result<()> {
    // A helix whose color changes along the way.
    let turns = 5.0 * std::f64::consts::TAU;
    let at = |i: i32| turns * f64::from(i) / 5000.0;
    let positions: Vec<[f64; 3]> = (0..5000).map(|i| [at(i).cos(), 0.08 * at(i) - 1.25, at(i).sin()]).collect();
    let colors: Vec<[f32; 3]> = (0..5000).map(|i| [i as f32 / 5000.0, 0.4, 1.0 - i as f32 / 5000.0]).collect();
    let cloud = Cloud::from_positions(positions).colors(colors).radius(0.05).opacity(0.4).build()?;

    let renderer = Renderer::open()?;
    let mut loaded = renderer.load(&Scene::from_clouds([cloud])?)?;
    for step in 0..12 {
        let (sin, cos) = (f64::from(step) / 12.0 * std::f64::consts::TAU).sin_cos();
        let camera = Camera::look_at([4.0 * sin, 1.5, 4.0 * cos], [0.0; 3], [0.0, 1.0, 0.0]).perspective(40.0);
        let picture = loaded.frame().camera(camera).size(320, 240).render()?;
        let covered = picture.pixels().iter().filter(|[.., a]| *a > 0.0).count();
        println!("frame {step}: {covered} pixels, {:?} on the device", picture.profile().device_time());
        assert!(covered > 0, "the camera looks at the helix");
    }
    Ok(())
}
