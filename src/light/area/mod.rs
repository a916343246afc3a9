//! The diffuse area light on a shape or a mesh · W/(m²·sr).
//!
//! Positions are drawn by area. Directions are cosine-weighted about the normal, or, towards an aim that is seen under
//! less than a hemisphere's worth, uniform in the cone around it. Both maps tie the direction to the point (its normal,
//! the cone's axis and width), and the Jacobian says so: ∂ω/∂u and ∂ω/∂v are what they are, not zero. Holding the world
//! direction fixed would be a valid cell of the same density, but no derivative of this map, so no test could tell it
//! from a mistake.

mod mesh;
mod shape;

use std::f64::consts::{FRAC_PI_2, PI};

use self::mesh::MeshSurface;
use self::shape::ShapeSurface;
use super::aim::{self, Cone, Directions, SphereCone};
use super::{Aim, Emission, Light, LightBounds, LightSample};
use crate::differential::{Column, Differential};
use crate::math::{Dir3, Frame, Normal3, Point3, Transform, Vec3};
use crate::radiometry::{Area, Flux, Pdf, Radiance, SolidAngle};
use crate::sampling::warp::{CosineHemisphere, Warp};
use crate::scene::TriangleMesh;
use crate::shape::Shape;

/// Cosine of the half angle from which a cone is wider than π sr, the effective width of the cosine-weighted
/// hemisphere: then the hemisphere wastes fewer samples.
const WIDEST_CONE: f64 = 0.5;

/// Steps in each coordinate of the quadrature of the flux towards an aim.
const FLUX_STEPS: usize = 64;

/// A point drawn on an emitting surface, world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SurfacePoint {
    p: Point3,
    /// Outward, geometric.
    n: Normal3,
    dpdu: Vec3,
    dpdv: Vec3,
    dndu: Vec3,
    dndv: Vec3,
}

impl SurfacePoint {
    /// Area per unit of the sample square, m².
    fn inverse_pdf(&self) -> f64 {
        self.dpdu.cross(self.dpdv).length()
    }
}

/// Mean of f over the unit square by the midpoint rule.
fn mean_over_square(steps: usize, f: impl Fn([f64; 2]) -> f64) -> f64 {
    let tick = |i: usize| (i as f64 + 0.5) / steps as f64;
    let sum: f64 = (0..steps * steps).map(|k| f([tick(k % steps), tick(k / steps)])).sum();
    sum / (steps * steps) as f64
}

#[derive(Clone, Debug, PartialEq)]
enum Surface {
    Mesh(MeshSurface),
    Shape(ShapeSurface),
}

impl Surface {
    fn area(&self) -> f64 {
        match self {
            Surface::Mesh(m) => m.area(),
            Surface::Shape(s) => s.area(),
        }
    }
    fn sample(&self, u: [f64; 2]) -> Option<SurfacePoint> {
        match self {
            Surface::Mesh(m) => m.sample(u),
            Surface::Shape(s) => s.sample(u),
        }
    }
    fn pdf_at(&self, n: Normal3) -> Pdf<Area> {
        Pdf::new(match self {
            Surface::Mesh(m) => 1.0 / m.area(),
            Surface::Shape(s) => s.pdf_at(n),
        })
    }
    fn inverse(&self, p: Point3) -> Option<[f64; 2]> {
        match self {
            Surface::Mesh(m) => m.inverse(p),
            Surface::Shape(s) => s.inverse(p),
        }
    }
}

/// A diffuse emitter, the same radiance from every point in every direction of one side or of both.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaLight {
    surface: Surface,
    /// World centre and radius of a light that is a sphere; seen from outside it is sampled by its cone.
    sphere: Option<(Point3, f64)>,
    radiance: Radiance,
    two_sided: bool,
}

/// A direction leaving a surface point.
struct Leaving {
    w: Dir3,
    pdf: Pdf<SolidAngle>,
    /// ∂ω by u, v, θ, φ.
    dw: [Vec3; 4],
}

impl AreaLight {
    /// `None` for a mesh without area.
    pub fn from_mesh(mesh: &TriangleMesh, to_world: &Transform, radiance: Radiance, two_sided: bool) -> Option<Self> {
        let surface = Surface::Mesh(MeshSurface::new(mesh, to_world)?);
        Some(AreaLight { surface, sphere: None, radiance, two_sided })
    }

    /// `None` for a shape that cannot be sampled by area (the height field).
    pub fn from_shape(shape: &Shape, to_world: &Transform, radiance: Radiance, two_sided: bool) -> Option<Self> {
        let shape = ShapeSurface::new(shape, to_world)?;
        let sphere = shape.sphere();
        Some(AreaLight { surface: Surface::Shape(shape), sphere, radiance, two_sided })
    }

    /// World area, m².
    pub fn area(&self) -> f64 {
        self.surface.area()
    }

    fn sides(&self) -> f64 {
        if self.two_sided { 2.0 } else { 1.0 }
    }

    /// The cone to draw directions from, `None` for the hemisphere(s).
    fn cone(p: Point3, aim: &Aim) -> Option<SphereCone> {
        let Aim::Sphere { centre, radius } = *aim else { return None };
        SphereCone::new(p, centre, radius).filter(|c| c.cos_half_angle() > WIDEST_CONE)
    }

    fn leave(&self, at: &SurfacePoint, u: [f64; 2], aim: &Aim) -> Option<Leaving> {
        if let Some(towards) = AreaLight::cone(at.p, aim) {
            let Cone { frame, warp } = towards.cone;
            let (local, columns) = warp.sample_with_jacobian(u);
            let [dtheta, dphi] = columns.map(|d| frame.to_world(d));
            let dw = [towards.turning(local, at.dpdu), towards.turning(local, at.dpdv), dtheta, dphi];
            return Some(Leaving { w: frame.to_world_dir(local.to_vec()), pdf: towards.cone.pdf(), dw });
        }
        // A two-sided light splits θ in halves, one for each side.
        let upper = !self.two_sided || u[0] < 0.5;
        let folded = [if self.two_sided { (2.0 * u[0]).fract() } else { u[0] }, u[1]];
        let side = Vec3::new(1.0, 1.0, if upper { 1.0 } else { -1.0 });
        let frame = Frame::from_unit(at.n);
        let (local, columns) = CosineHemisphere.sample_with_jacobian(folded);
        let axes_along = |dn: Vec3| {
            let axes = Frame::from_unit_derivative(at.n, dn);
            let local = local.to_vec() * side;
            axes[0] * local.x + axes[1] * local.y + axes[2] * local.z
        };
        let [dtheta, dphi] = columns.map(|d| frame.to_world(d * side));
        let w = frame.to_world_dir(local.to_vec() * side);
        // Not every direction of the hemisphere reaches a wide aim.
        Directions::towards(at.p, aim).contains(w).then(|| Leaving {
            w,
            pdf: Pdf::new(CosineHemisphere.pdf(local).get() / self.sides()),
            dw: [axes_along(at.dndu), axes_along(at.dndv), dtheta * self.sides(), dphi],
        })
    }

    /// The (θ, φ) of a direction.
    fn leave_inverse(&self, at: &SurfacePoint, w: Dir3, aim: &Aim) -> Option<[f64; 2]> {
        if let Some(towards) = AreaLight::cone(at.p, aim) {
            return towards.cone.inverse(w);
        }
        let local = Frame::from_unit(at.n).to_local(w);
        let upper = local.z > 0.0;
        let folded = Vec3::new(local.x, local.y, if self.two_sided { local.z.abs() } else { local.z });
        let [u, v] = CosineHemisphere.inverse(Dir3::from_unit(folded))?;
        Some(match (self.two_sided, upper) {
            (false, _) => [u, v],
            (true, true) => [0.5 * u, v],
            (true, false) => [0.5 + 0.5 * u, v],
        })
    }

    /// ∫ |cos| dω over the directions that leave a point and reach the aim's sphere.
    fn projected_solid_angle(&self, at: &SurfacePoint, centre: Point3, radius: f64) -> f64 {
        let distance = at.p.distance(centre);
        let sin = radius / distance;
        if sin.is_nan() || sin >= 1.0 {
            return PI * self.sides();
        }
        let cos = at.n.dot(centre - at.p) / distance;
        let front = projected_cap(cos, sin);
        if self.two_sided { front + projected_cap(-cos, sin) } else { front }
    }

    /// A point of the surface drawn by area, as seen from `p`.
    fn sample_li_by_area(&self, p: Point3, u: [f64; 2]) -> Option<LightSample> {
        let at = self.surface.sample(u)?;
        let wi = Dir3::new(at.p - p)?;
        let distance = p.distance(at.p);
        let cos = -wi.dot(at.n);
        if cos == 0.0 || (cos < 0.0 && !self.two_sided) {
            return None;
        }
        let pdf = Pdf::<Area>::new(1.0 / at.inverse_pdf()).to_solid_angle(distance * distance, cos);
        Some(LightSample { wi, distance, weight: self.radiance / pdf.get(), pdf: Some(pdf) })
    }
}

/// ∫ cos dω over the part above the horizon of a cap of directions: `cos` of the angle between its axis and the
/// normal, `sin` of its half angle below 1 `[Snyder96]`, `[Lagarde14]`.
fn projected_cap(cos: f64, sin: f64) -> f64 {
    let sin_squared = sin * sin;
    if cos * cos >= sin_squared {
        // Wholly above or below the horizon.
        return PI * sin_squared * cos.max(0.0);
    }
    let sin_axis = (1.0 - cos * cos).sqrt();
    let x = ((1.0 - sin_squared) / sin_squared).sqrt();
    let y = (-x * cos / sin_axis).clamp(-1.0, 1.0);
    let root = sin_axis * (1.0 - y * y).sqrt();
    (cos * y.acos() - x * root) * sin_squared + root.atan2(x)
}

impl Light for AreaLight {
    /// π L A, for each side.
    fn power(&self) -> Flux {
        Flux(self.radiance.0 * (PI * self.area() * self.sides()))
    }

    /// `None` where the direction leaves on the dark side or misses the aim.
    fn emit(&self, u: [f64; 4], aim: &Aim) -> Option<Emission> {
        let at = self.surface.sample([u[0], u[1]])?;
        let leaving = self.leave(&at, [u[2], u[3]], aim)?;
        let cos = at.n.dot(leaving.w);
        if cos == 0.0 || (cos < 0.0 && !self.two_sided) {
            return None;
        }
        let [dw_du, dw_dv, dw_dtheta, dw_dphi] = leaving.dw;
        Some(Emission {
            origin: at.p,
            direction: leaving.w,
            normal: Some(at.n),
            flux: Flux(self.radiance.0 * (cos.abs() * at.inverse_pdf() / leaving.pdf.get())),
            pdf_a: Some(Pdf::new(1.0 / at.inverse_pdf())),
            pdf_w: Some(leaving.pdf),
            jacobian: Differential::new([
                Column { dx: at.dpdu, dw: dw_du },
                Column { dx: at.dpdv, dw: dw_dv },
                Column::direction(dw_dtheta),
                Column::direction(dw_dphi),
            ]),
            motion: Column::ZERO,
        })
    }

    fn following(&self, u: [f64; 4], aim: &Aim, step: Vec3) -> Column {
        match self.surface.sample([u[0], u[1]]).filter(|at| AreaLight::cone(at.p, aim).is_some()) {
            Some(at) => aim::following(at.p, aim, [u[2], u[3]], step),
            None => Column::ZERO,
        }
    }

    fn emission_inverse(&self, origin: Point3, direction: Dir3, aim: &Aim) -> Option<[f64; 4]> {
        let u = self.surface.inverse(origin)?;
        let w = self.leave_inverse(&self.surface.sample(u)?, direction, aim)?;
        Some([u[0], u[1], w[0], w[1]])
    }

    fn emitted_flux(&self, aim: &Aim) -> Flux {
        let Aim::Sphere { centre, radius } = *aim else { return self.power() };
        let integral = mean_over_square(FLUX_STEPS, |u| {
            self.surface.sample(u).map_or(0.0, |at| at.inverse_pdf() * self.projected_solid_angle(&at, centre, radius))
        });
        Flux(self.radiance.0 * integral)
    }

    /// A sphere seen from outside: uniform in the cone that it subtends. Anything else: by area.
    fn sample_li(&self, p: Point3, u: [f64; 2]) -> Option<LightSample> {
        let Some((centre, radius)) = self.sphere else { return self.sample_li_by_area(p, u) };
        let Some(seen) = SphereCone::new(p, centre, radius) else {
            return if self.two_sided { self.sample_li_by_area(p, u) } else { None };
        };
        let wi = seen.cone.sample(u);
        let across = seen.cone.frame.project(wi.to_vec()).length();
        let to_centre = p.distance(centre);
        let half_chord = ((radius - to_centre * across) * (radius + to_centre * across)).max(0.0).sqrt();
        let distance = to_centre * wi.dot(seen.cone.frame.n) - half_chord;
        let pdf = seen.cone.pdf();
        Some(LightSample { wi, distance, weight: self.radiance / pdf.get(), pdf: Some(pdf) })
    }

    fn pdf_li(&self, p: Point3, wi: Dir3, p_on_light: Point3, n_on_light: Normal3) -> Pdf<SolidAngle> {
        let cos = -wi.dot(n_on_light);
        if cos == 0.0 || (cos < 0.0 && !self.two_sided) {
            return Pdf::ZERO;
        }
        if let Some(seen) = self.sphere.and_then(|(centre, radius)| SphereCone::new(p, centre, radius)) {
            // Only the near side of the sphere is drawn.
            return if cos > 0.0 { seen.cone.pdf() } else { Pdf::ZERO };
        }
        self.surface.pdf_at(n_on_light).to_solid_angle(p.distance_squared(p_on_light), cos)
    }

    fn bounds(&self) -> Option<LightBounds> {
        let (bounds, normals) = match &self.surface {
            Surface::Mesh(mesh) => mesh.bounds(),
            Surface::Shape(shape) => shape.bounds(),
        };
        let power = self.power().0.luminance();
        Some(LightBounds { bounds, normals, reach: FRAC_PI_2, power, two_sided: self.two_sided })
    }

    fn radiance(&self, n: Normal3, w_out: Dir3) -> Radiance {
        if self.two_sided || n.dot(w_out) > 0.0 { self.radiance } else { Radiance::ZERO }
    }
}
