//! What a scene's renders are compared with, and how well it is known itself.
//!
//! A rendered reference is a sum of parts, each the mean of passes of one layer, and carries the variance of that mean
//! in each pixel. Parts are kept as EXR files, named after a digest of the scene and its settings: channels `R G B` and
//! `variance.R` … ; more passes go on where a file ended. A closed form is computed anew each time.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::error::StudyError;
use super::exact::{self, ClosedForm};
use super::mask::directly_seen;
use super::plan::{ReferencePart, ReferencePlan, StudyScene};
use super::render::{file_stem, layer, program, write_pictures};
use crate::film::{Channel, Image, PixelBounds};
use crate::import::{self, Override};
use crate::output::exr;
use crate::render::progress::{Progress, Silent};
use crate::render::watch::Unattended;
use crate::render::{RenderState, go_on};
use crate::scene::Scene;
use crate::scene::settings::Method;
use crate::world::World;

/// Steps of progress that a pass of a reference counts.
pub(super) const STEPS_A_PASS: u64 = 20;

/// A part that is under way is put on disk this often.
const SAVE_EVERY: Duration = Duration::from_secs(30);

/// Where rendered parts are looked for, and put.
pub struct Shelf<'a> {
    /// Is only read; beside the study file.
    pub published: &'a Path,
    pub own: &'a Path,
}

/// A picture to compare with.
pub struct Reference {
    /// `R G B`, linear.
    pub image: Image,
    /// Standard error (of a closed form: quadrature error) of each pixel and colour, row by row.
    pub error: Vec<[f64; 3]>,
    /// Pixels that it holds; all if none.
    pub mask: Option<Vec<bool>>,
    pub about: String,
    pub seconds: f64,
    /// What the reader should know.
    pub notes: Vec<String>,
}

/// The reference of `scene`, whose files are found from `folder`.
pub fn reference(
    scene: &StudyScene,
    folder: &Path,
    shelf: &Shelf,
    progress: &dyn Progress,
) -> Result<Reference, StudyError> {
    match &scene.reference {
        ReferencePlan::Exact(form) => closed_form(scene, *form, &folder.join(&scene.file)),
        ReferencePlan::Rendered(parts) => rendered(scene, parts, &folder.join(&scene.file), shelf, progress),
    }
}

fn closed_form(scene: &StudyScene, form: ClosedForm, file: &Path) -> Result<Reference, StudyError> {
    let start = Instant::now();
    let loaded = import::load(file, &scene.overrides)?.scene;
    let picture = exact::picture(form, &loaded).map_err(|source| StudyError::NotThisForm {
        scene: scene.name.clone(),
        form: form.name(),
        source,
    })?;
    let pixels: Vec<[f32; 3]> = picture.radiance.iter().map(|rgb| rgb.map(|v| v as f32)).collect();
    Ok(Reference {
        image: Image::from_rgb(picture.width, picture.height, &pixels),
        error: picture.error,
        mask: None,
        about: format!("the exact irradiance: closed form `{}`", form.name()),
        seconds: start.elapsed().as_secs_f64(),
        notes: Vec::new(),
    })
}

fn rendered(
    scene: &StudyScene,
    parts: &[ReferencePart],
    file: &Path,
    shelf: &Shelf,
    progress: &dyn Progress,
) -> Result<Reference, StudyError> {
    let start = Instant::now();
    let (mut sum, mut about, mut notes) = (None::<Moments>, Vec::new(), Vec::new());
    let mut mask = None;
    for part in parts {
        let plan = PartPlan::new(scene, part, file)?;
        let (moments, note) = plan.finish(shelf, progress)?;
        notes.extend(note);
        about.push(plan.about(part, &moments));
        if plan.scene.settings.method == Method::LightTrace && mask.is_none() {
            mask = Some(directly_seen(&World::new(plan.scene.clone())?)?);
        }
        sum = Some(match sum {
            None => moments,
            Some(sum) => sum.plus(&moments),
        });
    }
    let sum = sum.ok_or_else(|| StudyError::NothingToCompare { scene: scene.name.clone() })?;
    Ok(Reference {
        image: sum.mean_image(),
        error: sum.standard_errors(),
        mask,
        about: about.join(" + "),
        seconds: start.elapsed().as_secs_f64(),
        notes,
    })
}

/// A part that is to have a number of passes.
struct PartPlan {
    scene: Scene,
    layer: String,
    passes: u32,
    label: String,
    white: f64,
}

impl PartPlan {
    fn new(scene: &StudyScene, part: &ReferencePart, file: &Path) -> Result<PartPlan, StudyError> {
        let mut overrides = [scene.overrides.clone(), part.overrides.clone()].concat();
        // The digest must not depend on how many passes are wanted: they are added to those that are there.
        overrides.push(Override::new("render.passes", "1"));
        if !part.layer.is_empty() {
            overrides.push(Override::new("render.layers", format!("[{:?}]", part.layer)));
        }
        let scene_read = import::load(file, &overrides)?.scene;
        let what = if part.layer.is_empty() { "beauty" } else { &part.layer };
        // Scenes of a study that differ in how they are looked at share the part.
        let stem = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let (layer, label, white) = (part.layer.clone(), file_stem(&format!("{stem}-{what}")), scene.white);
        Ok(PartPlan { scene: scene_read, layer, passes: part.passes, label, white })
    }

    fn about(&self, part: &ReferencePart, moments: &Moments) -> String {
        let what = if part.layer.is_empty() { "beauty" } else { &part.layer };
        let settings = &self.scene.settings;
        let work = match settings.method {
            Method::Path => format!("{} eye paths a pixel", u64::from(settings.spp) * u64::from(moments.passes)),
            _ => format!("{:.3e} light paths", settings.photons as f64 * f64::from(moments.passes)),
        };
        format!("{what} by `{}`, {work}", settings.method.name())
    }

    fn name(&self) -> String {
        format!("{}-{}", self.label, &self.scene.hash[..12])
    }

    /// The part with at least the wanted passes: found, continued, or made. With a note if files of another scene are
    /// in its way.
    fn finish(&self, shelf: &Shelf, progress: &dyn Progress) -> Result<(Moments, Option<String>), StudyError> {
        let found = [shelf.own, shelf.published].map(|folder| folder.join(self.name()));
        let mut best = None::<Moments>;
        for path in &found {
            let read = self.read(&path.with_extension("exr"))?;
            if read.as_ref().is_some_and(|m| best.as_ref().is_none_or(|b| b.passes < m.passes)) {
                best = read;
            }
        }
        let note = if best.is_none() { self.note_on_others(shelf) } else { None };
        let moments = best.unwrap_or_else(|| Moments::new(self.scene.camera.resolution));
        progress.skip(STEPS_A_PASS * u64::from(moments.passes.min(self.passes)));
        if moments.passes >= self.passes {
            return Ok((moments, note));
        }
        let [path, _] = found;
        Ok((self.go_on(moments, &path, progress)?, note))
    }

    fn go_on(&self, mut moments: Moments, path: &Path, progress: &dyn Progress) -> Result<Moments, StudyError> {
        let world = World::new(self.scene.clone())?;
        let whole = PixelBounds::whole(world.scene.camera.resolution);
        let missing = self.passes - moments.passes;
        progress.phase(&format!("reference {}", self.label), STEPS_A_PASS * u64::from(missing));
        let mut saved = Instant::now();
        for pass in moments.passes..self.passes {
            let mut state = RenderState::new(&world, whole, pass);
            go_on(&world, &mut state, &Unattended(&Silent), |state| state.film.passes() == 0)?;
            moments.add(&layer(&state.film.resolve(), &self.layer));
            progress.advance(STEPS_A_PASS);
            if saved.elapsed() > SAVE_EVERY && moments.passes > 1 {
                self.write(path, &moments)?;
                saved = Instant::now();
            }
        }
        self.write(path, &moments)?;
        progress.finish();
        Ok(moments)
    }

    fn write(&self, path: &Path, moments: &Moments) -> Result<(), StudyError> {
        let attributes = [
            ("sceneHash", self.scene.hash.clone()),
            ("passes", moments.passes.to_string()),
            ("layer", self.layer.clone()),
            ("program", program()),
        ]
        .map(|(name, value)| (name.to_owned(), value));
        write_pictures(path, &moments.image(), self.white, &attributes)
    }

    /// The part in a file; `None` where there is no file.
    fn read(&self, path: &Path) -> Result<Option<Moments>, StudyError> {
        if !path.exists() {
            return Ok(None);
        }
        let file = exr::read_file(path)?;
        let refused = |reason: String| StudyError::ReferenceRefused { path: path.to_owned(), reason };
        let attribute = |name: &str| {
            let mine = |(key, _): &&(String, String)| key.strip_prefix("pdembree/") == Some(name);
            file.attributes.iter().find(mine).map(|(_, value)| value.as_str())
        };
        match attribute("sceneHash") {
            Some(hash) if hash == self.scene.hash => {}
            Some(_) => return Err(refused("this reference was made from another scene or other settings".to_owned())),
            None => return Err(refused("this is no reference: its header does not name a scene".to_owned())),
        }
        let size = [file.image.width, file.image.height];
        let passes = attribute("passes").and_then(|passes| passes.parse().ok()).filter(|&passes: &u32| passes > 1);
        let moments = passes.and_then(|passes| Moments::from_image(&file.image, passes));
        match moments {
            Some(moments) if size == self.scene.camera.resolution => Ok(Some(moments)),
            _ => Err(refused("this reference is not whole: passes, variance or size are missing".to_owned())),
        }
    }

    /// A word on references of the same name that belong to another scene.
    fn note_on_others(&self, shelf: &Shelf) -> Option<String> {
        let prefix = format!("{}-", self.label);
        let ours = |path: &PathBuf| {
            path.extension().is_some_and(|ending| ending == "exr")
                && path.file_stem().is_some_and(|stem| stem.to_string_lossy().starts_with(&prefix))
        };
        let others: Vec<String> = [shelf.own, shelf.published]
            .into_iter()
            .filter_map(|folder| std::fs::read_dir(folder).ok())
            .flat_map(|entries| entries.filter_map(Result::ok).map(|entry| entry.path()).filter(ours))
            .map(|path| path.display().to_string())
            .collect();
        let refused = "was made from another scene or other settings and is not used";
        (!others.is_empty()).then(|| format!("{} {refused}", others.join(", ")))
    }
}

/// Mean over passes and the squared deviations from it, for each pixel and colour.
struct Moments {
    width: u32,
    height: u32,
    passes: u32,
    mean: Vec<[f64; 3]>,
    /// Variance of the mean.
    variance: Vec<[f64; 3]>,
}

impl Moments {
    fn new([width, height]: [u32; 2]) -> Moments {
        let pixels = width as usize * height as usize;
        Moments { width, height, passes: 0, mean: vec![[0.0; 3]; pixels], variance: vec![[0.0; 3]; pixels] }
    }

    /// One more pass `[Welford62]`: with the variance V of a mean of n in place of the sum of squares n (n − 1) V.
    fn add(&mut self, image: &Image) {
        let n = f64::from(self.passes);
        let Some(rgb) = image.rgb("") else { return };
        for (i, (mean, variance)) in self.mean.iter_mut().zip(&mut self.variance).enumerate() {
            for c in 0..3 {
                let delta = f64::from(rgb[c][i]) - mean[c];
                mean[c] += delta / (n + 1.0);
                if n > 0.0 {
                    let squares = variance[c] * n * (n - 1.0) + delta * delta * n / (n + 1.0);
                    variance[c] = squares / (n * (n + 1.0));
                }
            }
        }
        self.passes += 1;
    }

    /// The sum of independent parts.
    fn plus(mut self, other: &Moments) -> Moments {
        let add = |a: &mut Vec<[f64; 3]>, b: &Vec<[f64; 3]>| {
            a.iter_mut().zip(b).for_each(|(a, b)| a.iter_mut().zip(b).for_each(|(a, b)| *a += b));
        };
        add(&mut self.mean, &other.mean);
        add(&mut self.variance, &other.variance);
        self
    }

    fn mean_image(&self) -> Image {
        let pixels: Vec<[f32; 3]> = self.mean.iter().map(|rgb| rgb.map(|v| v as f32)).collect();
        Image::from_rgb(self.width, self.height, &pixels)
    }

    fn standard_errors(&self) -> Vec<[f64; 3]> {
        self.variance.iter().map(|rgb| rgb.map(f64::sqrt)).collect()
    }

    /// The mean, and the variance as a layer.
    fn image(&self) -> Image {
        let mut image = self.mean_image();
        for (c, name) in ["variance.R", "variance.G", "variance.B"].into_iter().enumerate() {
            let samples = self.variance.iter().map(|rgb| rgb[c] as f32).collect();
            image.channels.push(Channel { name: name.to_owned(), samples });
        }
        image
    }

    fn from_image(image: &Image, passes: u32) -> Option<Moments> {
        let (mean, variance) = (image.rgb("")?, image.rgb("variance")?);
        let interleave = |rgb: [&[f32]; 3]| (0..image.pixels()).map(|i| rgb.map(|c| f64::from(c[i]))).collect();
        let (mean, variance) = (interleave(mean), interleave(variance));
        Some(Moments { width: image.width, height: image.height, passes, mean, variance })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(value: f32) -> Image {
        Image::from_rgb(1, 1, &[[value, 2.0 * value, 0.0]])
    }

    /// Against the textbook's two-pass formulas, also when a file of f32 lies between the passes.
    #[test]
    fn moments_are_those_of_all_passes() {
        let values = [1.0f32, 4.0, 2.0, 8.0, 5.0];
        let mut moments = Moments::new([1, 1]);
        for (i, &v) in values.iter().enumerate() {
            if i == 3 {
                moments = Moments::from_image(&moments.image(), moments.passes).expect("a whole picture");
            }
            moments.add(&grey(v));
        }
        let mean = values.iter().sum::<f32>() / 5.0;
        let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / 4.0 / 5.0;
        assert!((moments.mean[0][0] - f64::from(mean)).abs() < 1e-6);
        assert!((moments.variance[0][0] - f64::from(variance)).abs() < 1e-6);
        assert!((moments.variance[0][1] - 4.0 * f64::from(variance)).abs() < 1e-5);
        assert_eq!(moments.variance[0][2], 0.0);
        assert_eq!(moments.passes, 5);
    }
}
