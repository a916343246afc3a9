//! More lights than a table chooses from: eye paths that look at the near ones find what paths from all lights bring.

use crate::agreement::{LIGHT, PATH, Settings, assert_blocks_agree, means, pictures};

/// Three matte walls, and lights of every kind that stands somewhere, some with their backs to a wall, beside a faint sky.
/// An eye path that runs into a disk or a ball is weighted by the chance that it would have been chosen with.
fn crowded_corner() -> String {
    let mut scene = String::from(
        r#"
format = 1
[camera]
type = "perspective"
position = [3, 3, 3]
target = [0, 0.4, 0]
fov_degrees = 20
resolution = [16, 16]
[render]
max_bounces = 1
[materials.white]
type = "lambert"
albedo = 0.7
[[objects]]
shape = "rectangle"
centre = [1, 0, 1]
a = [0, 0, 1]
b = [1, 0, 0]
material = "white"
[[objects]]
shape = "rectangle"
centre = [0, 1, 1]
a = [0, 1, 0]
b = [0, 0, 1]
material = "white"
[[objects]]
shape = "rectangle"
centre = [1, 1, 0]
a = [1, 0, 0]
b = [0, 1, 0]
material = "white"
[[lights]]
type = "environment"
radiance = 0.05
"#,
    );
    for i in 0..4 {
        let at = 0.4 + 0.4 * f64::from(i);
        scene += &format!(
            r#"
[[objects]]
shape = "disk"
centre = [{at}, 1.8, 0.9]
normal = [{at}, -1, 0.3]
radius = 0.1
material = "white"
emission = 12
two_sided = {}
[[objects]]
shape = "sphere"
centre = [0.9, 1.7, {at}]
radius = 0.08
material = "white"
emission = [9, 3, 2]
[[lights]]
type = "point"
position = [0.3, {at}, 1.9]
intensity = [0.05, 0.1, 0.3]
[[lights]]
type = "spot"
position = [1.9, 1.9, {at}]
target = [0, 0.3, 0.4]
angle_degrees = 25
penumbra_degrees = 10
intensity = 1
"#,
            i % 2 == 0,
        );
    }
    scene
}

/// The faults that this is for, a chance of zero or one that the weights do not know, move blocks by tens of per cents; the
/// means of blocks are known to about one, and to some where a lamp is near.
#[test]
fn eye_paths_and_light_paths_agree_under_many_lights() {
    let scene = crowded_corner();
    let both = [pictures(&scene, &Settings { spp: 64, ..PATH }), pictures(&scene, &LIGHT)];
    for layer in ["direct", "indirect"] {
        println!("{layer} {}", means(&both, layer));
        assert!(assert_blocks_agree(&both, layer, 4) > 0.01);
    }
}
