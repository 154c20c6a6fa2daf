//! Renders a file, or three spheres of points without one, and writes a picture.
//!
//! ```sh
//! cargo run --release --example render_file -- scan.laz
//! ```

use std::path::PathBuf;

use pellucid::{Cloud, Renderer, Result, Scene};

pub(crate) fn main() -> Result<()> {
    let mut scene = match std::env::args_os().nth(1).map(PathBuf::from).filter(|path| path.exists()) {
        Some(path) => Scene::read(path)?,
        None => Scene::from_clouds([
            sphere(1.0, [0.9, 0.5, 0.2])?,
            sphere(0.7, [0.2, 0.7, 0.4])?,
            sphere(0.4, [0.2, 0.3, 0.9])?,
        ])?,
    };
    scene.set_see_through(0.5);
    let renderer = Renderer::open()?;
    let mut loaded = renderer.load(&scene)?;
    println!("{} points on {}, method {}: {}", loaded.len(), renderer.device_name(), loaded.method(), loaded.reason());
    let picture = loaded.frame().size(640, 480).render()?;
    let path = std::env::temp_dir().join("pellucid-file.png");
    picture.save(&path)?;
    println!("{}", path.display());
    Ok(())
}

/// A sphere of points, spread by the golden angle.
fn sphere(radius: f64, color: [f32; 3]) -> Result<Cloud> {
    let count = 4000;
    let golden_angle = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let position = |i: i32| {
        let y = 1.0 - 2.0 * (f64::from(i) + 0.5) / f64::from(count);
        let (sin, cos) = (golden_angle * f64::from(i)).sin_cos();
        let ring = (1.0 - y * y).sqrt();
        [radius * ring * cos, radius * y, radius * ring * sin]
    };
    let positions: Vec<[f64; 3]> = (0..count).map(position).collect();
    Cloud::from_positions(positions).color(color).opacity(0.06).build()
}
