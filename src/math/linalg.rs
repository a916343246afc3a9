//! Small dense decompositions; the one file that names nalgebra.

use nalgebra::{Matrix2, Matrix3, SymmetricEigen};

use super::vector::Vec3;

/// Eigenvalues, ascending, of the symmetric matrix [[a, b], [b, c]] and the unit eigenvector of the larger one.
pub fn symmetric_eigen2(a: f64, b: f64, c: f64) -> ([f64; 2], [f64; 2]) {
    let eigen = SymmetricEigen::new(Matrix2::new(a, b, b, c));
    let major = usize::from(eigen.eigenvalues[1] > eigen.eigenvalues[0]);
    let v = eigen.eigenvectors.column(major);
    ([eigen.eigenvalues[1 - major], eigen.eigenvalues[major]], [v[0], v[1]])
}

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
    fn eigenpairs_of_a_rotated_diagonal() {
        let (s, c) = 0.4f64.sin_cos();
        // R diag(9, 1) Rᵀ
        let (a, b, d) = (9.0 * c * c + s * s, 8.0 * s * c, 9.0 * s * s + c * c);
        let (values, major) = symmetric_eigen2(a, b, d);
        assert!((values[0] - 1.0).abs() < 1e-12 && (values[1] - 9.0).abs() < 1e-12);
        assert!((major[0] * c + major[1] * s).abs() > 1.0 - 1e-12);
    }

    #[test]
    fn a_singular_system_has_no_solution() {
        assert!(solve3([Vec3::X, Vec3::X, Vec3::Z], Vec3::Y).is_none());
        let x = solve3([Vec3::X * 2.0, Vec3::Y, Vec3::Z], Vec3::ONE).expect("regular");
        assert!((x - Vec3::new(0.5, 1.0, 1.0)).length() < 1e-15);
    }
}
