//! Light from an image of the environment · W/(m²·sr) · directions in proportion to it, positions on the aim's disk ⟂ to them.
//!
//! Directions are drawn from rectangles of texels, each with the same density; a photon's columns are those of its
//! rectangle, so that what it stands for, 1/(n p), is small in the sun and wide in the sky about it.

use std::f64::consts::PI;

use super::environment::across_disk;
use super::{Aim, Emission, Light, LightSample, SceneSphere};
use crate::differential::Column;
use crate::math::{Dir3, Frame, Normal3, Point3, Vec3};
use crate::radiometry::{Flux, Pdf, Radiance, SolidAngle, Spectrum};
use crate::sampling::piecewise::{Grid, PiecewiseConstant};
use crate::sampling::warp::{ConcentricDisk, CylinderSphere, UniformSphere, Warp};
use crate::scene::panorama::{Panorama, Projection};

/// What is seen under a smaller solid angle, sr, is as good as one direction: where its rays start says where they land.
const NARROW: f64 = 0.01;

/// An image, or the bright or the dim part of one, around the scene.
#[derive(Clone, Debug)]
pub struct PanoramaLight {
    panorama: Panorama,
    density: PiecewiseConstant,
    /// Of the rows, in t.
    edges: Vec<f64>,
    /// ∫ L dω, W/m².
    integral: Spectrum,
    is_narrow: bool,
    scene: SceneSphere,
}

/// A direction towards the panorama.
struct Towards {
    wi: Dir3,
    /// ∂wi/∂u of the two coordinates.
    columns: [Vec3; 2],
    pdf: Pdf<SolidAngle>,
    radiance: Spectrum,
}

impl PanoramaLight {
    /// `None` if it is black.
    pub fn new(panorama: Panorama, scene: SceneSphere) -> Option<PanoramaLight> {
        let edges = panorama.row_edges();
        let texels = panorama.image.texels.len();
        let values: Vec<f32> = (0..texels).map(|i| panorama.radiance(i).luminance() as f32).collect();
        let density =
            PiecewiseConstant::new(&Grid { columns: panorama.image.texels.width(), rows: &edges, values: &values })?;
        let (integral, shining) = panorama.integral();
        Some(PanoramaLight { panorama, density, edges, integral, is_narrow: shining < NARROW, scene })
    }

    /// From the equal-area square to the world, with the derivatives.
    fn direction(&self, x: [f64; 2]) -> (Dir3, [Vec3; 2]) {
        let (local, columns) = match self.panorama.projection {
            Projection::LatLong => CylinderSphere.sample_with_jacobian(x),
            Projection::Octahedral => UniformSphere.sample_with_jacobian(x),
        };
        let [a, b, c] = self.panorama.axes.map(Dir3::to_vec);
        let turned = |v: Vec3| a * v.x + b * v.y + c * v.z;
        (Dir3::from_unit(turned(local.to_vec())), columns.map(turned))
    }

    fn square(&self, wi: Dir3) -> [f64; 2] {
        let local = Dir3::from_unit(Vec3::from_array(self.panorama.axes.map(|axis| axis.dot(wi))));
        let x = match self.panorama.projection {
            Projection::LatLong => CylinderSphere.inverse(local),
            Projection::Octahedral => UniformSphere.inverse(local),
        };
        // Both maps reach every direction.
        x.unwrap_or([0.5; 2])
    }

    fn radiance_at(&self, [s, t]: [f64; 2]) -> Spectrum {
        let (width, height) = (self.panorama.image.texels.width(), self.panorama.image.texels.height());
        let column = ((s * width as f64) as usize).min(width - 1);
        let row = self.edges.partition_point(|&edge| edge <= t).clamp(1, height) - 1;
        self.panorama.radiance(row * width + column)
    }

    fn draw(&self, u: [f64; 2]) -> Towards {
        let drawn = self.density.sample(u);
        let (wi, [ds, dt]) = self.direction(drawn.x);
        let columns = [ds * drawn.stretch[0], dt * drawn.stretch[1]];
        Towards { wi, columns, pdf: Pdf::new(drawn.pdf / (4.0 * PI)), radiance: self.radiance_at(drawn.x) }
    }
}

impl Light for PanoramaLight {
    fn power(&self) -> Flux {
        self.emitted_flux(&Aim::Everywhere)
    }

    /// The disk turns with the direction about the aim's centre, so the directional columns have positions too.
    fn emit(&self, u: [f64; 4], aim: &Aim) -> Option<Emission> {
        let Towards { wi, columns, pdf, radiance } = self.draw([u[2], u[3]]);
        if radiance.is_black() {
            return None;
        }
        let (origin, jacobian) = across_disk(&self.scene, aim, [u[0], u[1]], (-wi, columns.map(|dw| -dw)));
        let radius = self.scene.aimed(aim).radius;
        let area = PI * radius * radius;
        Some(Emission {
            origin,
            direction: -wi,
            normal: None,
            flux: Flux(radiance * (area / pdf.get())),
            pdf_a: Some(Pdf::new(1.0 / area)),
            pdf_w: Some(pdf),
            jacobian,
            motion: Column::ZERO,
        })
    }

    fn emission_inverse(&self, origin: Point3, direction: Dir3, aim: &Aim) -> Option<[f64; 4]> {
        let aimed = self.scene.aimed(aim);
        let disk = Frame::from_unit(direction).project(origin - aimed.centre) / aimed.radius;
        let (x, w) = (ConcentricDisk.inverse(disk)?, self.density.inverse(self.square(-direction))?);
        Some([x[0], x[1], w[0], w[1]])
    }

    /// ∫ L dω times the disk's area.
    fn emitted_flux(&self, aim: &Aim) -> Flux {
        let radius = self.scene.aimed(aim).radius;
        Flux(self.integral * (PI * radius * radius))
    }

    fn sample_li(&self, _: Point3, u: [f64; 2]) -> Option<LightSample> {
        let Towards { wi, pdf, radiance, .. } = self.draw(u);
        let weight = Radiance(radiance * (1.0 / pdf.get()));
        Some(LightSample { wi, distance: f64::INFINITY, weight, pdf: Some(pdf) })
    }

    fn pdf_li(&self, _: Point3, _: Dir3, _: Point3, _: Normal3) -> Pdf<SolidAngle> {
        Pdf::ZERO
    }

    fn environment_radiance(&self, wi: Dir3) -> Radiance {
        Radiance(self.radiance_at(self.square(wi)))
    }

    fn environment_pdf(&self, wi: Dir3) -> Pdf<SolidAngle> {
        Pdf::new(self.density.pdf(self.square(wi)) / (4.0 * PI))
    }

    fn is_collimated(&self) -> bool {
        self.is_narrow
    }
}
