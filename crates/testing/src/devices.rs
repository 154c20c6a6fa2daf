//! Devices for tests, with validation.
//!
//! Old validation layers take it ill if one thread opens or closes a device while another one uses its own
//! (docs/internals/validation-layers.md), so that these are kept apart in time.

use std::sync::{Condvar, Mutex, MutexGuard, OnceLock, PoisonError, RwLock, RwLockReadGuard};

use pellucid_gpu::{Device, DeviceOptions, Preferences};

use crate::skip::{NO_DEVICE, skip};

/// Tests with a device at a time; further ones wait.
const MOST: usize = 4;

/// Held while a test uses a device, and exclusively while one is opened or closed.
static IN_USE: RwLock<()> = RwLock::new(());

static POOL: Mutex<Pool> = Mutex::new(Pool { idle: Vec::new(), bound: Vec::new(), to_open: None, error: None });
/// Tells that the pool has changed.
static CHANGED: Condvar = Condvar::new();

struct Pool {
    /// Devices that no test has.
    idle: Vec<Device>,
    /// Idle devices that bind at most so many bytes.
    bound: Vec<(u64, Device)>,
    /// Number of devices that are still to be opened; `None` before the first one is asked for.
    to_open: Option<usize>,
    /// Reason that no device can be opened.
    error: Option<String>,
}

/// Runs a test on a device with validation and synchronization validation. One test at a time has it, and hands it on
/// with all its pipelines. Afterwards there must be no message and no allocation left. Without a device the test is
/// skipped.
pub fn with_device(test: impl FnOnce(&Device)) {
    match borrowed() {
        Ok(device) => {
            let device = Lent::new(device, true).run(test);
            pool().idle.push(device);
            CHANGED.notify_all();
        }
        Err(error) => skip(NO_DEVICE, &error),
    }
}

/// Runs a test like [`with_device`], with at most so many bytes in a binding.
pub fn with_device_that_binds(binding_bytes: Option<u64>, test: impl FnOnce(&Device)) {
    let Some(most) = binding_bytes else { return with_device(test) };
    let idle = {
        let bound = &mut pool().bound;
        let at = bound.iter().position(|(bytes, _)| *bytes == most);
        at.map(|at| bound.swap_remove(at).1)
    };
    match idle.map_or_else(|| apart(|| open(binding_bytes)), Ok) {
        Ok(device) => {
            let device = Lent::new(device, false).run(test);
            pool().bound.push((most, device));
        }
        Err(error) => skip(NO_DEVICE, &error),
    }
}

/// Runs a test like [`with_device`], with a device that was never used: for tests of how much memory it reserves.
pub fn with_new_device(test: impl FnOnce(&Device)) {
    with_opened(|| open(None), test);
}

/// Runs a test like [`with_new_device`], with work shaped like this, whatever the device prefers.
pub fn with_device_that_prefers(prefers: Preferences, test: impl FnOnce(&Device)) {
    with_device_of(&DeviceOptions { prefers: Some(prefers), ..DeviceOptions::validated() }, test);
}

/// Runs a test like [`with_new_device`], with a device that is opened by these options.
pub fn with_device_of(options: &DeviceOptions, test: impl FnOnce(&Device)) {
    with_opened(|| Device::open(options).map_err(|error| error.to_string()), test);
}

/// Runs a test on a device that is opened for it and closed behind it.
#[track_caller]
fn with_opened(open: impl FnOnce() -> Result<Device, String>, test: impl FnOnce(&Device)) {
    match apart(open) {
        Ok(device) => {
            let device = Lent::new(device, false).run(test);
            apart(|| drop(device));
        }
        Err(error) => skip(NO_DEVICE, &error),
    }
}

/// Runs a test like [`with_new_device`], while no other test of this process uses one: for tests that take all memory.
pub fn with_only_device(test: impl FnOnce(&Device)) {
    alone(|| {
        let device = open(None).expect("one was opened just now");
        test(&device);
        assert_clean(&device);
    });
}

/// Runs a test that opens devices itself, while no other test of this process uses one. Without a device it is skipped.
pub fn alone(test: impl FnOnce()) {
    let ran: Result<(), String> = apart(|| {
        drop(open(None)?);
        test();
        Ok(())
    });
    if let Err(error) = ran {
        skip(NO_DEVICE, &error);
    }
}

/// True if there is a device with validation, the one that `PELLUCID_TEST_DEVICE` names or the best. For tests that run
/// the binary on it; without one the test is skipped.
#[track_caller]
pub fn has_device() -> bool {
    static FOUND: OnceLock<Result<(), String>> = OnceLock::new();
    let found = FOUND.get_or_init(|| {
        let device = std::env::var("PELLUCID_TEST_DEVICE").ok();
        let options = DeviceOptions { device, validation: true, ..DeviceOptions::default() };
        apart(|| Device::open(&options).map(drop).map_err(|error| error.to_string()))
    });
    if let Err(error) = found {
        skip(NO_DEVICE, error);
    }
    found.is_ok()
}

/// A device that no other test has, as soon as there is one. The first test opens one for each thread of tests.
fn borrowed() -> Result<Device, String> {
    let mut pool = pool();
    loop {
        if let Some(device) = pool.idle.pop() {
            return Ok(device);
        }
        if let Some(error) = &pool.error {
            return Err(error.clone());
        }
        let to_open = pool.to_open.replace(0).unwrap_or_else(threads);
        if to_open == 0 {
            pool = CHANGED.wait(pool).unwrap_or_else(PoisonError::into_inner);
            continue;
        }
        drop(pool);
        let opened: Result<Vec<Device>, String> = apart(|| (0..to_open).map(|_| open(None)).collect());
        pool = self::pool();
        match opened {
            Ok(devices) => pool.idle.extend(devices),
            Err(error) => pool.error = Some(error),
        }
        CHANGED.notify_all();
    }
}

/// Threads that run tests, up to [`MOST`].
fn threads() -> usize {
    let asked = std::env::var("RUST_TEST_THREADS").ok().and_then(|threads| threads.parse().ok());
    asked.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from)).clamp(1, MOST)
}

fn pool() -> MutexGuard<'static, Pool> {
    POOL.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Runs something while no test uses a device.
fn apart<T>(run: impl FnOnce() -> T) -> T {
    let _exclusive = IN_USE.write().unwrap_or_else(PoisonError::into_inner);
    run()
}

fn open(binding_bytes: Option<u64>) -> Result<Device, String> {
    Device::open(&DeviceOptions { binding_bytes, ..DeviceOptions::validated() }).map_err(|error| error.to_string())
}

fn assert_clean(device: &Device) {
    assert_eq!(device.validation_messages(), Vec::<String>::new());
    assert_eq!(device.live_allocations(), Vec::new(), "leaked");
}

/// A device that a test has.
struct Lent {
    device: Option<Device>,
    is_pooled: bool,
    _in_use: RwLockReadGuard<'static, ()>,
}

impl Lent {
    fn new(device: Device, is_pooled: bool) -> Self {
        let _in_use = IN_USE.read().unwrap_or_else(PoisonError::into_inner);
        Self { device: Some(device), is_pooled, _in_use }
    }

    /// Runs a test; the device again, on which nothing is left and about which nothing was said.
    fn run(mut self, test: impl FnOnce(&Device)) -> Device {
        let device = self.device.as_ref().expect("until it is handed in");
        test(device);
        assert_clean(device);
        device.allow_submissions(None);
        self.device.take().expect("until it is handed in")
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        // The test failed. Its device is not closed, since others use theirs, and another one takes its place.
        if let Some(device) = self.device.take() {
            std::mem::forget(device);
            if self.is_pooled {
                *pool().to_open.get_or_insert(0) += 1;
                CHANGED.notify_all();
            }
        }
    }
}
