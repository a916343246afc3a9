//! An Embree device: the library's state, its threads and the errors it reports.

use std::ffi::{CStr, CString, c_char, c_void};
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::{self, ThreadId};

use crate::error::{DeviceError, ErrorCode};
use crate::raw;

/// Version of the header this crate was built against, such as `3.13.5`.
pub const HEADER_VERSION: &str = match raw::RTC_VERSION_STRING.to_str() {
    Ok(text) => text,
    Err(_) => panic!("the header's version is not UTF-8"),
};

/// A library version, ordered as versions are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Version {
    /// 3 or 4.
    pub major: u32,
    /// 13 at least where major is 3.
    pub minor: u32,
    /// Bug fixes.
    pub patch: u32,
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

/// Version of the Embree library that is linked, asked of the library itself and remembered.
///
/// # Errors
/// When no device can be created.
pub fn version() -> Result<Version, DeviceError> {
    static VERSION: OnceLock<Result<Version, DeviceError>> = OnceLock::new();
    VERSION.get_or_init(|| Ok(Device::with_config("threads=1")?.version())).clone()
}

/// An Embree device. Cheap to clone; scenes keep it alive.
#[derive(Clone)]
pub struct Device {
    handle: Arc<Handle>,
}

struct Handle {
    device: raw::RTCDevice,
    // Shared with the callback by address: an Arc's content stays where it is.
    errors: Arc<ErrorLog>,
}

// SAFETY: Embree documents its API calls on a device as thread-safe; the only mutable state of ours is the error log
// behind its mutex.
unsafe impl Send for Handle {}
// SAFETY: as for Send; `&Handle` only gives the device handle to such calls.
unsafe impl Sync for Handle {}

/// Errors in the order in which they came, each with the thread whose call caused it: Embree reports on the calling
/// thread, so two threads that build scenes on one device do not take each other's errors.
#[derive(Default)]
struct ErrorLog {
    entries: Mutex<Vec<(ThreadId, DeviceError)>>,
}

impl ErrorLog {
    fn push(&self, error: DeviceError) {
        // A poisoned log is still a list of errors, and a callback from C must not unwind.
        self.entries.lock().unwrap_or_else(PoisonError::into_inner).push((thread::current().id(), error));
    }
}

/// Embree calls this on the thread of the failing call. A panic here would abort (`extern "C"`), not unwind.
unsafe extern "C" fn on_error(log: *mut c_void, code: raw::RTCError, text: *const c_char) {
    // SAFETY: `log` is the pointer given to rtcSetDeviceErrorFunction: an ErrorLog that `Handle` gives up only after
    // it has unset this callback and released the device. Shared access only; the log locks itself.
    let log = unsafe { &*log.cast::<ErrorLog>() };
    let text = if text.is_null() {
        String::new()
    } else {
        // SAFETY: Embree passes a NUL-terminated string that lives during the call.
        unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
    };
    log.push(DeviceError { code: ErrorCode(code), text });
}

impl Device {
    /// A device with Embree's defaults: as many build threads as the machine has.
    ///
    /// # Errors
    /// When Embree refuses (memory, an unsupported processor), or when the linked library's major version is not the
    /// header's.
    pub fn new() -> Result<Self, DeviceError> {
        Self::with_config("")
    }

    /// A device with Embree's configuration string, such as `threads=1`, which starts no threads.
    ///
    /// # Errors
    /// As [`Device::new`], and when the string holds a NUL.
    pub fn with_config(config: &str) -> Result<Self, DeviceError> {
        let refuse = |code, text: String| DeviceError { code, text };
        let config = CString::new(config)
            .map_err(|_| refuse(ErrorCode::INVALID_ARGUMENT, "the device configuration holds a NUL".into()))?;
        // SAFETY: `config` is NUL-terminated and lives during the call.
        let device = unsafe { raw::rtcNewDevice(config.as_ptr()) };
        if device.is_null() {
            // SAFETY: a null device is allowed here and asks for this thread's creation error.
            let code = unsafe { raw::rtcGetDeviceError(std::ptr::null_mut()) };
            return Err(refuse(ErrorCode(code), "no device could be created".into()));
        }
        let errors = Arc::new(ErrorLog::default());
        let log = Arc::as_ptr(&errors).cast_mut().cast::<c_void>();
        // SAFETY: the device is alive, and `log` stays where it is until Handle::drop has unset the callback.
        unsafe { raw::rtcSetDeviceErrorFunction(device, Some(on_error), log) };
        let device = Self { handle: Arc::new(Handle { device, errors }) };
        let (linked, built) = (device.version(), raw::RTC_VERSION_MAJOR);
        if linked.major != built {
            let text = format!("Embree {linked} is linked, but this was built for {HEADER_VERSION}");
            return Err(refuse(ErrorCode::INVALID_OPERATION, text));
        }
        Ok(device)
    }

    /// Version of the linked library.
    pub fn version(&self) -> Version {
        // SAFETY: the device is alive; the property exists since Embree 3.0.
        let number = unsafe { raw::rtcGetDeviceProperty(self.raw(), raw::RTC_DEVICE_PROPERTY_VERSION) };
        let number = u32::try_from(number).unwrap_or(0);
        Version { major: number / 10_000, minor: number / 100 % 100, patch: number % 100 }
    }

    /// Takes all errors that were reported and not yet returned by a failing call, oldest first.
    pub fn take_errors(&self) -> Vec<DeviceError> {
        let mut entries = self.handle.errors.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.drain(..).map(|(_, error)| error).collect()
    }

    /// The first error that this thread's calls caused since the last check; later ones follow from it.
    pub(crate) fn check(&self) -> Result<(), DeviceError> {
        let mut entries = self.handle.errors.entries.lock().unwrap_or_else(PoisonError::into_inner);
        let here = thread::current().id();
        let mut own = entries.extract_if(.., |(thread, _)| *thread == here);
        let first = own.next();
        own.for_each(drop);
        first.map_or(Ok(()), |(_, error)| Err(error))
    }

    /// Why a call returned null.
    pub(crate) fn failure(&self) -> DeviceError {
        let silent = || DeviceError { code: ErrorCode::UNKNOWN, text: "a null handle, and no reason given".into() };
        self.check().err().unwrap_or_else(silent)
    }

    /// The handle, alive as long as `self`. For this crate's ABI tests.
    #[doc(hidden)]
    pub fn raw(&self) -> raw::RTCDevice {
        self.handle.device
    }

    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.handle, &other.handle)
    }
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Device(Embree {})", self.version())
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: this is the last owner; scenes hold a clone of the device, so none is left that could report to the
        // log, and unsetting the callback before the release makes sure that the release itself does not either.
        unsafe {
            raw::rtcSetDeviceErrorFunction(self.device, None, std::ptr::null_mut());
            raw::rtcReleaseDevice(self.device);
        }
    }
}
