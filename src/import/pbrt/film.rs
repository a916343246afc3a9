//! Camera, film, filter, sampler and integrator as a camera and settings.

use glam::{DMat3, DMat4};

use super::parameters::{Parameters, shortened};
use super::placing::{MIRROR, mirrors};
use crate::import::ignored::Ignored;
use crate::scene::camera::PixelFilter;
use crate::scene::description::{CameraDescription, CameraModelDescription};
use crate::scene::error::{Problem, Source};
use crate::scene::settings::{MAX_PHOTONS_PER_PASS, Method, RenderSettings};

/// Relative deviation of a camera's axes, by rounding of what is written, up to which they are perpendicular and as long as
/// each other.
const SIMILAR: f64 = 1e-4;
/// pbrt's own.
const USUAL_SAMPLES: u32 = 16;

/// What the directives before `WorldBegin` have said.
pub(super) struct Film {
    lens: Lens,
    camera_from_world: DMat4,
    camera_source: Source,
    pub has_camera: bool,
    resolution: [u32; 2],
    filter: PixelFilter,
    pub settings: RenderSettings,
}

#[derive(Clone, Copy)]
enum Projection {
    /// Degrees across the shorter side.
    Perspective(f64),
    Orthographic,
}

#[derive(Clone, Copy)]
struct Lens {
    projection: Projection,
    /// Width over height, where the film's is not meant.
    aspect: Option<f64>,
    /// x and y from, to; for ±1 along the shorter side.
    window: Option<[f64; 4]>,
    radius: f64,
    focal_distance: f64,
}

impl Film {
    /// pbrt's, at `source`.
    pub fn new(source: &Source) -> Film {
        let lens = Lens {
            projection: Projection::Perspective(90.0),
            aspect: None,
            window: None,
            radius: 0.0,
            focal_distance: 1e6,
        };
        Film {
            lens,
            camera_from_world: DMat4::IDENTITY,
            camera_source: source.clone(),
            has_camera: false,
            resolution: [1280, 720],
            filter: PixelFilter::Gaussian,
            settings: RenderSettings { spp: USUAL_SAMPLES, ..RenderSettings::default() },
        }
    }

    /// From pbrt's world to ours: turned over unless the camera does that.
    pub fn to_ours(&self) -> DMat4 {
        if mirrors(&self.camera_from_world) { DMat4::IDENTITY } else { MIRROR }
    }

    pub fn camera(
        &mut self,
        kind: &str,
        ps: &Parameters,
        camera_from_world: DMat4,
        ignored: &mut Ignored,
    ) -> Result<(), Problem> {
        let projection = match kind {
            "perspective" => {
                let fov = ps.number("fov", 90.0)?;
                if !(fov > 0.0 && fov < 180.0) {
                    return Err(ps.problem(format!("the camera's fov is {fov}"), "it must be above 0 and below 180"));
                }
                Projection::Perspective(fov)
            }
            "orthographic" => Projection::Orthographic,
            other => {
                let message = format!("the camera \"{}\" cannot be rendered", shortened(other));
                return Err(ps.cannot(message, "perspective and orthographic can"));
            }
        };
        let window = match ps.find("screenwindow") {
            None => None,
            Some(p) => match p.tuples::<4>(&["float"])? {
                [window] => Some(*window),
                _ => return Err(p.problem("`screenwindow` is no window", "give x and y from, to: four numbers")),
            },
        };
        let aspect = ps.has("frameaspectratio").then(|| ps.positive("frameaspectratio", 1.0)).transpose()?;
        let radius = ps.number("lensradius", 0.0)?;
        if radius > 0.0 && matches!(projection, Projection::Orthographic) {
            return Err(ps.cannot("an orthographic camera with a lens cannot be rendered", "leave out `lensradius`"));
        }
        let shutter = [ps.number("shutteropen", 0.0)?, ps.number("shutterclose", 1.0)?];
        // What stands still is the same at any time; only the brightness of pbrt's film depends on it.
        ignored.note_if(shutter[1] - shutter[0] != 1.0, "the shutter's time (as of 1 s)");
        self.lens = Lens { projection, aspect, window, radius, focal_distance: ps.positive("focaldistance", 1e6)? };
        self.camera_from_world = camera_from_world;
        self.camera_source = ps.source.clone();
        self.has_camera = true;
        Ok(())
    }

    pub fn film(&mut self, kind: &str, ps: &Parameters, ignored: &mut Ignored) -> Result<(), Problem> {
        if !["rgb", "gbuffer", "spectral"].contains(&kind) {
            let message = format!("there is no film \"{}\"", shortened(kind));
            return Err(ps.problem(message, "films are rgb, gbuffer and spectral; `pbrt --upgrade` turns older files"));
        }
        let side = |name, default| ps.integer(name, 1..=65_536, default);
        self.resolution = [side("xresolution", 1280)? as u32, side("yresolution", 720)? as u32];
        ignored.note_if(ps.has("cropwindow") || ps.has("pixelbounds"), "the film's crop window");
        ignored.note_if(ps.number("iso", 100.0)? != 100.0, "the film's iso (as of 100)");
        ignored.note_if(ps.has("sensor") || ps.has("whitebalance"), "the film's sensor");
        ps.ignore(&["filename", "savefp16", "diagonal", "maxcomponentvalue", "exposuretime", "coordinatesystem"]);
        ps.ignore(&["nbuckets", "lambdamin", "lambdamax"]);
        Ok(())
    }

    pub fn filter(&mut self, kind: &str, ps: &Parameters, ignored: &mut Ignored) -> Result<(), Problem> {
        let radius = if kind == "box" { 0.5 } else { 1.5 };
        let given = [ps.number("xradius", radius)?, ps.number("yradius", radius)?, ps.number("sigma", 0.5)?];
        ps.ignore(&["B", "C", "tau"]);
        self.filter = if kind == "box" { PixelFilter::Box } else { PixelFilter::Gaussian };
        match kind {
            "box" | "gaussian" => ignored.note_if(given != [radius, radius, 0.5], "the size of the pixel filter"),
            "mitchell" | "sinc" | "triangle" => ignored.note(format!("the {kind} filter (gaussian is taken)")),
            other => {
                let message = format!("there is no filter \"{}\"", shortened(other));
                return Err(ps.problem(message, "filters are box, gaussian, mitchell, sinc and triangle"));
            }
        }
        Ok(())
    }

    pub fn sampler(&mut self, kind: &str, ps: &Parameters) -> Result<(), Problem> {
        let count = |name, default| ps.integer(name, 1..=1_000_000, default);
        let samples = match kind {
            "stratified" => count("xsamples", 4)? * count("ysamples", 4)?,
            "independent" | "halton" | "sobol" | "paddedsobol" | "zsobol" | "pmj02bn" => count("pixelsamples", 16)?,
            other => {
                let message = format!("there is no sampler \"{}\"", shortened(other));
                let help = "samplers are independent, stratified, halton, sobol, paddedsobol, zsobol and pmj02bn";
                return Err(ps.problem(message, help));
            }
        };
        self.settings.spp = samples.min(1_000_000) as u32;
        self.settings.seed = ps.integer("seed", 0..=i64::from(i32::MAX), 0)? as u64;
        // How samples are spread has no counterpart here.
        ps.ignore(&["randomization", "jitter"]);
        Ok(())
    }

    pub fn integrator(&mut self, kind: &str, ps: &Parameters) -> Result<(), Problem> {
        const NAMES: [&str; 11] = [
            "volpath",
            "path",
            "bdpt",
            "mlt",
            "sppm",
            "lightpath",
            "simplepath",
            "simplevolpath",
            "randomwalk",
            "ambientocclusion",
            "function",
        ];
        if !NAMES.contains(&kind) {
            let message = format!("there is no integrator \"{}\"", shortened(kind));
            return Err(ps.problem(message, format!("integrators are {}", NAMES.join(", "))));
        }
        if kind == "lightpath" {
            self.settings.method = Method::LightTrace;
        }
        if ps.has("maxdepth") {
            // pbrt counts bounces: 1 is light straight from lamps, over two edges.
            let bounces = ps.integer("maxdepth", 0..=65_534, 5)? as u32;
            self.settings.max_depth = bounces + 1;
            self.settings.max_bounces = bounces.saturating_sub(1);
        }
        let photons = ps.integer("photonsperiteration", -1..=MAX_PHOTONS_PER_PASS as i64, -1)?;
        if photons > 0 {
            self.settings.photons = photons as u64;
        }
        ps.ignore(&[
            "regularize",
            "lightsampler",
            "radius",
            "seed",
            "samplebsdf",
            "samplelights",
            "visualizestrategies",
        ]);
        ps.ignore(&["visualizeweights", "bootstrapsamples", "chains", "mutationsperpixel", "sigma", "maxdistance"]);
        ps.ignore(&["cossample", "function", "largestepprobability", "iterations"]);
        Ok(())
    }

    pub fn describe(&self) -> Result<CameraDescription, Problem> {
        let refuse = |message: &str, help: &str| Problem::new(message).help(help).at(&self.camera_source);
        let ours_from_camera = self.to_ours() * self.camera_from_world.inverse();
        let axes = DMat3::from_mat4(ours_from_camera);
        let scale = axes.x_axis.length();
        let gram = axes.transpose() * axes;
        let deviation = (gram - DMat3::from_diagonal(glam::DVec3::splat(scale * scale))).to_cols_array();
        let similar = deviation.iter().all(|x| x.abs() <= SIMILAR * scale * scale);
        if !(scale > 0.0 && scale.is_finite() && similar) {
            return Err(refuse("the camera's transform stretches or flattens the picture", "scale all axes alike"));
        }
        let [x_half, y_half] = self.half_window().map_err(|message| refuse(message, "make it the film's, centred"))?;
        let [width, height] = self.resolution.map(f64::from);
        if (x_half * height - y_half * width).abs() > 0.01 * x_half * height {
            return Err(refuse("pixels that are not square cannot be rendered", "let the window agree with the film"));
        }
        let model = match self.lens.projection {
            Projection::Orthographic => CameraModelDescription::Orthographic { width: 2.0 * x_half * scale },
            Projection::Perspective(fov) => {
                let fov_degrees = 2.0 * ((0.5 * fov.to_radians()).tan() * x_half).atan().to_degrees();
                match self.lens.radius {
                    radius if radius > 0.0 => CameraModelDescription::ThinLens {
                        fov_degrees,
                        lens_radius: radius * scale,
                        focus_distance: self.lens.focal_distance * scale,
                    },
                    _ => CameraModelDescription::Perspective { fov_degrees },
                }
            }
        };
        let position = ours_from_camera.w_axis.truncate();
        let ahead = axes.z_axis / scale;
        Ok(CameraDescription {
            source: self.camera_source.clone(),
            model,
            position: position.to_array(),
            target: (position + ahead).to_array(),
            up: (axes.y_axis / scale).to_array(),
            resolution: self.resolution,
            filter: self.filter,
            shutter: None,
            motion: Vec::new(),
        })
    }

    /// Half of the window's width and height, the shorter being 1 unless the file says otherwise.
    fn half_window(&self) -> Result<[f64; 2], &'static str> {
        if let Some([x0, x1, y0, y1]) = self.lens.window {
            let centred = |a: f64, b: f64| (a + b).abs() <= SIMILAR * (b - a) && b > a;
            let both = centred(x0, x1) && centred(y0, y1);
            return both.then_some([0.5 * (x1 - x0), 0.5 * (y1 - y0)]).ok_or("a `screenwindow` that is not centred");
        }
        let [width, height] = self.resolution.map(f64::from);
        let aspect = self.lens.aspect.unwrap_or(width / height);
        Ok(if aspect > 1.0 { [aspect, 1.0] } else { [1.0, 1.0 / aspect] })
    }
}
