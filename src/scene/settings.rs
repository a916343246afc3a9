//! How a scene is rendered; every choice has a name that the scene file and the command line share.

use super::light_group::GroupLayer;

/// Defines an enum whose variants have one spelling each.
macro_rules! named_choice {
    ($(#[$doc:meta])* $name:ident { $($(#[$vdoc:meta])* $variant:ident = $text:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $($(#[$vdoc])* $variant),+ }

        impl $name {
            pub const NAMES: &'static [&'static str] = &[$($text),+];
            pub const fn name(self) -> &'static str {
                match self { $($name::$variant => $text),+ }
            }
            pub fn from_name(text: &str) -> Option<Self> {
                match text { $($text => Some($name::$variant),)+ _ => None }
            }
        }
    };
}

named_choice!(
    /// What renders the picture.
    Method {
        /// Path tracing, with caustics from the photon map.
        PhotonMap = "photon_map",
        /// Unbiased path tracing with next-event estimation and multiple importance sampling.
        Path = "path",
        /// Unbiased light tracing splatted to the camera.
        LightTrace = "light",
    }
);

named_choice!(
    /// How the sample square of a light is filled.
    EmissionPattern {
        Random = "random",
        Jittered = "jittered",
        /// Rank-1 lattice of golden ratios, shifted at random in each pass.
        Lattice = "lattice",
    }
);

named_choice!(
    /// Whether pilot photons learn where a light's photons are worth sending.
    Guiding {
        On = "on",
        /// Evenly to everything around the specular objects.
        Off = "off",
    }
);

named_choice!(
    /// What finds the light that mirrors and glass focus.
    Caustics {
        /// Photons; and eye paths to their part, where a lamp is so wide that these run into it often.
        Shared = "shared",
        /// Photons alone.
        Photons = "photons",
    }
);

named_choice!(
    /// What finds the light between surfaces that scatter.
    Indirect {
        /// Eye paths that bounce on.
        Path = "path",
        /// Photons, as the eye sees them: the global map.
        Global = "global",
        /// Eye paths to the first surface beyond, photons from there on.
        FinalGather = "final_gather",
    }
);

named_choice!(
    /// What a photon stands for after a surface has scattered it; n photons of its kind are sent, p is the density of its
    /// new direction (PHOTON_DIFFERENTIALS 6).
    BounceFootprint {
        /// The patch that it lit and a cell of 1/(n p): all photons share the directions out.
        Shared = "shared",
        /// The patch, and a cell that covers the photon's share of all surfaces where it lands.
        Coverage = "coverage",
        /// The patch and a cell of 1/(√n p).
        Root = "root",
        /// n is shared out evenly between all choices of the path so far, whose cells grow with each bounce: path
        /// differentials `[Suykens01]`.
        Path = "path",
        /// No patch any more, and a cell of 1/(n p).
        Reset = "reset",
    }
);

named_choice!(
    /// How the light at a point is estimated from photons.
    Estimator {
        /// Photon differentials: every photon's own footprint.
        Differentials = "pd",
        /// k nearest photons in a disc.
        NearestNeighbours = "knn",
        /// Stochastic progressive photon mapping: a disc of the same radius everywhere, smaller in each pass.
        Progressive = "sppm",
    }
);

named_choice!(
    /// How light that photons bring into a medium is estimated: what of the eye asks what of the photons `[Jarosz11]`.
    MediaEstimator {
        /// Rays cross beams: a blur in one dimension.
        RayBeams = "ray_beams",
        /// Rays pass points, where photons meet the medium: in two.
        RayPoints = "ray_points",
        /// Places, where an eye's path meets the medium, lie in beams: in two.
        PlaceBeams = "place_beams",
        /// Places lie about points: in three.
        PlacePoints = "place_points",
    }
);

impl MediaEstimator {
    /// Whether the eye's rays ask, and not places on them.
    pub fn asks_along_rays(self) -> bool {
        matches!(self, MediaEstimator::RayBeams | MediaEstimator::RayPoints)
    }

    /// Whether beams are asked, and not points on them.
    pub fn asks_beams(self) -> bool {
        matches!(self, MediaEstimator::RayBeams | MediaEstimator::PlaceBeams)
    }
}

named_choice!(
    /// The ellipse that a photon's columns span.
    FootprintRule {
        /// Σ of the columns' squares, PHOTON_DIFFERENTIALS 2.4.
        Quadratic = "quadratic",
        /// The largest ellipse in the parallelogram of the columns' sums `[Frisvad-slides]`.
        Parallelogram = "parallelogram",
    }
);

named_choice!(
    /// Shape of the kernel over a footprint's unit disc.
    KernelShape {
        Uniform = "uniform",
        Cone = "cone",
        Epanechnikov = "epanechnikov",
        /// Also known as Silverman's second-order kernel.
        Biweight = "biweight",
        Triweight = "triweight",
        Gaussian = "gaussian",
    }
);

named_choice!(
    /// Which library finds the hits.
    BackendKind {
        Embree = "embree",
        Obvhs = "obvhs",
        Brute = "brute",
    }
);

named_choice!(
    /// A layer that an EXR may hold beside the beauty; `film` says what each one means.
    Layer {
        Caustic = "caustic",
        Direct = "direct",
        Indirect = "indirect",
        Emission = "emission",
        Straight = "straight",
        Focused = "focused",
        SentBack = "sent_back",
        Scattered = "scattered",
        Normal = "N",
        Depth = "Z",
        Position = "P",
        Albedo = "albedo",
        Photons = "photons",
        Variance = "variance",
        CryptoObject = "crypto_object",
        CryptoMaterial = "crypto_material",
    }
);

/// Photons that one pass may emit. More would be better spent in several passes, which take no more memory than one.
pub const MAX_PHOTONS_PER_PASS: u64 = 1_000_000_000;

/// How wide a footprint is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bandwidth {
    /// A scale that suits the emission pattern.
    Auto,
    /// Footprints `s` times the photon's own share of the light.
    Scale(f64),
}

/// Into how many equal parts of the shutter's interval photons share it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeResolution {
    /// As many as the photons of a pass serve best.
    Auto,
    /// 1: all blur comes from the photons' time columns.
    Cells(u32),
}

named_choice!(
    /// How a photon's light is spread over what it sweeps in its time cell.
    TimeKernel {
        /// The footprint is widened to the variance of the sweep.
        Variance = "variance",
        /// The footprint is swept along, as first published, over the area that keeps its energy; for comparison.
        Swept = "swept",
    }
);

/// The disc of the first pass of `sppm`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Radius {
    /// A small part of the scene's size.
    Auto,
    Metres(f64),
}

/// Everything but the scene's content that a picture depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    pub method: Method,
    pub backend: BackendKind,
    pub seed: u64,
    pub passes: u32,
    /// Eye samples in a pixel, in each pass.
    pub spp: u32,
    /// Photons emitted from all lights, in each pass.
    pub photons: u64,
    /// Those that become beams in media that scatter, in each pass.
    pub beams: u64,
    pub media_estimator: MediaEstimator,
    /// Points on each beam, for the estimates that ask points.
    pub beam_points: u32,
    pub emission: EmissionPattern,
    pub guiding: Guiding,
    pub estimator: Estimator,
    pub footprint: FootprintRule,
    pub caustics: Caustics,
    pub indirect: Indirect,
    pub bounce_footprint: BounceFootprint,
    pub kernel: KernelShape,
    pub bandwidth: Bandwidth,
    /// Neighbours of the `knn` estimate.
    pub k: u32,
    /// The disc of the first pass of the `sppm` estimate.
    pub radius: Radius,
    /// What of the shutter's interval a photon stands for, where something moves.
    pub time_cells: TimeResolution,
    pub time_kernel: TimeKernel,
    /// Edges of a path at most, counted from the light or the camera.
    pub max_depth: u32,
    /// Diffuse bounces between a light and the surface that the eye sees, 0: direct light and caustics only.
    pub max_bounces: u32,
    /// Layers of the EXR beside the beauty, in the order they were asked for, without repetition.
    pub layers: Vec<Layer>,
    /// The shares of groups of lights in some of them, likewise.
    pub group_layers: Vec<GroupLayer>,
}

impl Default for RenderSettings {
    fn default() -> Self {
        RenderSettings {
            method: Method::PhotonMap,
            backend: if cfg!(feature = "embree") { BackendKind::Embree } else { BackendKind::Obvhs },
            seed: 0,
            passes: 1,
            spp: 16,
            photons: 200_000,
            beams: 10_000,
            media_estimator: MediaEstimator::RayBeams,
            beam_points: 16,
            emission: EmissionPattern::Lattice,
            guiding: Guiding::On,
            estimator: Estimator::Differentials,
            footprint: FootprintRule::Quadratic,
            caustics: Caustics::Shared,
            indirect: Indirect::Path,
            bounce_footprint: BounceFootprint::Shared,
            // Smooth to the second derivative at its edge: at equal smoothing a lattice leaves a third of the ripple that
            // it leaves under Epanechnikov's kernel, which is only best for random photons.
            kernel: KernelShape::Triweight,
            bandwidth: Bandwidth::Auto,
            k: 70,
            radius: Radius::Auto,
            time_cells: TimeResolution::Auto,
            time_kernel: TimeKernel::Variance,
            max_depth: 32,
            max_bounces: 4,
            layers: Vec::new(),
            group_layers: Vec::new(),
        }
    }
}
