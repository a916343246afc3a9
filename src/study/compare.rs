//! Errors of a study's renders: where they are measured and on which scale.

use super::error::StudyError;
use super::metric::{Options, SsimDomain, compare_masked};
use super::plan::{Experiment, StudyScene};
use super::reference::Reference;
use super::results::Metrics;
use crate::film::Image;

/// Judges the renders of one scene in one experiment. All values are taken in units of the scene's white.
pub struct Judge<'a> {
    scene: &'a StudyScene,
    reference: Image,
    /// Pixels that are compared; all if none.
    mask: Option<Vec<bool>>,
    options: Options,
}

impl<'a> Judge<'a> {
    pub fn new(scene: &'a StudyScene, reference: &Reference, experiment: &Experiment) -> Result<Judge<'a>, StudyError> {
        let [width, height] = [reference.image.width, reference.image.height];
        for (what, rectangle) in [("region", experiment.region), ("crop", experiment.crop)] {
            if rectangle.is_some_and(|[_, _, x1, y1]| x1 > width || y1 > height) {
                return Err(StudyError::OutsideThePicture { scene: scene.name.clone(), what, size: [width, height] });
            }
        }
        let mask = intersection(reference.mask.as_deref(), experiment.region, width, height);
        if mask.as_ref().is_some_and(|mask| !mask.contains(&true)) {
            return Err(StudyError::NothingToCompare { scene: scene.name.clone() });
        }
        let options = Options { ssim_domain: scene.ssim, ..Options::default() };
        Ok(Judge { scene, reference: in_units_of(&reference.image, scene.white), mask, options })
    }

    /// All errors of a render.
    pub fn metrics(&self, image: &Image, which: &str) -> Result<Metrics, StudyError> {
        self.found(image, which, &self.options)
    }

    /// All but FLIP: what a search goes by.
    pub fn quick_metrics(&self, image: &Image, which: &str) -> Result<Metrics, StudyError> {
        self.found(image, which, &Options { no_flip: true, ..self.options.clone() })
    }

    fn found(&self, image: &Image, which: &str, options: &Options) -> Result<Metrics, StudyError> {
        let test = in_units_of(image, self.scene.white);
        let mask = self.mask.as_deref();
        let found = compare_masked(&test, &self.reference, mask, options).map_err(|source| StudyError::Metric {
            scene: self.scene.name.clone(),
            which: which.to_owned(),
            source,
        })?;
        Ok(Metrics {
            rmse: found.rmse_shown,
            rmse_linear: found.rmse,
            rel_mse: found.rel_mse,
            mae: found.mae,
            ssim: found.ssim,
            flip: found.flip,
            flip_hdr: found.flip_hdr,
        })
    }
}

/// As results name it.
pub fn domain_name(domain: SsimDomain) -> &'static str {
    match domain {
        SsimDomain::Linear => "linear",
        SsimDomain::Srgb => "srgb",
    }
}

/// Root mean square of the reference's own standard errors over its pixels, as shown: where it is clipped it has none.
pub fn shown_error(reference: &Reference, white: f64) -> f64 {
    let Some(rgb) = reference.image.rgb("") else { return f64::NAN };
    let (mut sum, mut count) = (0.0, 0u64);
    for (i, error) in reference.error.iter().enumerate() {
        if reference.mask.as_ref().is_some_and(|mask| !mask[i]) {
            continue;
        }
        for (channel, error) in rgb.iter().zip(error) {
            count += 1;
            if f64::from(channel[i]) < white {
                sum += (error / white).powi(2);
            }
        }
    }
    (sum / count.max(1) as f64).sqrt()
}

fn in_units_of(image: &Image, white: f64) -> Image {
    let mut scaled = image.clone();
    for value in scaled.channels.iter_mut().flat_map(|channel| channel.samples.iter_mut()) {
        *value = (f64::from(*value) / white) as f32;
    }
    scaled
}

fn intersection(mask: Option<&[bool]>, region: Option<[u32; 4]>, width: u32, height: u32) -> Option<Vec<bool>> {
    let Some([x0, y0, x1, y1]) = region else { return mask.map(<[bool]>::to_vec) };
    let inside = |i: u32| (x0..x1).contains(&(i % width)) && (y0..y1).contains(&(i / width));
    let held = |i: u32| mask.is_none_or(|mask| mask[i as usize]);
    Some((0..width * height).map(|i| inside(i) && held(i)).collect())
}
