//! Devices for tests, with validation.

use std::sync::{Mutex, OnceLock, PoisonError};

use pellucid::gpu::{Device, DeviceOptions};

/// Runs a test on a device with validation and synchronization validation; afterwards there must be no message and no
/// allocation left. Without a device the test is skipped with a note, or fails if `PELLUCID_REQUIRE_GPU` is 1.
pub fn with_device(test: impl FnOnce(&Device)) {
    with_device_that_binds(None, test);
}

/// As [`with_device`], with at most so many bytes in a binding.
pub fn with_device_that_binds(binding_bytes: Option<u64>, test: impl FnOnce(&Device)) {
    // One device at a time: its peak and its live allocations are then this test's own.
    static SERIAL: Mutex<()> = Mutex::new(());
    let _guard = SERIAL.lock().unwrap_or_else(PoisonError::into_inner);
    match Device::open(&DeviceOptions { binding_bytes, ..DeviceOptions::validated() }) {
        Ok(device) => {
            test(&device);
            assert_eq!(device.validation_messages(), Vec::<String>::new());
            assert_eq!(device.live_allocations(), Vec::new(), "leaked");
        }
        Err(e) if std::env::var("PELLUCID_REQUIRE_GPU").is_ok_and(|v| v == "1") => panic!("a device is required: {e}"),
        Err(e) => eprintln!("skipped, no device: {e}"),
    }
}

/// Whether there is a device with validation, the one that `PELLUCID_TEST_DEVICE` names or the best. Without one a test is
/// skipped with a note, or fails if `PELLUCID_REQUIRE_GPU` is 1.
pub fn has_device() -> bool {
    static FOUND: OnceLock<bool> = OnceLock::new();
    *FOUND.get_or_init(|| {
        let device = std::env::var("PELLUCID_TEST_DEVICE").ok();
        match Device::open(&DeviceOptions { device, validation: true, ..DeviceOptions::default() }) {
            Ok(_) => true,
            Err(e) if std::env::var("PELLUCID_REQUIRE_GPU").is_ok_and(|v| v == "1") => {
                panic!("a device is required: {e}")
            }
            Err(e) => {
                eprintln!("skipped, no device: {e}");
                false
            }
        }
    })
}
