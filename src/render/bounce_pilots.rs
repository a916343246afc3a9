//! What share of the bounces to aim at the objects that make caustics: as much as makes the picture's noise least.
//!
//! Pilot paths over the whole picture aim half of their first bounces. What each of them brings back, x, says what the
//! second moment would be with any other share α: the mean of x² p_½/p_α, of which the least is looked for. x is relative
//! to the light that the sample sees anyhow, as noise in a picture is. Light from photons is not in x.

use super::bounce::Bounces;
use super::eye_path::{EyeFinds, EyePathTracer, Returned};
use super::progress::Silent;
use super::unit::collect_units;
use super::watch::Unattended;
use crate::camera::Camera;
use crate::math::{Point2, Vec2};
use crate::sampling::{PixelSamples, qmc};
use crate::world::World;

/// Rows of pilots and pilots in a row.
const ROWS: usize = 64;
const PER_ROW: usize = 256;
/// Share of the pilots' bounces that is aimed.
const PILOT_SHARE: f64 = 0.5;
/// The largest share: what lies elsewhere must not starve, whatever the pilots missed. More gains little: in `ball` three
/// quarters instead of a half take another seventh of the noise, for a ninth more time.
const MAX_SHARE: f64 = 0.5;
/// Steps up to it that are compared.
const SHARES: u32 = 8;

/// How the bounces of this picture are drawn best.
pub fn learn(world: &World, camera: &Camera) -> Bounces {
    let settings = &world.scene.settings;
    let Some(aim) = world.aim.filter(|_| settings.max_bounces > 0) else { return Bounces::UNAIMED };
    let tracer = EyePathTracer {
        world,
        finds: EyeFinds::AllButCaustics,
        max_depth: settings.max_depth,
        max_bounces: settings.max_bounces,
        bounces: Bounces { aim, aimed: PILOT_SHARE },
        sample_radius: 0.0,
    };
    let row = |row: usize| -> Vec<Returned> {
        (row * PER_ROW..(row + 1) * PER_ROW).filter_map(|i| pilot(&tracer, camera, i as u64)).collect()
    };
    // Nobody stops it: it takes a few hundredths of a second.
    let Ok(rows) = collect_units(ROWS, &Unattended(&Silent), row) else { return Bounces::UNAIMED };
    let aimed = best_share(&tracer.bounces, &rows.concat());
    Bounces { aim, aimed }
}

/// Pilot `i`. The numbers are fixed ones, so that the share is a property of the scene.
fn pilot(tracer: &EyePathTracer, camera: &Camera, i: u64) -> Option<Returned> {
    let [width, height] = tracer.world.scene.camera.resolution;
    let [x, y] = qmc::golden_lattice(i, (ROWS * PER_ROW) as u64);
    let start = PixelSamples::new(0, u32::MAX, i, 1).get(0);
    let ray = camera.ray(Point2::new(x * f64::from(width), y * f64::from(height)), Vec2::ZERO);
    tracer.pilot(&ray, &start, PixelSamples::stream(0, u32::MAX, i, 0))
}

/// The share with the least second moment; the smallest of those that are equally good.
fn best_share(pilots: &Bounces, returned: &[Returned]) -> f64 {
    let mean = returned.iter().map(|r| r.light).sum::<f64>() / returned.len() as f64;
    if returned.is_empty() || mean <= 0.0 {
        return 0.0;
    }
    let moment = |share: f64| -> f64 {
        let one = |r: &Returned| {
            let x = r.light / (r.anyhow + mean);
            // Where nothing is aimed at the share does not matter.
            let ratio = pilots.aimed_pdf(r.from, r.wi).map_or(1.0, |aimed| {
                let own = (r.pdf.get() - PILOT_SHARE * aimed.get()) / (1.0 - PILOT_SHARE);
                r.pdf.get() / (share * aimed.get() + (1.0 - share) * own)
            });
            x * x * ratio
        };
        returned.iter().map(one).sum()
    };
    let shares = (0..=SHARES).map(|k| f64::from(k) * MAX_SHARE / f64::from(SHARES));
    shares.map(|share| (moment(share), share)).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, share)| share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::Aim;
    use crate::math::{Dir3, Point3, Vec3};
    use crate::radiometry::Pdf;

    /// Pilots that aim half at a cone of 2 sr around z and go evenly over 4 sr else; `light` says what comes from inside
    /// and from outside of the cone.
    fn returned(pilots: &Bounces, light: [f64; 2]) -> Vec<Returned> {
        let one = |i: u32| {
            // In the middle between the two samplings, 0.75 of all are in the cone.
            let inside = i % 4 != 3;
            let wi = if inside { Dir3::Z } else { Dir3::X };
            let aimed = pilots.aimed_pdf(Point3::ORIGIN, wi).expect("from outside").get();
            let pdf = Pdf::new(PILOT_SHARE * aimed + (1.0 - PILOT_SHARE) * 0.25);
            Returned { from: Point3::ORIGIN, wi, pdf, light: light[usize::from(!inside)], anyhow: 1.0 }
        };
        (0..64).map(one).collect()
    }

    #[test]
    fn as_much_is_aimed_as_light_comes_from_there() {
        let aim = Aim::Sphere { centre: Point3::from_vec(Vec3::Z * 2.0), radius: 1.0 };
        let pilots = Bounces { aim, aimed: PILOT_SHARE };
        let best = |light| best_share(&pilots, &returned(&pilots, light));
        assert_eq!(best([1.0, 0.0]), MAX_SHARE);
        assert_eq!(best([0.0, 1.0]), 0.0);
        assert_eq!(best([0.0, 0.0]), 0.0);
        let between = best([1.0, 2.0]);
        assert!(between > 0.0 && between < MAX_SHARE, "{between}");
    }

    /// From within the aim's sphere nothing is aimed at, and the share makes no difference: the smallest is taken.
    #[test]
    fn pilots_within_the_aim_say_nothing() {
        let pilots = Bounces { aim: Aim::Sphere { centre: Point3::ORIGIN, radius: 1.0 }, aimed: PILOT_SHARE };
        let within = Returned { from: Point3::ORIGIN, wi: Dir3::Z, pdf: Pdf::new(0.3), light: 1.0, anyhow: 1.0 };
        assert_eq!(best_share(&pilots, &[within; 8]), 0.0);
    }
}
