//! A file to a picture, with the time of each pass, in ten lines.

use pellucid::{Method, Renderer, Scene};

const SCAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/lidar/sample_c_2k.las");

pub(crate) fn main() -> pellucid::Result<()> {
    let scene = Scene::read(SCAN)?;
    let picture = Renderer::open()?.load(&scene)?.frame().method(Method::ABuffer).timed().render()?;
    picture.save(std::env::temp_dir().join("pellucid-quick-start.png"))?;
    for pass in picture.profile().passes() {
        println!("{:<22} {:?}", pass.name, pass.time);
    }
    Ok(())
}
