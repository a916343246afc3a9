//! Small dense decompositions; the one file that names nalgebra.

use nalgebra::Matrix3;

use super::vector::Vec3;

/// Solves the 3×3 system with the given columns, `None` if it is singular.
pub fn solve3(columns: [Vec3; 3], rhs: Vec3) -> Option<Vec3> {
    let m = Matrix3::from_columns(&columns.map(|c| nalgebra::Vector3::new(c.x, c.y, c.z)));
    let x = m.lu().solve(&nalgebra::Vector3::new(rhs.x, rhs.y, rhs.z))?;
    Some(Vec3::new(x[0], x[1], x[2]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_singular_system_has_no_solution() {
        assert!(solve3([Vec3::X, Vec3::X, Vec3::Z], Vec3::Y).is_none());
        let x = solve3([Vec3::X * 2.0, Vec3::Y, Vec3::Z], Vec3::ONE).expect("regular");
        assert!((x - Vec3::new(0.5, 1.0, 1.0)).length() < 1e-15);
    }
}
