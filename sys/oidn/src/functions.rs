//! The library's functions, as the headers of versions 1.4 and 2.x declare them alike but for one name.

use std::ffi::{c_char, c_int, c_void};
use std::ptr::NonNull;

use libloading::Library as SharedObject;

/// A device or a filter of the library.
pub type Handle = NonNull<c_void>;

/// `OIDN_FORMAT_FLOAT3`.
pub const FLOAT3: c_int = 3;

type SetSharedImage =
    unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);

/// Pointers into the library, valid as long as it is loaded.
#[derive(Debug)]
pub struct Functions {
    pub new_device: unsafe extern "C" fn(c_int) -> *mut c_void,
    pub commit_device: unsafe extern "C" fn(Handle),
    pub release_device: unsafe extern "C" fn(Handle),
    pub device_error: unsafe extern "C" fn(*mut c_void, *mut *const c_char) -> c_int,
    pub new_filter: unsafe extern "C" fn(Handle, *const c_char) -> *mut c_void,
    pub set_shared_image: SetSharedImage,
    pub set_flag: unsafe extern "C" fn(Handle, *const c_char, bool),
    pub commit_filter: unsafe extern "C" fn(Handle),
    pub execute_filter: unsafe extern "C" fn(Handle),
    pub release_filter: unsafe extern "C" fn(Handle),
}

/// The first of these functions that the library has.
macro_rules! function {
    ($object:expr, $($name:literal),+) => {
        // SAFETY: the type is that of the field which takes the pointer, written from the headers of Open Image Denoise:
        // enumerations are C's `int`, sizes `size_t`. Both names of a function that was renamed have the same type.
        [$(unsafe { $object.get($name) }),+]
            .into_iter()
            .find_map(Result::ok)
            .map(|symbol| *symbol)
            .ok_or_else(|| format!("it has no {}", [$(stringify!($name)),+].join(" or ")))?
    };
}

impl Functions {
    /// # Errors
    /// The name of a function that the library does not have.
    pub fn of(object: &SharedObject) -> Result<Functions, String> {
        Ok(Functions {
            new_device: function!(object, b"oidnNewDevice\0"),
            commit_device: function!(object, b"oidnCommitDevice\0"),
            release_device: function!(object, b"oidnReleaseDevice\0"),
            device_error: function!(object, b"oidnGetDeviceError\0"),
            new_filter: function!(object, b"oidnNewFilter\0"),
            set_shared_image: function!(object, b"oidnSetSharedFilterImage\0"),
            // Renamed in version 2.
            set_flag: function!(object, b"oidnSetFilterBool\0", b"oidnSetFilter1b\0"),
            commit_filter: function!(object, b"oidnCommitFilter\0"),
            execute_filter: function!(object, b"oidnExecuteFilter\0"),
            release_filter: function!(object, b"oidnReleaseFilter\0"),
        })
    }
}
