//! Power laws: a straight line through the logarithms, by least squares, and how well its slope is known.

use crate::math::student;

/// ln y = intercept + slope · ln x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    pub slope: f64,
    pub intercept: f64,
    /// Half width of the slope's 95 % interval under independent, equal errors of ln y; none with two points.
    pub half_width: Option<f64>,
}

/// The line through points (x, y), all positive; `None` with fewer than two different x or a point that has no logarithm.
pub fn power_law(points: &[(f64, f64)]) -> Option<PowerLaw> {
    let logs: Vec<(f64, f64)> = points.iter().map(|&(x, y)| (x.ln(), y.ln())).collect();
    if logs.iter().any(|(x, y)| !x.is_finite() || !y.is_finite()) {
        return None;
    }
    let n = logs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| logs.iter().map(of).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let sxx: f64 = logs.iter().map(|(x, _)| (x - mx).powi(2)).sum();
    // The mean of equal numbers is not always that number.
    if sxx.is_nan() || sxx <= 0.0 || logs.iter().all(|p| p.0 == logs[0].0) {
        return None;
    }
    let slope = logs.iter().map(|(x, y)| (x - mx) * (y - my)).sum::<f64>() / sxx;
    let intercept = my - slope * mx;
    let half_width = (logs.len() > 2).then(|| {
        let dof = logs.len() - 2;
        let residual: f64 = logs.iter().map(|(x, y)| (y - intercept - slope * x).powi(2)).sum();
        student::quantile(dof) * (residual / dof as f64 / sxx).sqrt()
    });
    Some(PowerLaw { slope, intercept, half_width })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Purpose, Stream};

    #[test]
    fn an_exact_power_law_is_found() {
        let points: Vec<_> = [1e3, 4e3, 1.6e4, 6.4e4].map(|n: f64| (n, 7.0 * n.powf(-1.0 / 3.0))).to_vec();
        let law = power_law(&points).expect("a line");
        assert!((law.slope + 1.0 / 3.0).abs() < 1e-12 && (law.intercept - 7f64.ln()).abs() < 1e-11);
        assert!(law.half_width.expect("four points") < 1e-10);
        assert_eq!(power_law(&points[..2]).expect("a line").half_width, None);
        assert_eq!(power_law(&points[..1]), None);
        assert_eq!(power_law(&[(500.0, 1.0), (500.0, 2.0), (500.0, 3.0)]), None);
        assert_eq!(power_law(&[(1.0, 1.0), (2.0, 0.0)]), None);
    }

    /// Of 2000 lines through five noisy points 95 % have the true slope in their interval: within 5 σ of the binomial.
    #[test]
    fn the_interval_covers_as_often_as_it_says() {
        let mut stream = Stream::new(7, Purpose::Test, 0, 0);
        let trials = 2000;
        let covered = (0..trials).filter(|_| {
            let noisy = |i: i32| {
                let gauss = (0..12).map(|_| stream.uniform()).sum::<f64>() - 6.0;
                (f64::from(i).exp(), (0.3 * gauss - 0.5 * f64::from(i)).exp())
            };
            let points: Vec<_> = (0..5).map(noisy).collect();
            let law = power_law(&points).expect("a line");
            (law.slope + 0.5).abs() <= law.half_width.expect("five points")
        });
        let share = covered.count() as f64 / f64::from(trials);
        assert!((share - 0.95).abs() < 5.0 * (0.95f64 * 0.05 / f64::from(trials)).sqrt(), "{share}");
    }

    /// Printed tables: 2.042 at 30 degrees of freedom, 1.980 at 120.
    #[test]
    fn quantiles_beyond_the_table() {
        assert!((student::quantile(13) - 2.160).abs() < 3e-3 && (student::quantile(30) - 2.042).abs() < 1e-3);
        assert!((student::quantile(120) - 1.980).abs() < 1e-3);
    }
}
