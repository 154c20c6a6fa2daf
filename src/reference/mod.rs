//! The methods in float64 over slices, written from the equations; no device is involved.
