//! Devices for tests, with validation.

use std::sync::{Mutex, OnceLock, PoisonError, RwLock};

use pellucid_engine::gpu::{Device, DeviceOptions};

use crate::skip::{NO_DEVICE, skip};

/// Held while a test has a device, exclusively by a test that must be alone.
static TURN: RwLock<()> = RwLock::new(());

/// Devices that tests have handed in, by the largest binding that they allow.
static IDLE: Mutex<Vec<(Option<u64>, Device)>> = Mutex::new(Vec::new());

/// Runs a test on a device with validation and synchronization validation. One test at a time has it, and hands it on with all
/// its pipelines. Afterwards there must be no message and no allocation left. Without a device the test is skipped.
pub fn with_device(test: impl FnOnce(&Device)) {
    with_device_that_binds(None, test);
}

/// As [`with_device`], with at most so many bytes in a binding.
pub fn with_device_that_binds(binding_bytes: Option<u64>, test: impl FnOnce(&Device)) {
    let _turn = TURN.read().unwrap_or_else(PoisonError::into_inner);
    let Some(device) = idle(binding_bytes).or_else(|| open(binding_bytes)) else { return };
    test(&device);
    assert_clean(&device);
    device.allow_submissions(None);
    IDLE.lock().unwrap_or_else(PoisonError::into_inner).push((binding_bytes, device));
}

/// As [`with_device`], with a device that was never used: for tests of how much memory it reserves.
pub fn with_new_device(test: impl FnOnce(&Device)) {
    let _turn = TURN.read().unwrap_or_else(PoisonError::into_inner);
    use_new(test);
}

/// As [`with_new_device`], while no other test of this process has a device: for tests that take all memory.
pub fn with_only_device(test: impl FnOnce(&Device)) {
    let _turn = TURN.write().unwrap_or_else(PoisonError::into_inner);
    use_new(test);
}

fn use_new(test: impl FnOnce(&Device)) {
    let Some(device) = open(None) else { return };
    test(&device);
    assert_clean(&device);
}

/// Whether there is a device with validation, the one that `PELLUCID_TEST_DEVICE` names or the best. Without one the test is
/// skipped.
#[track_caller]
pub fn has_device() -> bool {
    static FOUND: OnceLock<Result<(), String>> = OnceLock::new();
    let found = FOUND.get_or_init(|| {
        let device = std::env::var("PELLUCID_TEST_DEVICE").ok();
        let options = DeviceOptions { device, validation: true, ..DeviceOptions::default() };
        Device::open(&options).map(drop).map_err(|error| error.to_string())
    });
    if let Err(error) = found {
        skip(NO_DEVICE, error);
    }
    found.is_ok()
}

/// A device that was handed in.
fn idle(binding_bytes: Option<u64>) -> Option<Device> {
    let mut idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner);
    let at = idle.iter().position(|(bytes, _)| *bytes == binding_bytes)?;
    Some(idle.swap_remove(at).1)
}

/// A new device.
fn open(binding_bytes: Option<u64>) -> Option<Device> {
    match Device::open(&DeviceOptions { binding_bytes, ..DeviceOptions::validated() }) {
        Ok(device) => Some(device),
        Err(error) => {
            skip(NO_DEVICE, &error.to_string());
            None
        }
    }
}

fn assert_clean(device: &Device) {
    assert_eq!(device.validation_messages(), Vec::<String>::new());
    assert_eq!(device.live_allocations(), Vec::new(), "leaked");
}
