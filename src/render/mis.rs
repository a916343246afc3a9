//! Multiple importance sampling of photons and eye paths: which part of a lamp's caustics each of the two brings.
//!
//! A bounce of the eye from a surface finds a lamp over mirrors or through glass with the probability p = E/(π L), if the
//! lamp of radiance L lights the surface so with the irradiance E; of s samples, the relative variance is 1/(p s). There,
//! m = E A/Φ photons of flux Φ cover a point with footprints of the area A; their relative variance is about 1/m. The mean
//! of both with the least variance, that of the balance heuristic `[Veach97 9.2]`, gives eye paths the part 1/(1 + r/s),
//! r = m/p = π A L/Φ, in which the brightness of the caustic cancels: one number does for a lamp and all that it lights.
//! L/Φ is the density of the lamp's photons over area and projected solid angle, which specular surfaces keep.
//!
//! r is some hundreds for a sky behind a pane, where some hundred samples a pixel take over, some thousands for one over a
//! mirror ring, and 10⁵ to 10⁹ for lamps.

use std::f64::consts::PI;

use super::emission::limits;
use super::photon_map::spread;
use crate::photon::{EmissionPlan, EmissionPoints, PhotonTracer};
use crate::sampling::{Purpose, Stream};
use crate::scene::settings::{Caustics, Estimator};
use crate::world::World;

/// Pilot photons of a light; the mean logarithm of r is known to a few per cent.
const PILOTS: u64 = 512;
/// Less than that is not worth the eye's way.
const LEAST: f64 = 0.05;

/// The eye's part of the caustics of a plan's light. Footprints alone have an area to weigh; discs get all.
pub fn eyes_part(world: &World, plan: &EmissionPlan) -> f64 {
    let settings = &world.scene.settings;
    let source = world.lights.get(plan.light);
    let alone = settings.caustics == Caustics::Photons || settings.estimator != Estimator::Differentials;
    if alone || source.is_delta() {
        return 0.0;
    }
    let Some(ratio) = mean_ratio(world, plan) else { return 0.0 };
    let part = 1.0 / (1.0 + ratio / f64::from(settings.spp));
    if part < LEAST { 0.0 } else { part }
}

/// The geometric mean of r over the photons that pilots store; `None` if there are none.
fn mean_ratio(world: &World, plan: &EmissionPlan) -> Option<f64> {
    let points = EmissionPoints::new(world, plan.light, &plan.target, plan.share, plan.points, 0);
    let mut tracer = PhotonTracer::<4, 0>::new(world, limits(world), spread(world, 0)).towards(&plan.target);
    let (mut log_ratio, mut photons) = (0.0, 0u32);
    let step = (plan.points / PILOTS).max(1);
    for i in (0..plan.points).step_by(step as usize) {
        let mut stream = Stream::new(0, Purpose::Guide, u32::MAX, u64::from(plan.light.0) << 44 | i);
        let u = points.point(i, &mut stream);
        if plan.guide.as_ref().is_some_and(|guide| guide.keep(points.leading(u)) < 1.0) {
            continue;
        }
        let time = points.time(i, &mut stream);
        let Some(mut emission) = world.lights.emit(plan.light, u, &plan.target.aim, time) else { continue };
        let (Some(pdf_a), Some(pdf_w)) = (emission.pdf_a, emission.pdf_w) else { continue };
        let cosine = emission.normal.map_or(1.0, |n| n.dot(emission.direction).abs());
        let density = plan.points as f64 * pdf_a.get() * pdf_w.get() / cosine;
        tracer.stored.caustic.clear();
        points.share(&mut emission, 1.0);
        tracer.trace(&emission, time, &mut stream);
        for photon in &tracer.stored.caustic {
            let area = PI * photon.form().determinant().max(0.0).sqrt();
            if area > 0.0 {
                log_ratio += (PI * area * density).ln();
                photons += 1;
            }
        }
    }
    (photons > 0).then(|| (log_ratio / f64::from(photons)).exp())
}
