//! Which light belongs to which group, and whether the groups that layers name are there.

use super::Report;
use crate::scene::description::SceneDescription;
use crate::scene::error::Problem;
use crate::scene::light::LightSource;
use crate::scene::light_group::{DEFAULT, EVERY, GroupLayer, LightGroups};
use crate::scene::object::Object;
use crate::scene::spelling::nearest;

/// Puts the scene's groups in the place of `*` in its settings' layers, and tells the groups of its lights, those that are
/// objects behind the others; `described` says of these which of the description's each is.
pub(super) fn assemble(
    description: &mut SceneDescription,
    (lights, described): (&[LightSource], &[usize]),
    objects: &[Object],
    report: &mut Report,
) -> LightGroups {
    let of_light = names(description, (lights, described), objects);
    let mut known: Vec<&str> = of_light.iter().map(String::as_str).collect();
    known.sort_unstable();
    known.dedup();
    let mut layers: Vec<GroupLayer> = Vec::new();
    for layer in &description.settings.group_layers {
        let groups = if layer.group == EVERY { known.clone() } else { vec![layer.group.as_str()] };
        for group in groups {
            let layer = GroupLayer { of: layer.of, group: group.to_owned() };
            if !layers.contains(&layer) {
                layers.push(layer);
            }
        }
    }
    for layer in layers.iter().filter(|layer| !known.contains(&layer.group.as_str())) {
        let help = match nearest(&layer.group, &known) {
            Some(near) => format!("did you mean `{}_{near}`?", layer.of.name()),
            None => format!("lights belong to one with group = \"{}\"; there are: {}", layer.group, known.join(", ")),
        };
        let problem = Problem::new(format!("layer `{}`: no light is in the group `{}`", layer.name(), layer.group));
        report.problem(problem.help(help).at(&description.settings_source));
    }
    let groups = LightGroups::new(&layers, of_light.iter().map(String::as_str));
    description.settings.group_layers = layers;
    groups
}

/// The names of the lights' groups. A scene whose lights are not all sound has none, and is reported elsewhere.
fn names(
    description: &SceneDescription,
    (lights, described): (&[LightSource], &[usize]),
    objects: &[Object],
) -> Vec<String> {
    let of = |group: Option<&str>| group.unwrap_or(DEFAULT).to_owned();
    let described = described.iter().map(|&i| of(description.lights[i].group.as_ref().map(|g| g.name.as_str())));
    let emitting = lights.iter().filter_map(|light| {
        let LightSource::Area { object, .. } = light else { return None };
        let name = &objects.get(object.index())?.name;
        let emission = description.objects.iter().find(|object| object.name == *name)?.emission.as_ref();
        Some(of(emission.and_then(|emission| emission.group.as_ref()).map(|g| g.name.as_str())))
    });
    described.chain(emitting).collect()
}
