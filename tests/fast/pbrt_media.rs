//! Media of pbrt files: what fills shapes, where a grid's samples lie, and what is refused.

use std::path::Path;

use pdembree::import::imported::Imported;
use pdembree::import::pbrt::parse;
use pdembree::math::Point3;
use pdembree::scene::description::{InteriorDescription, MaterialModel};

fn world(text: &str) -> Imported {
    let text = format!("WorldBegin\n{text}");
    parse(Path::new("t.pbrt"), &text, false).unwrap_or_else(|problems| panic!("{problems}\n{text}"))
}

fn refused(text: &str) -> String {
    match parse(Path::new("t.pbrt"), text, false) {
        Ok(_) => panic!("it is read: {text}"),
        Err(problems) => problems.to_string(),
    }
}

/// The model of object `i`, and what is inside.
fn filled(scene: &Imported, i: usize) -> (MaterialModel, Option<&InteriorDescription>) {
    let name = &scene.objects[i].material.name;
    let material = scene.materials.iter().find(|m| m.name == *name).expect("a material");
    (material.model, material.interior.as_ref())
}

const FOG: &str = "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [0.1 0.2 0.3]
    \"rgb sigma_s\" [1 2 3] \"float scale\" 2 \"float g\" 0.5\n";

/// Glass around fog, fog within nothing, and a matte ball, which nothing gets into; outside of the interface all is as before.
#[test]
fn shapes_are_filled_with_what_is_inside_of_them() {
    let scene = world(&format!(
        "{FOG} AttributeBegin MediumInterface \"fog\" \"\" Material \"dielectric\" Shape \"sphere\"
         Material \"interface\" Shape \"sphere\" Material \"diffuse\" Shape \"sphere\" AttributeEnd
         Material \"dielectric\" Shape \"sphere\" Material \"interface\" Shape \"sphere\""
    ));
    assert_eq!(scene.objects.len(), 4);
    let [medium] = &scene.media[..] else { panic!("one medium") };
    assert_eq!((medium.name.as_str(), medium.g, &medium.density), ("fog", 0.5, &None));
    assert_eq!((medium.sigma_a, medium.sigma_s), ([0.2, 0.4, 0.6], [2.0, 4.0, 6.0]));
    let name =
        |i: usize| filled(&scene, i).1.and_then(|inside| inside.medium.as_ref()).map(|medium| medium.name.as_str());
    assert_eq!([0, 1, 2, 3].map(name), [Some("fog"), Some("fog"), None, None]);
    assert!(matches!(filled(&scene, 0).0, MaterialModel::Dielectric { .. }));
    assert_eq!(filled(&scene, 1).0, MaterialModel::Interface);
    assert!(matches!(filled(&scene, 2).0, MaterialModel::Lambert { .. }));
}

/// A shape around a hole in fog keeps the fog out.
#[test]
fn shapes_within_a_medium_may_hold_nothing() {
    let scene = world(&format!(
        "{FOG} Material \"interface\" MediumInterface \"fog\" \"\" Shape \"sphere\" \"float radius\" 3
         Material \"dielectric\" MediumInterface \"\" \"fog\" Shape \"sphere\""
    ));
    assert_eq!(filled(&scene, 1).1, Some(&InteriorDescription { medium: None, priority: 0 }));
}

/// pbrt's coordinates are left-handed: x is turned over. At a sample's place is its density, between two the mean, and in the
/// outermost half cells it falls towards zero.
#[test]
fn a_grid_lies_where_its_transform_puts_it() {
    let scene = world(
        "Translate 10 0 0 Scale 2 1 1
         MakeNamedMedium \"smoke\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"integer ny\" 1 \"integer nz\" 1
         \"float density\" [1 3] \"point3 p0\" [0 0 0] \"point3 p1\" [2 1 1]
         Material \"interface\" MediumInterface \"smoke\" \"\" Shape \"sphere\"",
    );
    let grid = scene.media[0].density.as_ref().expect("a grid");
    let at = |x: f64| grid.at(Point3::new(-(10.0 + 2.0 * x), 0.5, 0.5));
    for (x, expected) in [(0.5, 1.0), (1.0, 2.0), (1.5, 3.0), (0.25, 0.75), (1.75, 2.25)] {
        assert!((at(x) - expected).abs() < 1e-12, "{x}: {}, not {expected}", at(x));
    }
    assert_eq!(scene.media[0].sigma_s, [2.55, 3.21, 3.77]);
}

#[test]
fn media_that_cannot_be_rendered_are_named() {
    let shape = "Material \"interface\" MediumInterface \"m\" \"\" Shape \"sphere\"";
    let medium = |rest: &str| format!("WorldBegin MakeNamedMedium \"m\" {rest} {shape}");
    for (text, expected) in [
        (medium("\"string type\" \"cloud\""), "media of the type \"cloud\" cannot be rendered"),
        (medium("\"string type\" \"homogeneous\" \"string preset\" \"Skin1\""), "by the name of a substance"),
        (medium("\"string type\" \"homogeneous\" \"rgb Le\" [0 1 0]"), "media that glow (`Le`)"),
        (medium("\"string type\" \"homogeneous\" \"float g\" 1"), "the mean cosine `g` is 1"),
        (medium("\"string type\" \"homogeneous\" \"float sigma\" 1"), "`sigma` is no parameter"),
        (
            medium("\"string type\" \"uniformgrid\" \"float density\" [1 2]"),
            "`density` has 2 numbers, not nx ny nz = 1",
        ),
        (
            medium("\"string type\" \"uniformgrid\" \"float density\" 1 \"point3 p1\" [0 1 1]"),
            "the box of a medium has no inside",
        ),
        (format!("WorldBegin {shape}"), "there is no medium \"m\" (define it by MakeNamedMedium)"),
        (
            format!("WorldBegin {FOG} MediumInterface \"\" \"fog\" Shape \"sphere\""),
            "the medium \"fog\" around shapes cannot be rendered: it fills none",
        ),
        (
            format!("{FOG} MediumInterface \"\" \"fog\" Camera \"perspective\" WorldBegin"),
            "a medium around the camera cannot be rendered",
        ),
        (
            format!("WorldBegin {FOG} MediumInterface \"fog\" \"\" ReverseOrientation Shape \"sphere\""),
            "turned inside out cannot be the boundary of a medium",
        ),
    ] {
        let problems = refused(&text);
        assert!(problems.contains(expected), "{text}\n{problems}");
    }
}
