//! The name that was probably meant.

/// The candidate that differs least from `name`, if it is near enough to be a slip.
pub fn nearest<'a>(name: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let (distance, best) = candidates.iter().map(|c| (edit_distance(name, c), *c)).min()?;
    (distance <= 1 + name.chars().count() / 3).then_some(best)
}

/// Insertions, deletions and replacements, and swaps of neighbours, that turn `a` into `b`.
fn edit_distance(a: &str, b: &str) -> usize {
    // Names beyond this are no slips; the table below is quadratic.
    const LONGEST: usize = 64;
    let a: Vec<char> = a.to_lowercase().chars().take(LONGEST).collect();
    let b: Vec<char> = b.to_lowercase().chars().take(LONGEST).collect();
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let replace = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
            let mut least = replace.min(rows[i - 1][j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_find_their_key_and_nonsense_does_not() {
        let keys = ["photons", "passes", "estimator"];
        assert_eq!(nearest("photon", &keys), Some("photons"));
        assert_eq!(nearest("phtoons", &keys), Some("photons"));
        assert_eq!(nearest("Estimater", &keys), Some("estimator"));
        assert_eq!(nearest("wavelength", &keys), None);
        assert_eq!(edit_distance("ab", "ba"), 1);
        assert_eq!(edit_distance("", "abc"), 3);
    }
}
