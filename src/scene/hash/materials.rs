//! Materials and their images, by content.

use super::{Canonical, earlier};
use crate::math::{Point3, Vec3};
use crate::scene::density::DensityGrid;
use crate::scene::description::{
    CoatDescription, InteriorDescription, MaterialModel, MediumDescription, NormalMapDescription, Parameter, Reference,
    SceneDescription, SpecularDescription,
};
use crate::scene::texture::{ImageTexture, Placement, Wrap};

impl Canonical {
    /// Only where there is one, so that other scenes keep the digest they had before there were media.
    pub(super) fn interior(&mut self, interior: &InteriorDescription, description: &SceneDescription) {
        self.tag("interior");
        self.integer(interior.priority.into());
        match &interior.medium {
            None => self.tag("no medium"),
            Some(medium) => self.medium_named(medium, description),
        }
    }

    /// A medium by content.
    pub(super) fn medium_named(&mut self, medium: &Reference, description: &SceneDescription) {
        match description.media.iter().find(|m| m.name == medium.name) {
            None => self.tag("unknown medium"),
            Some(MediumDescription { sigma_a, sigma_s, g, density, .. }) => {
                self.tag("medium");
                self.numbers([*sigma_a, *sigma_s].as_flattened());
                self.numbers(&[*g]);
                if let Some(grid) = density {
                    self.density(grid);
                }
            }
        }
    }

    fn density(&mut self, grid: &DensityGrid) {
        let DensityGrid { place, counts, samples, between } = grid;
        self.tag("density");
        self.tag(between.name());
        for count in counts {
            self.count(*count);
        }
        self.singles(&samples.iter().map(|s| [*s; 1]).collect::<Vec<_>>());
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|p| place.point(Point3::from_vec(p)).to_array());
        self.numbers(corners.as_flattened());
    }

    pub(super) fn material(&mut self, material: &MaterialModel, description: &SceneDescription) {
        match *material {
            MaterialModel::Lambert { albedo } => {
                self.tag("lambert");
                self.colour(albedo, description);
            }
            MaterialModel::Mirror { reflectance } => {
                self.tag("mirror");
                self.colour(reflectance, description);
            }
            MaterialModel::Dielectric { ior, exterior, fresnel } => {
                self.tag("dielectric");
                self.numbers(&[ior, exterior]);
                self.integer(fresnel.into());
            }
            MaterialModel::Interface => self.tag("interface"),
            MaterialModel::Conductor { eta, k } => {
                self.tag("conductor");
                self.numbers([eta, k].as_flattened());
            }
            MaterialModel::RoughDielectric { ior, exterior, roughness } => {
                self.tag("rough_dielectric");
                self.numbers(&[ior, exterior]);
                self.number(roughness, description);
            }
            MaterialModel::RoughConductor { eta, k, roughness } => {
                self.tag("rough_conductor");
                self.numbers([eta, k].as_flattened());
                self.number(roughness, description);
            }
            MaterialModel::Plastic { albedo, ior } => {
                self.tag("plastic");
                self.numbers(&[ior]);
                self.colour(albedo, description);
            }
            MaterialModel::Principled {
                base_colour,
                metalness,
                roughness,
                transmission,
                coverage,
                ior,
                thin,
                normal,
                specular,
                coat,
            } => {
                self.tag("principled");
                self.numbers(&[ior]);
                self.integer(thin.into());
                self.colour(base_colour, description);
                for number in [metalness, roughness, transmission, coverage] {
                    self.number(number, description);
                }
                if let Some(NormalMapDescription { texture, scale }) = normal {
                    self.tag("normal");
                    self.numbers(&[scale]);
                    self.texture(texture, description);
                }
                // As the normal map, only where there are.
                if let Some(SpecularDescription { weight, colour }) = specular {
                    self.tag("specular");
                    self.number(weight, description);
                    self.colour(colour, description);
                }
                if let Some(CoatDescription { weight, roughness, ior }) = coat {
                    self.tag("coat");
                    self.numbers(&[ior]);
                    self.number(weight, description);
                    self.number(roughness, description);
                }
            }
        }
    }

    fn colour(&mut self, parameter: Parameter<[f64; 3]>, description: &SceneDescription) {
        match parameter {
            Parameter::Constant(value) => {
                self.tag("constant");
                self.numbers(&value);
            }
            Parameter::Image { texture, factor } => {
                self.numbers(&factor);
                self.texture(texture, description);
            }
        }
    }

    fn number(&mut self, parameter: Parameter<f64>, description: &SceneDescription) {
        let triple = match parameter {
            Parameter::Constant(value) => Parameter::Constant([value; 3]),
            Parameter::Image { texture, factor } => Parameter::Image { texture, factor: [factor; 3] },
        };
        self.colour(triple, description);
    }

    fn texture(&mut self, index: usize, description: &SceneDescription) {
        let Some(texture) = description.textures.get(index) else { return self.tag("no image") };
        if let Some(place) = earlier(&mut self.textures, index) {
            self.tag("image again");
            return self.count(place);
        }
        let ImageTexture { texels, wrap: [across, up], placement } = &texture.image;
        self.tag("image");
        self.count(texels.width());
        self.count(texels.height());
        self.texels(texels);
        self.tag(wrap_name(*across));
        // Only where they are set, as with settings.
        if up != across {
            self.tag("up");
            self.tag(wrap_name(*up));
        }
        if *placement != Placement::IDENTITY {
            self.tag("placed");
            self.numbers(placement.rows.as_flattened());
        }
    }
}

fn wrap_name(wrap: Wrap) -> &'static str {
    match wrap {
        Wrap::Repeat => "repeat",
        Wrap::Clamp => "clamp",
        Wrap::Mirror => "mirror",
    }
}
