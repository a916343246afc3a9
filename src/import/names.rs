//! Names that differ, of things whose names in the file may not.

use std::collections::HashMap;

/// How often each name was given.
#[derive(Default)]
pub(crate) struct Names(HashMap<String, usize>);

impl Names {
    /// `name` the first time, then `name 2` and so on.
    pub fn unique(&mut self, name: &str) -> String {
        let mut count = self.0.get(name).copied().unwrap_or(0);
        let unique = loop {
            count += 1;
            let candidate = if count == 1 { name.to_owned() } else { format!("{name} {count}") };
            if count == 1 || !self.0.contains_key(&candidate) {
                break candidate;
            }
        };
        self.0.insert(name.to_owned(), count);
        self.0.entry(unique.clone()).or_insert(1);
        unique
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_differ_even_from_numbered_ones() {
        let mut names = Names::default();
        let all = ["a", "a 2", "a", "a", "b", "a 2"].map(|name| names.unique(name));
        assert_eq!(all, ["a", "a 2", "a 3", "a 4", "b", "a 2 2"]);
    }
}
