//! Transforms of pbrt as matrices · world = current matrix · object, columns as vectors, angles in degrees.

use glam::{DMat3, DMat4, DVec3};

use crate::scene::description::TransformMap;

/// Turns x over. A scene that pbrt sees in left-handed coordinates, x to the right, y up, z ahead, is here in right-handed
/// ones.
pub(super) const MIRROR: DMat4 = DMat4::from_cols_array(&[
    -1.0, 0.0, 0.0, 0.0, //
    0.0, 1.0, 0.0, 0.0, //
    0.0, 0.0, 1.0, 0.0, //
    0.0, 0.0, 0.0, 1.0,
]);

/// Camera from world: +z of the camera is what `look` − `eye` is, +y is on the side of `up`, +x is y × z. `None` where that
/// is no frame.
pub(super) fn look_at([eye, look, up]: [DVec3; 3]) -> Option<DMat4> {
    let ahead = (look - eye).try_normalize()?;
    let right = up.try_normalize()?.cross(ahead).try_normalize()?;
    let frame = DMat3::from_cols(right, ahead.cross(right), ahead);
    Some(DMat4::from_mat3(frame.transpose()) * DMat4::from_translation(-eye))
}

/// About `axis`, counter-clockwise where x, y, z are right-handed. `None` for an axis without length.
pub(super) fn rotation(degrees: f64, axis: DVec3) -> Option<DMat4> {
    Some(DMat4::from_axis_angle(axis.try_normalize()?, degrees.to_radians()))
}

/// Sixteen numbers, one column of the matrix behind the other. `None` where the last row is not 0 0 0 1.
pub(super) fn matrix(columns: &[f64; 16]) -> Option<DMat4> {
    let matrix = DMat4::from_cols_array(columns);
    (matrix.row(3).to_array() == [0.0, 0.0, 0.0, 1.0]).then_some(matrix)
}

/// Rows of [M | t].
pub(super) fn transform_map(to_world: &DMat4) -> TransformMap {
    let rows = to_world.transpose().to_cols_array_2d();
    TransformMap::Matrix([rows[0], rows[1], rows[2]])
}

/// Whether the map turns right-handed frames into left-handed ones.
pub(super) fn mirrors(map: &DMat4) -> bool {
    DMat3::from_mat4(*map).determinant() < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_sees_what_it_looks_at_ahead_and_up_above() {
        let (eye, look, up) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(4.0, 6.0, 3.0), DVec3::Z);
        let camera = look_at([eye, look, up]).expect("a frame");
        let close = |p: DVec3, q: DVec3| (p - q).length() < 1e-12;
        assert!(close(camera.transform_point3(eye), DVec3::ZERO));
        assert!(close(camera.transform_point3(look), 5.0 * DVec3::Z));
        assert!(close(camera.transform_vector3(DVec3::Z), DVec3::Y));
        // Left-handed: y × z.
        assert!(close(camera.transform_vector3(DVec3::Z.cross(DVec3::new(0.6, 0.8, 0.0))), DVec3::X));
        assert!(look_at([eye, eye, up]).is_none() && look_at([DVec3::ZERO, DVec3::Z, up]).is_none());
    }

    #[test]
    fn matrices_are_written_column_by_column() {
        let numbers = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 7.0, 8.0, 9.0, 1.0];
        assert_eq!(matrix(&numbers), Some(DMat4::from_translation(DVec3::new(7.0, 8.0, 9.0))));
        let mut projective = numbers;
        projective[3] = 0.5;
        assert_eq!(matrix(&projective), None);
        assert!(mirrors(&MIRROR) && !mirrors(&DMat4::IDENTITY));
    }
}
