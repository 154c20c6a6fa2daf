//! Settings of soft spheres give the model of the reference.

use pellucid_engine::methods::soft::SoftModel;
use pellucid_reference::soft::Strength;
use pellucid_scene::{Density, Method, Soft};

#[test]
fn the_strength_of_soft_spheres_is_that_of_the_reference() {
    for model in [Method::SoftBase, Method::SoftConcentric, Method::SoftExpress] {
        for radius in [1e-6f32, 0.3, 1.0, 7e5] {
            for density in [0.0, 1e-6, 0.5, 0.999, 1.0]
                .map(Density::Softness)
                .into_iter()
                .chain([0.0, 0.1, 2.0].map(Density::Lambda))
            {
                let soft = Soft { density, ..Soft::default() };
                let wanted = Strength::new(&model(soft), &soft, f64::from(radius));
                let found = SoftModel::new(&model(soft), &soft, radius);
                for (found, wanted) in [(found.lambda, wanted.lambda), (found.peak, wanted.peak)] {
                    // Rounded to float32 once or twice.
                    assert!((f64::from(found) - wanted).abs() <= 2e-7 * wanted.abs(), "{found} {wanted}");
                }
            }
        }
    }
}
