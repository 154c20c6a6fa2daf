//! Follows a camera path of one's own: a spiral from afar to the middle of a cloud, as numbered pictures.

use pellucid::{Camera, Cloud, Renderer, Result, Scene};

pub(crate) fn main() -> Result<()> {
    // A cube of points.
    let side = 16;
    let along = |i: i32| f64::from(i) / f64::from(side - 1) - 0.5;
    let positions: Vec<[f64; 3]> =
        (0..side * side * side).map(|i| [along(i % side), along(i / side % side), along(i / side / side)]).collect();
    let scene = Scene::from_clouds([Cloud::from_positions(positions).opacity(0.15).build()?])?;
    let renderer = Renderer::open()?;
    let mut loaded = renderer.load(&scene)?;

    let folder = std::env::temp_dir().join("pellucid-path");
    std::fs::create_dir_all(&folder).expect("a temporary folder can be made");
    let frames = 8;
    for frame in 0..frames {
        let t = f64::from(frame) / f64::from(frames - 1);
        let (distance, angle) = (3.0 - 2.6 * t, 1.5 * t * std::f64::consts::PI);
        let eye = [distance * angle.sin(), 0.4 * (1.0 - t), distance * angle.cos()];
        let camera = Camera::look_at(eye, [0.0; 3], [0.0, 1.0, 0.0]).perspective(60.0);
        let path = folder.join(format!("frame-{frame:03}.png"));
        loaded.frame().camera(camera).size(240, 180).render()?.save(&path)?;
        println!("{}", path.display());
    }
    Ok(())
}
