//! The constant environment · W/(m²·sr) · directions by the octahedral map, positions on the aim's disk ⟂ to them.

use std::f64::consts::PI;

use super::{Aim, Emission, Light, LightSample, SceneSphere};
use crate::differential::{Column, Differential};
use crate::math::{Dir3, Frame, Normal3, Point3, Vec3};
use crate::radiometry::{Flux, Pdf, Radiance, SolidAngle};
use crate::sampling::warp::{ConcentricDisk, UniformSphere, Warp};

/// The same radiance from everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentLight {
    pub radiance: Radiance,
    pub scene: SceneSphere,
}

/// Where a ray along `direction` starts on the aim's disk ⟂ to it over the sample `u`, upstream of the scene, and the columns of
/// its emission; `turnings` are those of the direction.
pub(super) fn across_disk(
    scene: &SceneSphere,
    aim: &Aim,
    u: [f64; 2],
    (direction, turnings): (Dir3, [Vec3; 2]),
) -> (Point3, Differential<4>) {
    let aimed = scene.aimed(aim);
    let frame = Frame::from_unit(direction);
    let (disk, columns) = ConcentricDisk.sample_with_jacobian(u);
    let disk = disk * aimed.radius;
    let upstream = scene.upstream(aimed.centre, direction);
    let origin = aimed.centre + frame.t * disk.x + frame.b * disk.y - direction * upstream;
    let position = columns.map(|d| Column::position(frame.to_world((d * aimed.radius).extend(0.0))));
    let turning = turnings.map(|dw| {
        let axes = Frame::from_unit_derivative(direction, dw);
        let d_upstream = dw.dot(aimed.centre - scene.centre);
        Column { dx: axes[0] * disk.x + axes[1] * disk.y - dw * upstream - direction * d_upstream, dw }
    });
    (origin, Differential::new([position[0], position[1], turning[0], turning[1]]))
}

impl Light for EnvironmentLight {
    /// 4π² R² L, through the scene's bounding sphere.
    fn power(&self) -> Flux {
        self.emitted_flux(&Aim::Everywhere)
    }

    /// The disk turns with the direction about the aim's centre, so the directional columns have positions too.
    fn emit(&self, u: [f64; 4], aim: &Aim) -> Option<Emission> {
        let radius = self.scene.aimed(aim).radius;
        let (direction, turnings) = UniformSphere.sample_with_jacobian([u[2], u[3]]);
        let (origin, jacobian) = across_disk(&self.scene, aim, [u[0], u[1]], (direction, turnings));
        Some(Emission {
            origin,
            direction,
            normal: None,
            flux: self.emitted_flux(aim),
            pdf_a: Some(Pdf::new(1.0 / (PI * radius * radius))),
            pdf_w: Some(UniformSphere.pdf(direction)),
            jacobian,
            motion: Column::ZERO,
        })
    }

    fn emission_inverse(&self, origin: Point3, direction: Dir3, aim: &Aim) -> Option<[f64; 4]> {
        let aimed = self.scene.aimed(aim);
        let disk = Frame::from_unit(direction).project(origin - aimed.centre) / aimed.radius;
        let (x, w) = (ConcentricDisk.inverse(disk)?, UniformSphere.inverse(direction)?);
        Some([x[0], x[1], w[0], w[1]])
    }

    /// 4π sr times the disk's area: every direction meets a sphere in a disk of the same size.
    fn emitted_flux(&self, aim: &Aim) -> Flux {
        let radius = self.scene.aimed(aim).radius;
        Flux(self.radiance.0 * (4.0 * PI * PI * radius * radius))
    }

    fn sample_li(&self, _: Point3, u: [f64; 2]) -> Option<LightSample> {
        let wi = UniformSphere.sample(u);
        let pdf = UniformSphere.pdf(wi);
        Some(LightSample { wi, distance: f64::INFINITY, weight: self.radiance / pdf.get(), pdf: Some(pdf) })
    }

    fn pdf_li(&self, _: Point3, _: Dir3, _: Point3, _: Normal3) -> Pdf<SolidAngle> {
        Pdf::ZERO
    }

    fn environment_radiance(&self, _: Dir3) -> Radiance {
        self.radiance
    }

    fn environment_pdf(&self, wi: Dir3) -> Pdf<SolidAngle> {
        UniformSphere.pdf(wi)
    }
}
