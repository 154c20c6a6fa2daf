//! Claims of files about how their cloud was prepared.

/// Checks what is claimed of how a cloud was prepared.
pub(crate) fn check_claim(neighbors: usize, radius_cap: f32) -> Result<(), String> {
    if neighbors == 0 || neighbors > 65_535 {
        return Err(format!("claims {neighbors} neighbors"));
    }
    if !(radius_cap >= 0.0 && radius_cap.is_finite()) {
        return Err(format!("claims a radius cap of {radius_cap}"));
    }
    Ok(())
}
