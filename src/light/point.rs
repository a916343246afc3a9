//! The isotropic point source · W/sr · columns: no position, directions of the sphere's or the aim's map.

use super::aim::{self, Directions};
use super::{Aim, Emission, Light, LightBounds, LightSample, NormalCone, direction_columns};
use crate::differential::Column;
use crate::math::{Bounds3, Dir3, Normal3, Point3, Vec3};
use crate::radiometry::{Flux, Intensity, Pdf, Radiance, SolidAngle};

/// The same intensity in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    pub position: Point3,
    pub intensity: Intensity,
}

impl Light for PointLight {
    /// 4π I.
    fn power(&self) -> Flux {
        self.emitted_flux(&Aim::Everywhere)
    }

    fn emit(&self, u: [f64; 4], aim: &Aim) -> Option<Emission> {
        let directions = Directions::towards(self.position, aim);
        let (direction, columns) = directions.sample_with_jacobian([u[2], u[3]]);
        Some(Emission {
            origin: self.position,
            direction,
            normal: None,
            flux: Flux(self.intensity.0 * directions.solid_angle()),
            pdf_a: None,
            pdf_w: Some(directions.pdf()),
            jacobian: direction_columns(columns),
            motion: Column::ZERO,
        })
    }

    fn following(&self, u: [f64; 4], aim: &Aim, step: Vec3) -> Column {
        aim::following(self.position, aim, [u[2], u[3]], step)
    }

    fn emission_inverse(&self, _: Point3, direction: Dir3, aim: &Aim) -> Option<[f64; 4]> {
        let u = Directions::towards(self.position, aim).inverse(direction)?;
        Some([0.0, 0.0, u[0], u[1]])
    }

    fn emitted_flux(&self, aim: &Aim) -> Flux {
        Flux(self.intensity.0 * Directions::towards(self.position, aim).solid_angle())
    }

    fn sample_li(&self, p: Point3, _: [f64; 2]) -> Option<LightSample> {
        let wi = Dir3::new(self.position - p)?;
        let distance = p.distance(self.position);
        let weight = Radiance(self.intensity.0 / (distance * distance));
        Some(LightSample { wi, distance, weight, pdf: None })
    }

    fn pdf_li(&self, _: Point3, _: Dir3, _: Point3, _: Normal3) -> Pdf<SolidAngle> {
        Pdf::ZERO
    }

    fn bounds(&self) -> Option<LightBounds> {
        let bounds = Bounds3::EMPTY.including(self.position);
        let power = self.power().0.luminance();
        Some(LightBounds { bounds, normals: NormalCone::SPHERE, reach: 0.0, power, two_sided: false })
    }

    fn is_delta(&self) -> bool {
        true
    }
}
