//! Reads the profile of a frame: time, invocations and bytes of each pass.

use pellucid::{Cloud, Method, Renderer, Result, Scene};

pub(crate) fn main() -> Result<()> {
    // A slab of points that lie behind each other.
    let positions: Vec<[f64; 3]> =
        (0..20_000).map(|i| [f64::from(i % 50), f64::from(i / 50 % 50), f64::from(i / 2500)]).collect();
    let mut scene = Scene::from_clouds([Cloud::from_positions(positions).opacity(0.1).build()?])?;
    scene.set("image.size", [400, 400])?;

    let renderer = Renderer::open()?;
    let picture = renderer.load(&scene)?.frame().method(Method::ABuffer).counts().timed().render()?;
    let profile = picture.profile();
    for pass in profile.passes() {
        let rate =
            pass.bytes.map_or(String::new(), |b| format!("{:.2} GB/s", b as f64 / pass.time.as_secs_f64() / 1e9));
        println!("{:<22} {:>10.3} ms  {rate}", pass.name, pass.time.as_secs_f64() * 1e3);
    }
    let mean = profile.fragments() as f64 / f64::from(picture.width() * picture.height());
    println!("{mean:.1} fragments a pixel, {} at most; {} bytes", profile.longest_list(), profile.peak_device_bytes());
    assert_eq!(picture.fragments().map(|f| f.iter().map(|n| u64::from(*n)).sum()), Some(profile.fragments()));
    Ok(())
}
