//! Errors: what Embree reports (a number and a text), what a scene refuses, what makes a ray untraceable.

use std::error::Error;
use std::fmt;

use crate::raw;

/// An Embree error code. A number and not an enum, since a newer library may return codes unknown today.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ErrorCode(pub u32);

impl ErrorCode {
    /// No error.
    pub const NONE: Self = Self(raw::RTC_ERROR_NONE);
    /// An unknown error, for example a null handle.
    pub const UNKNOWN: Self = Self(raw::RTC_ERROR_UNKNOWN);
    /// An argument out of its range.
    pub const INVALID_ARGUMENT: Self = Self(raw::RTC_ERROR_INVALID_ARGUMENT);
    /// A call at a wrong time, such as tracing before the commit.
    pub const INVALID_OPERATION: Self = Self(raw::RTC_ERROR_INVALID_OPERATION);
    /// Not enough memory for the scene.
    pub const OUT_OF_MEMORY: Self = Self(raw::RTC_ERROR_OUT_OF_MEMORY);
    /// The processor lacks SSE2.
    pub const UNSUPPORTED_CPU: Self = Self(raw::RTC_ERROR_UNSUPPORTED_CPU);
    /// The build was cancelled.
    pub const CANCELLED: Self = Self(raw::RTC_ERROR_CANCELLED);

    fn name(self) -> Option<&'static str> {
        Some(match self {
            Self::NONE => "no error",
            Self::UNKNOWN => "unknown error",
            Self::INVALID_ARGUMENT => "invalid argument",
            Self::INVALID_OPERATION => "invalid operation",
            Self::OUT_OF_MEMORY => "out of memory",
            Self::UNSUPPORTED_CPU => "unsupported CPU",
            Self::CANCELLED => "cancelled",
            _ => return None,
        })
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.name() {
            Some(name) => write!(f, "{name} (code {})", self.0),
            None => write!(f, "code {}", self.0),
        }
    }
}

/// What Embree's error callback carried.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceError {
    /// Embree's number.
    pub code: ErrorCode,
    /// Embree's text; may be empty.
    pub text: String,
}

impl fmt::Display for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Embree reports {}", self.code)?;
        if self.text.is_empty() { Ok(()) } else { write!(f, ": {}", self.text) }
    }
}

impl Error for DeviceError {}

/// Why a geometry or a scene was refused. Geometry ids are the caller's.
#[derive(Clone, Debug, PartialEq)]
pub enum SceneError {
    /// Embree itself failed.
    Device(DeviceError),
    /// The id is already taken in this scene.
    DuplicateId {
        /// The id given twice.
        geometry: u32,
    },
    /// Embree's tables are as long as the largest id.
    IdTooLarge {
        /// The id above [`MAX_GEOMETRY_ID`](crate::MAX_GEOMETRY_ID).
        geometry: u32,
    },
    /// No triangle, no vertex or no user primitive.
    Empty {
        /// The geometry.
        geometry: u32,
    },
    /// More primitives or vertices than a u32 can count.
    TooLarge {
        /// The geometry.
        geometry: u32,
    },
    /// A vertex that is NaN, infinite or beyond [`MAX_COORDINATE`](crate::MAX_COORDINATE).
    BadVertex {
        /// The mesh.
        geometry: u32,
        /// Index of the vertex.
        vertex: usize,
        /// Its position.
        position: [f32; 3],
    },
    /// A triangle that names a vertex which is not there.
    BadIndex {
        /// The mesh.
        geometry: u32,
        /// Index of the triangle.
        triangle: usize,
        /// The vertex it names.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// Frames of a moving mesh that are fewer than 2 or more than [`MAX_TIME_STEPS`](crate::MAX_TIME_STEPS), of different
    /// numbers of vertices, or at times that are not finite and increasing.
    BadFrames {
        /// The mesh.
        geometry: u32,
    },
    /// Bounds of a user primitive that are NaN, infinite, too large or inside out.
    BadBounds {
        /// The user geometry.
        geometry: u32,
        /// Its primitive.
        primitive: u32,
        /// Lower and upper corner.
        bounds: ([f32; 3], [f32; 3]),
    },
    /// A transform that is not finite, cannot be inverted, or shrinks or enlarges beyond f32.
    BadTransform {
        /// The instance.
        geometry: u32,
    },
    /// The scene of an instance belongs to another device.
    OtherDevice {
        /// The instance.
        geometry: u32,
    },
    /// The scene of an instance holds instances itself: there is one instance level.
    NestedInstance {
        /// The instance.
        geometry: u32,
    },
    /// The scene of an instance holds user geometries: they see the untransformed ray, so only the top level has them.
    InstancedUserGeometry {
        /// The instance.
        geometry: u32,
    },
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Device(error) => write!(f, "{error}"),
            Self::DuplicateId { geometry } => {
                write!(f, "geometry {geometry}: the id is already taken")
            }
            Self::IdTooLarge { geometry } => {
                write!(f, "geometry {geometry}: the id is above {}", crate::MAX_GEOMETRY_ID)
            }
            Self::Empty { geometry } => write!(f, "geometry {geometry}: has no primitives"),
            Self::TooLarge { geometry } => write!(f, "geometry {geometry}: more than 2^32 - 1 primitives or vertices"),
            Self::BadVertex { geometry, vertex, position } => write!(
                f,
                "geometry {geometry}: vertex {vertex} is {position:?}, but must be finite and at most {:e} from 0",
                crate::MAX_COORDINATE
            ),
            Self::BadIndex { geometry, triangle, index, vertices } => write!(
                f,
                "geometry {geometry}: triangle {triangle} names vertex {index}, but there are {vertices} vertices"
            ),
            Self::BadFrames { geometry } => write!(
                f,
                "geometry {geometry}: frames must be 2 to {} of equally many vertices, from a time to a later one",
                crate::MAX_TIME_STEPS
            ),
            Self::BadBounds { geometry, primitive, bounds: (lower, upper) } => write!(
                f,
                "geometry {geometry}: primitive {primitive} has the bounds {lower:?} to {upper:?}, which must be \
                 finite, ordered and at most {:e} from 0",
                crate::MAX_COORDINATE
            ),
            Self::BadTransform { geometry } => {
                write!(f, "geometry {geometry}: the transform must be finite and invertible within f32")
            }
            Self::OtherDevice { geometry } => write!(f, "geometry {geometry}: its scene belongs to another device"),
            Self::NestedInstance { geometry } => {
                write!(f, "geometry {geometry}: an instance inside an instance")
            }
            Self::InstancedUserGeometry { geometry } => {
                write!(f, "geometry {geometry}: a user geometry inside an instance")
            }
        }
    }
}

impl Error for SceneError {}

impl From<DeviceError> for SceneError {
    fn from(error: DeviceError) -> Self {
        Self::Device(error)
    }
}

/// Why a ray was not traced. Debian 12's Embree would end the process on most of these.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum InvalidRay {
    /// The origin is NaN, infinite or beyond [`MAX_COORDINATE`](crate::MAX_COORDINATE).
    Origin,
    /// The direction is NaN, infinite or beyond [`MAX_DIRECTION`](crate::MAX_DIRECTION).
    Direction,
    /// The direction is zero, or shorter than [`MIN_DIRECTION`](crate::MIN_DIRECTION).
    ShortDirection,
    /// `t_near` is negative, NaN or beyond f32.
    TNear,
    /// `t_far` is NaN.
    TFar,
}

impl fmt::Display for InvalidRay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Origin => "the ray's origin is not finite or too far away",
            Self::Direction => "the ray's direction is not finite or too long",
            Self::ShortDirection => "the ray's direction is zero or too short",
            Self::TNear => "the ray's t_near is negative, not finite or too large",
            Self::TFar => "the ray's t_far is NaN",
        })
    }
}

impl Error for InvalidRay {}
