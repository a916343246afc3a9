//! Intel Open Image Denoise, 1.4 or 2.x, through its C interface `[OIDN-docs]`, found when the program runs: nothing is linked.
//!
//! What · units: pictures are three `f32` a pixel, row by row, linear light without an upper bound; albedo in [0, 1]; normals
//! of length up to 1. The result has the layout of the colour. One call makes a device of the processor, a filter and releases
//! both: no handle of the library leaves this crate.
//!
//! ```no_run
//! let library = oidn_at_run_time::Library::find()?;
//! let colour = vec![0.5f32; 3 * 64 * 48];
//! let picture = oidn_at_run_time::Picture { width: 64, height: 48, colour: &colour, albedo: None, normal: None };
//! let smooth = library.denoise(&picture)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![deny(unsafe_op_in_unsafe_fn, clippy::undocumented_unsafe_blocks, missing_docs)]

mod functions;

use std::ffi::{CStr, CString, OsStr};
use std::path::Path;
use std::ptr::NonNull;

use functions::{FLOAT3, Functions, Handle};
use libloading::Library as SharedObject;

/// Where a library of another place may be named.
pub const VARIABLE: &str = "PDEMBREE_OIDN";

/// What the loader knows it by, newest first.
const NAMES: [&str; 6] = [
    "libOpenImageDenoise.so.2",
    "libOpenImageDenoise.so.1",
    "libOpenImageDenoise.so.0",
    "libOpenImageDenoise.so",
    "libOpenImageDenoise.dylib",
    "OpenImageDenoise.dll",
];

/// Why there is no denoised picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system's loader knows no such library.
    #[error("Open Image Denoise is not installed, nor does {VARIABLE} name its library")]
    Absent,
    /// The file that [`VARIABLE`] names is no such library.
    #[error("{path}: {reason}")]
    Unusable {
        /// As it was given.
        path: String,
        /// The loader's words.
        reason: String,
    },
    /// A picture whose parts have other sizes than it says.
    #[error("{what} has {found} numbers, {wanted} are needed")]
    Size {
        /// Which part.
        what: &'static str,
        /// How many it has.
        found: usize,
        /// How many its sides ask for.
        wanted: usize,
    },
    /// The library's own message.
    #[error("Open Image Denoise: {0}")]
    Failed(String),
}

/// A picture to be denoised, and what helps: three numbers a pixel each.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Radiance.
    pub colour: &'a [f32],
    /// Reflectance of what is seen.
    pub albedo: Option<&'a [f32]>,
    /// Its normals; taken only together with an albedo.
    pub normal: Option<&'a [f32]>,
}

impl Picture<'_> {
    fn check(&self) -> Result<(), Error> {
        let wanted = self.width.saturating_mul(self.height).saturating_mul(3);
        let parts = [("the picture", Some(self.colour)), ("its albedo", self.albedo), ("its normals", self.normal)];
        let wrong = |(what, part): (&'static str, Option<&[f32]>)| match part {
            Some(part) if part.len() != wanted => Some(Error::Size { what, found: part.len(), wanted }),
            _ => None,
        };
        parts.into_iter().find_map(wrong).map_or(Ok(()), Err)
    }
}

/// The loaded library.
#[derive(Debug)]
pub struct Library {
    functions: Functions,
    /// Keeps the functions where they are.
    _object: SharedObject,
}

impl Library {
    /// The one that [`VARIABLE`] names, or that the system has.
    pub fn find() -> Result<Library, Error> {
        if let Some(path) = std::env::var_os(VARIABLE) {
            return Library::open(Path::new(&path));
        }
        let found = NAMES.iter().find_map(|name| Some((name, load(OsStr::new(name)).ok()?)));
        let (name, object) = found.ok_or(Error::Absent)?;
        Library::of(object).map_err(|reason| Error::Unusable { path: (*name).to_owned(), reason })
    }

    /// The library in the file `path`.
    pub fn open(path: &Path) -> Result<Library, Error> {
        let unusable = |reason: String| Error::Unusable { path: path.display().to_string(), reason };
        let object = load(path.as_os_str()).map_err(|error| unusable(error.to_string()))?;
        Library::of(object).map_err(unusable)
    }

    fn of(object: SharedObject) -> Result<Library, String> {
        let functions = Functions::of(&object)?;
        Ok(Library { functions, _object: object })
    }

    /// The picture without its noise.
    ///
    /// # Errors
    /// The parts do not fit, or what the library reports.
    pub fn denoise(&self, picture: &Picture<'_>) -> Result<Vec<f32>, Error> {
        picture.check()?;
        let mut output = vec![0.0f32; picture.colour.len()];
        if output.is_empty() {
            return Ok(output);
        }
        let device = Device::new(&self.functions)?;
        let filter = Filter::new(&device)?;
        filter.read("color", picture, picture.colour);
        if let Some(albedo) = picture.albedo {
            filter.read("albedo", picture, albedo);
            // The filter knows normals only beside an albedo.
            picture.normal.inspect(|normal| filter.read("normal", picture, normal));
        }
        filter.write("output", picture, &mut output);
        filter.run();
        drop(filter);
        device.check()?;
        Ok(output)
    }
}

fn load(name: &OsStr) -> Result<SharedObject, libloading::Error> {
    // SAFETY: loading runs the initialisers of the file, which the user names as Open Image Denoise or has installed under
    // its name; those of the library set up tables and have no requirements.
    unsafe { SharedObject::new(name) }
}

/// A device of the library, released when dropped.
struct Device<'f> {
    functions: &'f Functions,
    handle: Handle,
}

/// A NUL-terminated name.
fn text(name: &'static str) -> CString {
    CString::new(name).unwrap_or_default()
}

impl<'f> Device<'f> {
    fn new(functions: &'f Functions) -> Result<Device<'f>, Error> {
        /// `OIDN_DEVICE_TYPE_CPU`, which sees all of this process's memory.
        const CPU: i32 = 1;
        // SAFETY: the function takes a number of its enumeration, and returns a device or null.
        let handle = NonNull::new(unsafe { (functions.new_device)(CPU) });
        let Some(handle) = handle else { return Err(failed(functions, None)) };
        let device = Device { functions, handle };
        // SAFETY: a device of the same library that was not released.
        unsafe { (functions.commit_device)(handle) };
        device.check()?;
        Ok(device)
    }

    /// What went wrong since the last time, if anything did.
    fn check(&self) -> Result<(), Error> {
        message(self.functions, Some(self.handle)).map_or(Ok(()), |told| Err(Error::Failed(told)))
    }
}

impl Drop for Device<'_> {
    fn drop(&mut self) {
        // SAFETY: the device was made by `new_device` and is released once; filters borrow it, so they are gone.
        unsafe { (self.functions.release_device)(self.handle) }
    }
}

fn failed(functions: &Functions, device: Option<Handle>) -> Error {
    Error::Failed(message(functions, device).unwrap_or_else(|| "no reason given".to_owned()))
}

/// The first error of a device, or of this thread without one, in the library's words.
fn message(functions: &Functions, device: Option<Handle>) -> Option<String> {
    let mut told = std::ptr::null();
    // SAFETY: a device that was not released, or null, which the function takes for this thread's errors; it writes one
    // pointer to `told`, which is one.
    let code = unsafe { (functions.device_error)(device.map_or(std::ptr::null_mut(), NonNull::as_ptr), &mut told) };
    if code == 0 {
        return None;
    }
    if told.is_null() {
        return Some(format!("error {code}"));
    }
    // SAFETY: with an error the function gives a NUL-terminated text that lives until the next call for the same device;
    // it is copied before that.
    Some(unsafe { CStr::from_ptr(told) }.to_string_lossy().into_owned())
}

/// A filter of a device, released when dropped.
struct Filter<'d> {
    device: &'d Device<'d>,
    handle: Handle,
}

impl<'d> Filter<'d> {
    fn new(device: &'d Device<'d>) -> Result<Filter<'d>, Error> {
        let functions = device.functions;
        let kind = text("RT");
        // SAFETY: a device that was not released and a NUL-terminated text; returns a filter or null.
        let handle = NonNull::new(unsafe { (functions.new_filter)(device.handle, kind.as_ptr()) });
        let Some(handle) = handle else { return Err(failed(functions, Some(device.handle))) };
        Ok(Filter { device, handle })
    }

    /// Lets the filter read `pixels`, which [`Picture::check`] found to have the picture's size.
    fn read(&self, name: &'static str, picture: &Picture<'_>, pixels: &[f32]) {
        // The library takes every image as writable, and writes to that named "output" alone.
        self.image(name, picture, pixels.as_ptr().cast_mut());
    }

    fn write(&self, name: &'static str, picture: &Picture<'_>, pixels: &mut [f32]) {
        self.image(name, picture, pixels.as_mut_ptr());
    }

    fn image(&self, name: &'static str, picture: &Picture<'_>, pixels: *mut f32) {
        let name = text(name);
        // SAFETY: a filter that was not released, a NUL-terminated text, and memory of width · height pixels of three
        // floats without gaps (strides 0). It is used by `run` alone, within the call of `denoise` that holds the slices.
        unsafe {
            let set = self.device.functions.set_shared_image;
            set(self.handle, name.as_ptr(), pixels.cast(), FLOAT3, picture.width, picture.height, 0, 0, 0);
        }
    }

    fn run(&self) {
        let (functions, hdr) = (self.device.functions, text("hdr"));
        // SAFETY: a filter that was not released, whose images are alive; it runs to its end before it returns. C's `bool`
        // is Rust's.
        unsafe {
            (functions.set_flag)(self.handle, hdr.as_ptr(), true);
            (functions.commit_filter)(self.handle);
            (functions.execute_filter)(self.handle);
        }
    }
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: made by `new_filter`, released once.
        unsafe { (self.device.functions.release_filter)(self.handle) }
    }
}
