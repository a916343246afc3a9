//! Parallel light · W/m² on a plane across it · columns: positions over the beam's cross-section, no directions.

use std::f64::consts::PI;

use super::{Aim, Emission, Light, LightSample, SceneSphere};
use crate::differential::{Column, Differential};
use crate::math::{Dir3, Frame, Normal3, Point3, Vec2, Vec3};
use crate::radiometry::{Flux, Irradiance, Pdf, Radiance, SolidAngle};
use crate::sampling::warp::{ConcentricDisk, Parallelogram, Warp};
use crate::scene::light::BeamExtent;

/// A collimated beam or a sun without size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    frame: Frame,
    direction: Dir3,
    irradiance: Irradiance,
    /// Where a bounded beam starts, `None` for unbounded light.
    section: Option<Section>,
    scene: SceneSphere,
}

/// A cross-section, perpendicular to the beam.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Section {
    Rectangle(Parallelogram),
    Disk { centre: Point3, radius: f64 },
}

/// A point on a section with the derivatives of its map.
type Placed = (Point3, [Vec3; 2]);

impl Section {
    fn centre(&self) -> Point3 {
        match *self {
            Section::Rectangle(r) => r.centre,
            Section::Disk { centre, .. } => centre,
        }
    }
    fn area(&self) -> f64 {
        match *self {
            Section::Rectangle(r) => r.area(),
            Section::Disk { radius, .. } => PI * radius * radius,
        }
    }
    fn sample(&self, frame: &Frame, u: [f64; 2]) -> Placed {
        match *self {
            Section::Rectangle(r) => r.sample_with_jacobian(u),
            Section::Disk { centre, radius } => {
                let across = |d: Vec2| frame.to_world((d * radius).extend(0.0));
                let (disk, columns) = ConcentricDisk.sample_with_jacobian(u);
                (centre + across(disk), columns.map(across))
            }
        }
    }
    /// Of a point in the section's plane.
    fn inverse(&self, frame: &Frame, x: Point3) -> Option<[f64; 2]> {
        match *self {
            Section::Rectangle(r) => r.inverse(x),
            Section::Disk { centre, radius } => ConcentricDisk.inverse(frame.project(x - centre) / radius),
        }
    }
    /// Area common with a disk in the same plane.
    fn area_within(&self, frame: &Frame, disk_centre: Point3, disk_radius: f64) -> f64 {
        match *self {
            Section::Rectangle(r) => {
                let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
                    .map(|(s, t)| frame.project(r.centre + r.a * s + r.b * t - disk_centre));
                let area: f64 = (0..4).map(|i| wedge_within(corners[i], corners[(i + 1) % 4], disk_radius)).sum();
                area.abs()
            }
            Section::Disk { centre, radius } => lens_area(centre.distance(disk_centre), radius, disk_radius),
        }
    }
}

/// Signed area of the triangle (origin, p, q) within the disk of radius r about the origin.
fn wedge_within(p: Vec2, q: Vec2, r: f64) -> f64 {
    let sector = |p: Vec2, q: Vec2| 0.5 * r * r * p.perp_dot(q).atan2(p.dot(q));
    let d = q - p;
    let (a, b, c) = (d.length_squared(), p.dot(d), p.length_squared() - r * r);
    let discriminant = b * b - a * c;
    if a == 0.0 || discriminant <= 0.0 {
        return sector(p, q);
    }
    let (enter, leave) = ((-b - discriminant.sqrt()) / a, (-b + discriminant.sqrt()) / a);
    if enter >= 1.0 || leave <= 0.0 {
        return sector(p, q);
    }
    let (first, last) = (p + d * enter.max(0.0), p + d * leave.min(1.0));
    sector(p, first) + 0.5 * first.perp_dot(last) + sector(last, q)
}

/// Area common to two disks.
fn lens_area(distance: f64, r: f64, s: f64) -> f64 {
    if distance >= r + s {
        return 0.0;
    }
    if distance <= (r - s).abs() {
        return PI * r.min(s).powi(2);
    }
    // Each disk's circular segment beyond the common chord.
    let segment = |r: f64, s: f64| {
        let half = ((distance * distance + r * r - s * s) / (2.0 * distance * r)).clamp(-1.0, 1.0).acos();
        r * r * (half - half.sin() * half.cos())
    };
    segment(r, s) + segment(s, r)
}

impl DirectionalLight {
    /// The axes of a rectangle that is not perpendicular to `direction` are projected along it, which leaves the beam
    /// as it is. `None` for a section without area.
    pub fn new(
        direction: Dir3,
        irradiance: Irradiance,
        extent: &BeamExtent,
        scene: SceneSphere,
    ) -> Option<DirectionalLight> {
        let across = |v: Vec3| v - direction * direction.dot(v);
        let section = match *extent {
            BeamExtent::Unbounded => None,
            BeamExtent::Rectangle { centre, a, b } => {
                Some(Section::Rectangle(Parallelogram { centre, a: across(a), b: across(b) }))
            }
            BeamExtent::Disk { centre, radius } => Some(Section::Disk { centre, radius }),
        };
        if section.is_some_and(|s| s.area().is_nan() || s.area() <= 0.0) {
            return None;
        }
        Some(DirectionalLight { frame: Frame::from_unit(direction), direction, irradiance, section, scene })
    }

    /// The disk of the section's plane from which rays reach the aim's sphere.
    fn reaching(&self, section: &Section, aim: &Aim) -> Reach {
        let Aim::Sphere { centre, radius } = *aim else { return Reach::All };
        let ahead = self.direction.dot(centre - section.centre());
        // Of a sphere whose centre lies behind the plane only the part before it is reached.
        let radius_squared = radius * radius - ahead.min(0.0).powi(2);
        if radius_squared > 0.0 {
            Reach::Disk { centre: centre - self.direction * ahead, radius: radius_squared.sqrt() }
        } else {
            Reach::None
        }
    }

    /// The smaller of the section and the aim's disk, and the other one, in which points must lie too.
    fn patch(&self, aim: &Aim) -> Option<(Section, Option<Section>)> {
        let Some(section) = self.section else {
            let SceneSphere { centre, radius } = self.scene.aimed(aim);
            return Some((Section::Disk { centre, radius }, None));
        };
        match self.reaching(&section, aim) {
            Reach::All => Some((section, None)),
            Reach::None => None,
            Reach::Disk { centre, radius } => {
                let disk = Section::Disk { centre, radius };
                let disk_is_smaller = disk.area() < section.area();
                Some(if disk_is_smaller { (disk, Some(section)) } else { (section, Some(disk)) })
            }
        }
    }
}

/// From where in a plane an aim is reached.
enum Reach {
    All,
    Disk { centre: Point3, radius: f64 },
    None,
}

impl Light for DirectionalLight {
    /// Irradiance times the section's area, or times the scene's disk.
    fn power(&self) -> Flux {
        self.emitted_flux(&Aim::Everywhere)
    }

    /// `None` where the section and the aim's disk do not overlap: points are drawn from the smaller one.
    fn emit(&self, u: [f64; 4], aim: &Aim) -> Option<Emission> {
        let (patch, required) = self.patch(aim)?;
        let (x, [dx_du, dx_dv]) = patch.sample(&self.frame, [u[0], u[1]]);
        if required.is_some_and(|other| other.inverse(&self.frame, x).is_none()) {
            return None;
        }
        let area = patch.area();
        let origin =
            if self.section.is_some() { x } else { x - self.direction * self.scene.upstream(x, self.direction) };
        Some(Emission {
            origin,
            direction: self.direction,
            normal: None,
            flux: self.irradiance.through(area),
            pdf_a: Some(Pdf::new(1.0 / area)),
            pdf_w: None,
            jacobian: Differential::new([Column::position(dx_du), Column::position(dx_dv), Column::ZERO, Column::ZERO]),
            motion: Column::ZERO,
        })
    }

    /// Points are drawn from the aim's disk if that is the smaller one.
    fn following(&self, _: [f64; 4], aim: &Aim, step: Vec3) -> Column {
        let Aim::Sphere { .. } = aim else { return Column::ZERO };
        let from_aim = match (&self.section, self.patch(aim)) {
            (_, None) => false,
            (None, Some(_)) => true,
            (Some(own), Some((patch, _))) => patch != *own,
        };
        let across = step - self.direction * self.direction.dot(step);
        if from_aim { Column::position(across) } else { Column::ZERO }
    }

    fn emission_inverse(&self, origin: Point3, _: Dir3, aim: &Aim) -> Option<[f64; 4]> {
        let u = self.patch(aim)?.0.inverse(&self.frame, origin)?;
        Some([u[0], u[1], 0.0, 0.0])
    }

    fn emitted_flux(&self, aim: &Aim) -> Flux {
        let Some(section) = self.section else {
            return self.irradiance.through(PI * self.scene.aimed(aim).radius.powi(2));
        };
        match self.reaching(&section, aim) {
            Reach::All => self.irradiance.through(section.area()),
            Reach::None => Flux::ZERO,
            Reach::Disk { centre, radius } => self.irradiance.through(section.area_within(&self.frame, centre, radius)),
        }
    }

    /// A bounded beam starts at its section, and so does the shadow ray's end.
    fn sample_li(&self, p: Point3, _: [f64; 2]) -> Option<LightSample> {
        let distance = match &self.section {
            None => f64::INFINITY,
            Some(section) => {
                let distance = self.direction.dot(p - section.centre());
                section.inverse(&self.frame, p - self.direction * distance)?;
                if distance <= 0.0 {
                    return None;
                }
                distance
            }
        };
        Some(LightSample { wi: -self.direction, distance, weight: Radiance(self.irradiance.0), pdf: None })
    }

    fn pdf_li(&self, _: Point3, _: Dir3, _: Point3, _: Normal3) -> Pdf<SolidAngle> {
        Pdf::ZERO
    }

    fn emission_aspect(&self, aim: &Aim) -> f64 {
        match self.patch(aim) {
            Some((Section::Rectangle(r), _)) => r.a.length() / r.b.length(),
            _ => 1.0,
        }
    }

    fn is_collimated(&self) -> bool {
        true
    }

    fn is_delta(&self) -> bool {
        true
    }
}
