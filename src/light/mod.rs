//! Light sources: where photons start, what a surface receives.
//!
//! A light's emission is a map from four numbers (u, v; θ, φ) in [0, 1)⁴ to a position and a direction, with its
//! densities, its inverse and its Jacobian. The Jacobian is the initial photon differential.

mod aim;
mod area;
mod assemble;
mod bounds;
mod directional;
mod environment;
mod motion;
mod panorama;
mod point;
pub mod select;
mod spot;
mod tree;

pub use aim::Directions;
pub use area::AreaLight;
pub use assemble::{LightError, Lights};
pub use bounds::{LightBounds, NormalCone, Receiver};
pub use directional::DirectionalLight;
pub use environment::EnvironmentLight;
pub use panorama::PanoramaLight;
pub use point::PointLight;
pub use select::LightChoice;
pub use spot::SpotLight;
pub use tree::LightTree;

use crate::differential::{Column, Differential};
use crate::math::{Dir3, Normal3, Point3, Vec3, float};
use crate::radiometry::{Area, Flux, Pdf, Radiance, SolidAngle};

/// Where emitted light is wanted: the whole scene, or what can reach a sphere around the specular objects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Aim {
    Everywhere,
    Sphere { centre: Point3, radius: f64 },
}

/// A ray of light leaving a source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    pub origin: Point3,
    pub direction: Dir3,
    /// Normal of the emitting surface, `None` for sources without one.
    pub normal: Option<Normal3>,
    /// The source's flux estimate from this one sample, W: Le cos/(p_a p_w), I/p_w, E⊥/p_a. Divided by the number of
    /// photons it is the flux of a photon.
    pub flux: Flux,
    pub pdf_a: Option<Pdf<Area>>,
    pub pdf_w: Option<Pdf<SolidAngle>>,
    /// Jacobian of the emission map: columns ∂(x, ω)/∂(u, v, θ, φ) per unit of the sample square. Columns that the
    /// source does not have (positions of a point, directions of a beam) are zero.
    pub jacobian: Differential<4>,
    /// ∂(x, ω)/∂t per second over the same sample; zero for what stands still.
    pub motion: Column,
}

impl Emission {
    /// Where the ray starts so that it cannot find the surface it leaves.
    pub fn ray_origin(&self) -> Point3 {
        match self.normal {
            Some(n) => {
                let error = float::origin_offset(self.origin.abs().max_element());
                float::offset_ray_origin(self.origin, error, n, self.direction)
            }
            None => self.origin,
        }
    }
}

/// Light arriving at a point from a sampled direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// From the point towards the light.
    pub wi: Dir3,
    /// To the light's point; infinite for unbounded directional light and the environment.
    pub distance: f64,
    /// Arriving radiance divided by the density (for delta sources: the arriving irradiance on a plane ⟂ wi).
    pub weight: Radiance,
    /// Density of `wi` per solid angle, `None` for delta sources.
    pub pdf: Option<Pdf<SolidAngle>>,
}

/// A light source. World frame, metres.
pub trait Light: Send + Sync + std::fmt::Debug {
    /// All that the source sends; what unbounded light sends through the scene's bounding sphere.
    fn power(&self) -> Flux;

    /// The ray over the sample `u` = (u, v, θ, φ) that can reach the aim, with densities by area and by solid angle.
    /// `None` is a sample of zero flux: it counts as emitted.
    fn emit(&self, u: [f64; 4], aim: &Aim) -> Option<Emission>;

    /// How the ray over the sample `u` changes as the middle of the aim's sphere goes by `step`: of lights that draw their
    /// rays towards it. Zero for others.
    fn following(&self, _u: [f64; 4], _aim: &Aim, _step: Vec3) -> Column {
        Column::ZERO
    }

    /// The sample that [`Light::emit`] maps to this ray; zero for coordinates that the source does not use. `None`
    /// for rays that it never makes. Searches, in lights made of many triangles.
    fn emission_inverse(&self, origin: Point3, direction: Dir3, aim: &Aim) -> Option<[f64; 4]>;

    /// What all rays towards the aim carry: the mean of [`Emission::flux`] over the samples. Closed forms where there
    /// are; otherwise by quadrature, good enough to share photons among lights.
    fn emitted_flux(&self, aim: &Aim) -> Flux;

    /// A direction from `p` to the light; `None` where none arrives. Visibility is the caller's.
    fn sample_li(&self, p: Point3, u: [f64; 2]) -> Option<LightSample>;

    /// Density with which [`Light::sample_li`] at `p` finds the light's point `p_on_light`, whose outward geometric
    /// normal is `n_on_light`, in the direction `wi`. Zero for delta sources and for the environment.
    fn pdf_li(&self, p: Point3, wi: Dir3, p_on_light: Point3, n_on_light: Normal3) -> Pdf<SolidAngle>;

    /// Radiance that a surface point of the light with the outward geometric normal `n` sends along `w_out`.
    fn radiance(&self, _n: Normal3, _w_out: Dir3) -> Radiance {
        Radiance::ZERO
    }

    /// Radiance that arrives along −`wi` from infinitely far away.
    fn environment_radiance(&self, _wi: Dir3) -> Radiance {
        Radiance::ZERO
    }

    /// Density with which [`Light::sample_li`] finds the direction `wi` into the environment.
    fn environment_pdf(&self, _wi: Dir3) -> Pdf<SolidAngle> {
        Pdf::ZERO
    }

    /// Where it is and whither it sends; `None` for light from infinitely far away.
    fn bounds(&self) -> Option<LightBounds> {
        None
    }

    /// How much longer a step in the first coordinate of the leading pair (positions if collimated, else directions) is
    /// than one in the second: width over height of what that unit square is mapped to.
    fn emission_aspect(&self, _aim: &Aim) -> f64 {
        1.0
    }

    /// Whether all its rays are parallel, or nearly so: where they start says where they land.
    fn is_collimated(&self) -> bool {
        false
    }

    /// Whether rays never meet this source by chance.
    fn is_delta(&self) -> bool {
        false
    }
}

/// The Jacobian of a source without extent.
fn direction_columns([dw_dtheta, dw_dphi]: [Vec3; 2]) -> Differential<4> {
    Differential::new([Column::ZERO, Column::ZERO, Column::direction(dw_dtheta), Column::direction(dw_dphi)])
}

/// A sphere around all that can be lit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneSphere {
    pub centre: Point3,
    pub radius: f64,
}

impl SceneSphere {
    /// The sphere that an aim means to light that comes from outside.
    fn aimed(&self, aim: &Aim) -> SceneSphere {
        match *aim {
            Aim::Everywhere => *self,
            Aim::Sphere { centre, radius } => SceneSphere { centre, radius },
        }
    }

    /// How far upstream along `direction` from the plane through `x` ⟂ `direction` everything in the scene lies
    /// downstream; the hundredth more keeps starting points off the surfaces that bound the scene.
    fn upstream(&self, x: Point3, direction: Dir3) -> f64 {
        direction.dot(x - self.centre) + 1.01 * self.radius
    }
}
