//! Captures of frames by RenderDoc, through its in-application API (renderdoc_app.h, version 1.0.0).

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::{NonNull, null_mut};

#[cfg(unix)]
use libloading::os::unix as platform;
#[cfg(windows)]
use libloading::os::windows as platform;
use platform::Library;

use super::Error;

/// The version that is asked for: 1.0.0. Later ones have the same functions at the same places.
const VERSION: c_int = 10_000;

type GetApi = unsafe extern "C" fn(version: c_int, functions: *mut *mut c_void) -> c_int;

/// Functions of RenderDoc, of which only those with names are called.
#[repr(C)]
struct Functions {
    _options: [*const c_void; 13],
    count: unsafe extern "C" fn() -> u32,
    get: unsafe extern "C" fn(index: u32, path: *mut c_char, length: *mut u32, time: *mut u64) -> u32,
    _windows: [*const c_void; 4],
    start: unsafe extern "C" fn(device: *mut c_void, window: *mut c_void),
    _is_capturing: *const c_void,
    end: unsafe extern "C" fn(device: *mut c_void, window: *mut c_void) -> u32,
}

/// RenderDoc in this process.
pub struct Capture {
    functions: NonNull<Functions>,
    /// The library, without which the functions would be gone.
    _library: Option<Library>,
}

impl Capture {
    /// Finds RenderDoc, which must have been loaded before the device was opened: it watches Vulkan from the beginning.
    ///
    /// # Errors
    /// Returns [`Error::Capture`] if it is not loaded.
    pub fn open() -> Result<Self, Error> {
        let library = loaded().map_err(|_| {
            Error::Capture(
                "RenderDoc isn't loaded; start pellucid from RenderDoc or by `renderdoccmd capture`, or set \
                 ENABLE_VULKAN_RENDERDOC_CAPTURE=1 where RenderDoc is installed"
                    .to_owned(),
            )
        })?;
        // SAFETY: the type is that of renderdoc_app.h.
        let get_api = *unsafe { library.get::<GetApi>(b"RENDERDOC_GetAPI\0") }
            .map_err(|error| Error::Capture(format!("what is loaded as RenderDoc is something else: {error}")))?;
        Self::of(get_api, Some(library))
    }

    fn of(get_api: GetApi, library: Option<Library>) -> Result<Self, Error> {
        let mut functions = null_mut();
        // SAFETY: the function of renderdoc_app.h, which writes a pointer to its table.
        let found = unsafe { get_api(VERSION, &raw mut functions) };
        match NonNull::new(functions.cast()).filter(|_| found == 1) {
            Some(functions) => Ok(Self { functions, _library: library }),
            None => Err(Error::Capture("this RenderDoc doesn't know version 1.0.0 of its interface".to_owned())),
        }
    }

    /// Captures all that `work` submits, and returns its result with the path of the capture.
    ///
    /// # Errors
    /// Returns [`Error::Capture`] if RenderDoc captured nothing.
    pub fn around<T>(&self, work: impl FnOnce() -> T) -> (T, Result<String, Error>) {
        // SAFETY: RenderDoc's own table, which is there as long as its library.
        let functions = unsafe { self.functions.as_ref() };
        // SAFETY: no device and no window mean those that there are.
        unsafe { (functions.start)(null_mut(), null_mut()) };
        let result = work();
        // SAFETY: as above; a capture was started.
        let ended = unsafe { (functions.end)(null_mut(), null_mut()) };
        let path = (ended == 1).then(|| last_path(functions)).flatten();
        let nothing = || Error::Capture("RenderDoc captured nothing; its log says why".to_owned());
        (result, path.ok_or_else(nothing))
    }
}

/// Returns the path of the last capture.
fn last_path(functions: &Functions) -> Option<String> {
    // SAFETY: plain queries; without a place for the path RenderDoc writes its length alone, with the zero at its end.
    unsafe {
        let index = (functions.count)().checked_sub(1)?;
        let mut length = 0;
        ((functions.get)(index, null_mut(), &raw mut length, null_mut()) == 1).then_some(())?;
        // One more zero, whatever RenderDoc counts.
        let mut path = vec![0u8; length as usize + 1];
        ((functions.get)(index, path.as_mut_ptr().cast(), &raw mut length, null_mut()) == 1).then_some(())?;
        CStr::from_bytes_until_nul(&path).ok().map(|path| path.to_string_lossy().into_owned())
    }
}

/// Returns RenderDoc's library if this process has it already.
#[cfg(unix)]
fn loaded() -> Result<Library, libloading::Error> {
    /// Flag of <dlfcn.h>: a library that is not there yet is not loaded.
    const RTLD_NOLOAD: c_int = if cfg!(target_os = "macos") { 0x10 } else { 4 };
    // SAFETY: nothing is loaded, so that no initializer runs.
    unsafe { Library::open(Some("librenderdoc.so"), platform::RTLD_NOW | RTLD_NOLOAD) }
}

/// Returns RenderDoc's library if this process has it already.
#[cfg(windows)]
fn loaded() -> Result<Library, libloading::Error> {
    Library::open_already_loaded("renderdoc.dll")
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::ptr::null;

    use super::*;

    thread_local! {
        /// Calls in their order.
        static CALLS: RefCell<Vec<&'static str>> = const { RefCell::new(Vec::new()) };
    }

    fn note(call: &'static str) {
        CALLS.with_borrow_mut(|calls| calls.push(call));
    }

    unsafe extern "C" fn count() -> u32 {
        2
    }

    /// Two captures, of which the second one's path is known.
    unsafe extern "C" fn get(index: u32, path: *mut c_char, length: *mut u32, _time: *mut u64) -> u32 {
        let known = c"/tmp/second.rdc".to_bytes_with_nul();
        // SAFETY: the caller gives room for as many bytes as it was told, or none.
        unsafe {
            *length = known.len() as u32;
            if !path.is_null() {
                known.as_ptr().copy_to(path.cast(), known.len());
            }
        }
        u32::from(index == 1)
    }

    unsafe extern "C" fn start(_device: *mut c_void, _window: *mut c_void) {
        note("start");
    }

    unsafe extern "C" fn end(_device: *mut c_void, _window: *mut c_void) -> u32 {
        note("end");
        1
    }

    unsafe extern "C" fn fails(_device: *mut c_void, _window: *mut c_void) -> u32 {
        0
    }

    fn functions(end: unsafe extern "C" fn(*mut c_void, *mut c_void) -> u32) -> *mut c_void {
        let (_options, _windows, _is_capturing) = ([null(); 13], [null(); 4], null());
        Box::into_raw(Box::new(Functions { _options, count, get, _windows, start, _is_capturing, end })).cast()
    }

    unsafe extern "C" fn captures(version: c_int, out: *mut *mut c_void) -> c_int {
        // SAFETY: the caller's variable.
        unsafe { *out = functions(end) };
        c_int::from(version == 10_000)
    }

    unsafe extern "C" fn captures_nothing(_version: c_int, out: *mut *mut c_void) -> c_int {
        // SAFETY: the caller's variable.
        unsafe { *out = functions(fails) };
        1
    }

    unsafe extern "C" fn is_older(_version: c_int, _out: *mut *mut c_void) -> c_int {
        0
    }

    #[test]
    fn the_functions_stand_where_renderdoc_has_them() {
        // GetNumCaptures, GetCapture, StartFrameCapture and EndFrameCapture are numbers 13, 14, 19 and 21 of
        // RENDERDOC_API_1_0_0.
        let places = [
            std::mem::offset_of!(Functions, count),
            std::mem::offset_of!(Functions, get),
            std::mem::offset_of!(Functions, start),
            std::mem::offset_of!(Functions, end),
        ];
        assert_eq!(places, [13, 14, 19, 21].map(|number| number * size_of::<*const c_void>()));
    }

    #[test]
    fn work_is_captured_from_its_begin_to_its_end() {
        let capture = Capture::of(captures, None).expect("it knows the version");
        let (result, path) = capture.around(|| {
            note("work");
            7
        });
        assert_eq!((result, path.expect("captured").as_str()), (7, "/tmp/second.rdc"));
        CALLS.with_borrow(|calls| assert_eq!(calls, &["start", "work", "end"]));
    }

    #[test]
    fn a_failed_capture_and_an_old_interface_are_errors() {
        let capture = Capture::of(captures_nothing, None).expect("it knows the version");
        let (result, path) = capture.around(|| 7);
        assert_eq!(result, 7);
        assert!(path.expect_err("nothing").to_string().contains("RenderDoc captured nothing"));
        let error = Capture::of(is_older, None).err().expect("another version").to_string();
        assert!(error.contains("doesn't know version 1.0.0"), "{error}");
    }

    #[test]
    fn without_renderdoc_the_error_says_how_to_load_it() {
        let error = Capture::open().err().expect("tests run without RenderDoc").to_string();
        assert!(error.contains("RenderDoc isn't loaded; start pellucid from RenderDoc"), "{error}");
    }
}
