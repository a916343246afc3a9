//! A digest of everything in a description that can change a pixel: contents of meshes and images included, names,
//! paths, the order of materials and the choice of layers not.

mod materials;

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::artistic::PhotonChoice;
use super::camera::PixelFilter;
use super::description::{
    CameraDescription, CameraModelDescription, ExtentDescription, LightDescription, LightModel, MotionKey,
    ObjectDescription, Reference, SceneDescription, ShapeDescription, TransformMap, TransformStep,
};
use super::mesh::TriangleMesh;
use super::panorama::{Panorama, Projection};
use super::settings::{
    BackendKind, Bandwidth, BounceFootprint, Caustics, Guiding, Indirect, Radius, RenderSettings, TimeKernel,
    TimeResolution,
};
use super::texture::Texels;

/// Changes when the serialisation below does.
const VERSION: &str = "pdembree scene 1";

/// BLAKE3 over a canonical serialisation, 64 hexadecimal digits.
pub fn digest(description: &SceneDescription) -> String {
    digest_with(description, &description.settings)
}

/// The same of what is in the scene, however it is rendered.
pub fn digest_of_contents(description: &SceneDescription) -> String {
    digest_with(description, &RenderSettings { backend: BackendKind::Brute, ..RenderSettings::default() })
}

fn digest_with(description: &SceneDescription, settings: &RenderSettings) -> String {
    let mut out = Canonical::default();
    out.tag(VERSION);
    if let Some(camera) = &description.camera {
        out.camera(camera);
    }
    out.settings(settings);
    out.count(description.objects.len());
    for object in &description.objects {
        out.object(object, description);
    }
    out.count(description.lights.len());
    for light in &description.lights {
        out.light(light);
    }
    if let Some(atmosphere) = &description.atmosphere {
        out.tag("atmosphere");
        out.medium_named(atmosphere, description);
    }
    out.hasher.finalize().to_hex().to_string()
}

/// Writes values one after the other; lengths go before lists and tags before alternatives, so nothing is ambiguous.
#[derive(Default)]
struct Canonical {
    hasher: blake3::Hasher,
    /// What has been written in full: its index in the description, and how many of its kind were before it. Contents
    /// that many objects share are referred to from then on: an instance costs its transform and not its mesh.
    meshes: HashMap<usize, usize>,
    textures: HashMap<usize, usize>,
}

/// The place of `index` among those written in full; where it has none yet, it gets one.
fn earlier(written: &mut HashMap<usize, usize>, index: usize) -> Option<usize> {
    let next = written.len();
    match written.entry(index) {
        Entry::Occupied(place) => Some(*place.get()),
        Entry::Vacant(free) => {
            free.insert(next);
            None
        }
    }
}

impl Canonical {
    fn bytes(&mut self, bytes: &[u8]) {
        self.hasher.update(bytes);
    }
    fn integer(&mut self, value: u64) {
        self.bytes(&value.to_le_bytes());
    }
    fn count(&mut self, value: usize) {
        self.integer(value as u64);
    }
    fn tag(&mut self, tag: &str) {
        self.count(tag.len());
        self.bytes(tag.as_bytes());
    }
    fn numbers(&mut self, values: &[f64]) {
        for value in values {
            self.integer(value.to_bits());
        }
    }
    fn singles<const N: usize>(&mut self, values: &[[f32; N]]) {
        self.count(values.len());
        self.uncounted(values);
    }
    fn texels(&mut self, texels: &Texels) {
        self.count(texels.len());
        let mut rows = texels.rows();
        for j in 0..texels.height() {
            self.uncounted(rows.row(j));
        }
    }
    fn uncounted<const N: usize>(&mut self, values: &[[f32; N]]) {
        // In blocks: one call of the hasher a number would be slow for large meshes.
        for block in values.chunks(4096) {
            let bytes: Vec<u8> = block.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
            self.bytes(&bytes);
        }
    }

    fn camera(&mut self, camera: &CameraDescription) {
        match camera.model {
            CameraModelDescription::Perspective { fov_degrees } => {
                self.tag("perspective");
                self.numbers(&[fov_degrees]);
            }
            CameraModelDescription::Orthographic { width } => {
                self.tag("orthographic");
                self.numbers(&[width]);
            }
            CameraModelDescription::ThinLens { fov_degrees, lens_radius, focus_distance } => {
                self.tag("thin_lens");
                self.numbers(&[fov_degrees, lens_radius, focus_distance]);
            }
        }
        self.numbers([camera.position, camera.target, camera.up].as_flattened());
        for side in camera.resolution {
            self.integer(side.into());
        }
        self.tag(match camera.filter {
            PixelFilter::Box => "box",
            PixelFilter::Gaussian => "gaussian",
        });
        // Only where there are any, so that other scenes keep the digest they had before there were these.
        if let Some(shutter) = camera.shutter {
            self.tag("shutter");
            self.numbers(&shutter);
        }
        if !camera.motion.is_empty() {
            self.tag("camera motion");
            self.count(camera.motion.len());
            for key in &camera.motion {
                self.numbers(&[key.time]);
                self.numbers([key.position, key.target, key.up].as_flattened());
            }
        }
    }

    fn settings(&mut self, settings: &RenderSettings) {
        // Layers stand beside the picture and change none of its pixels; but those of groups of lights part its photons.
        let RenderSettings {
            method,
            backend,
            seed,
            passes,
            spp,
            photons,
            beams,
            media_estimator,
            beam_points,
            emission,
            guiding,
            estimator,
            footprint,
            caustics,
            indirect,
            bounce_footprint,
            kernel,
            bandwidth,
            k,
            radius,
            time_cells,
            time_kernel,
            max_depth,
            max_bounces,
            layers: _,
            group_layers,
        } = settings;
        for name in [method.name(), backend.name(), emission.name(), estimator.name(), footprint.name(), kernel.name()]
        {
            self.tag(name);
        }
        for value in [*seed, u64::from(*passes), u64::from(*spp), *photons, u64::from(*k)] {
            self.integer(value);
        }
        self.integer(u64::from(*max_depth));
        self.integer(u64::from(*max_bounces));
        match bandwidth {
            Bandwidth::Auto => self.tag("auto"),
            Bandwidth::Scale(s) => {
                self.tag("scale");
                self.numbers(&[*s]);
            }
        }
        // Only where they are set, so that other scenes keep the digest they had before there were these.
        if *guiding == Guiding::Off {
            self.tag("unguided");
        }
        if *caustics != Caustics::Shared {
            self.tag("caustics");
            self.tag(caustics.name());
        }
        if *indirect != Indirect::Path {
            self.tag(indirect.name());
        }
        if *bounce_footprint != BounceFootprint::Shared {
            self.tag("bounce");
            self.tag(bounce_footprint.name());
        }
        if let TimeResolution::Cells(count) = time_cells {
            self.tag("time cells");
            self.integer(u64::from(*count));
        }
        if *time_kernel != TimeKernel::Variance {
            self.tag("time kernel");
            self.tag(time_kernel.name());
        }
        if *beams != RenderSettings::default().beams {
            self.tag("beams");
            self.integer(*beams);
        }
        if *media_estimator != RenderSettings::default().media_estimator {
            self.tag(media_estimator.name());
        }
        if *beam_points != RenderSettings::default().beam_points {
            self.tag("beam points");
            self.integer(u64::from(*beam_points));
        }
        for layer in group_layers {
            self.tag(&layer.name());
        }
        if let Radius::Metres(radius) = radius {
            self.tag("radius");
            self.numbers(&[*radius]);
        }
    }

    fn object(&mut self, object: &ObjectDescription, description: &SceneDescription) {
        self.shape(&object.shape, description);
        self.steps(&object.transform);
        self.motion(&object.motion);
        match &object.emission {
            None => self.tag("dark"),
            Some(emission) => {
                self.tag("emits");
                self.numbers(&emission.radiance);
                self.integer(emission.two_sided.into());
                self.group(emission.group.as_ref());
                self.photons(emission.photons);
            }
        }
        // Only where something is left out, as with settings.
        for (left_out, tag) in [(!object.caustics.cast, "casts none"), (!object.caustics.receive, "receives none")] {
            if left_out {
                self.tag(tag);
            }
        }
        // By content, so that neither names nor the order of materials matter.
        match description.materials.iter().find(|m| m.name == object.material.name) {
            None => self.tag("no material"),
            Some(material) => {
                self.material(&material.model, description);
                if let Some(interior) = &material.interior {
                    self.interior(interior, description);
                }
            }
        }
    }

    fn motion(&mut self, keys: &[MotionKey]) {
        // Only where there are some, as with settings.
        if keys.is_empty() {
            return;
        }
        self.tag("motion");
        self.count(keys.len());
        for key in keys {
            self.numbers(&[key.time]);
            self.steps(&key.transform);
        }
    }

    fn steps(&mut self, steps: &[TransformStep]) {
        self.count(steps.len());
        for step in steps {
            match step.map {
                TransformMap::Translate(t) => {
                    self.tag("translate");
                    self.numbers(&t);
                }
                TransformMap::Rotate { axis, degrees } => {
                    self.tag("rotate");
                    self.numbers(&axis);
                    self.numbers(&[degrees]);
                }
                TransformMap::Scale(s) => {
                    self.tag("scale");
                    self.numbers(&s);
                }
                TransformMap::Matrix(rows) => {
                    self.tag("matrix");
                    self.numbers(rows.as_flattened());
                }
            }
        }
    }

    fn shape(&mut self, shape: &ShapeDescription, description: &SceneDescription) {
        match shape {
            ShapeDescription::Sphere { centre, radius } => {
                self.tag("sphere");
                self.numbers(centre);
                self.numbers(&[*radius]);
            }
            ShapeDescription::Cylinder { base, top, radius } => {
                self.tag("cylinder");
                self.numbers([*base, *top].as_flattened());
                self.numbers(&[*radius]);
            }
            ShapeDescription::Torus { centre, axis, major_radius, minor_radius } => {
                self.tag("torus");
                self.numbers([*centre, *axis].as_flattened());
                self.numbers(&[*major_radius, *minor_radius]);
            }
            ShapeDescription::Disk { centre, normal, radius } => {
                self.tag("disk");
                self.numbers([*centre, *normal].as_flattened());
                self.numbers(&[*radius]);
            }
            ShapeDescription::Rectangle { centre, a, b } => {
                self.tag("rectangle");
                self.numbers([*centre, *a, *b].as_flattened());
            }
            ShapeDescription::HeightField { centre, half_size, up, x_axis, waves } => {
                self.tag("height_field");
                self.numbers([*centre, *up, *x_axis].as_flattened());
                self.numbers(half_size);
                self.count(waves.len());
                for wave in waves {
                    self.numbers(&wave.wave_vector);
                    self.numbers(&[wave.amplitude, wave.phase]);
                    if wave.speed != 0.0 {
                        self.tag("travels");
                        self.numbers(&[wave.speed]);
                    }
                }
            }
            ShapeDescription::Mesh { mesh } => match mesh.and_then(|i| Some((i, description.meshes.get(i)?))) {
                None => self.tag("no mesh"),
                Some((index, mesh)) => self.mesh(index, &mesh.mesh),
            },
        }
    }

    fn mesh(&mut self, index: usize, mesh: &TriangleMesh) {
        if let Some(place) = earlier(&mut self.meshes, index) {
            self.tag("mesh again");
            return self.count(place);
        }
        self.tag("mesh");
        self.singles(&mesh.positions);
        self.singles(&mesh.normals);
        self.singles(&mesh.uvs);
        self.count(mesh.triangles.len());
        for block in mesh.triangles.chunks(4096) {
            let bytes: Vec<u8> = block.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect();
            self.bytes(&bytes);
        }
        // Only where there are some, as with settings.
        if !mesh.colours.is_empty() {
            self.tag("colours");
            self.singles(&mesh.colours);
        }
        if let Some(deformation) = &mesh.deformation {
            self.tag("frames");
            self.numbers(&[deformation.start, deformation.interval]);
            self.count(deformation.frames.len());
            for frame in &deformation.frames {
                self.singles(&frame.positions);
                self.singles(&frame.normals);
            }
        }
    }

    fn light(&mut self, light: &LightDescription) {
        match light.model {
            LightModel::Point { position, intensity } => {
                self.tag("point");
                self.numbers([position, intensity].as_flattened());
            }
            LightModel::Spot { position, target, intensity, angle_degrees, penumbra_degrees } => {
                self.tag("spot");
                self.numbers([position, target, intensity].as_flattened());
                self.numbers(&[angle_degrees, penumbra_degrees]);
            }
            LightModel::Directional { direction, irradiance, extent } => {
                self.tag("directional");
                self.numbers([direction, irradiance].as_flattened());
                match extent {
                    ExtentDescription::Unbounded => self.tag("unbounded"),
                    ExtentDescription::Rectangle { centre, a, b } => {
                        self.tag("rectangle");
                        self.numbers([centre, a, b].as_flattened());
                    }
                    ExtentDescription::Disk { centre, radius } => {
                        self.tag("disk");
                        self.numbers(&centre);
                        self.numbers(&[radius]);
                    }
                }
            }
            LightModel::Environment { radiance } => {
                self.tag("environment");
                self.numbers(&radiance);
            }
            LightModel::Panorama(ref panorama) => {
                // Its part is no part of a description.
                let Panorama { image, projection, axes, factor, part: _ } = panorama;
                self.tag(match projection {
                    Projection::LatLong => "lat-long panorama",
                    Projection::Octahedral => "octahedral panorama",
                });
                self.numbers(axes.map(|axis| axis.to_array()).as_flattened());
                self.numbers(&factor.to_array());
                self.count(image.texels.width());
                self.texels(&image.texels);
            }
        }
        self.group(light.group.as_ref());
        self.photons(light.photons);
        self.motion(&light.motion);
    }

    /// Only where something is chosen, as with settings.
    fn photons(&mut self, photons: PhotonChoice) {
        match photons {
            PhotonChoice::Auto => {}
            PhotonChoice::Off => self.tag("no photons"),
            PhotonChoice::Count(n) => {
                self.tag("photons");
                self.integer(n);
            }
        }
    }

    /// Only where there is one, as with settings.
    fn group(&mut self, group: Option<&Reference>) {
        if let Some(group) = group {
            self.tag("group");
            self.tag(&group.name);
        }
    }
}
