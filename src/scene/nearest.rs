//! The known name nearest to a misspelt one.

/// Edits (insert, delete, replace) from one name to another: the Levenshtein distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replace = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

/// Longest name worth comparing: no known name is longer than half of it.
const LONGEST: usize = 64;

/// The nearest of `known`, the first of equals; `None` where none is alike, nothing is known or the name is absurdly
/// long. Names are alike where at most half of the letters of the longer one must be changed.
pub(super) fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.chars().count() > LONGEST {
        return None;
    }
    let alike = |known: &&str| 2 * distance(name, known) <= name.chars().count().max(known.chars().count());
    known.into_iter().filter(alike).min_by_key(|known| distance(name, known))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_counts_edits() {
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("same", "same"), 0);
        assert_eq!(nearest("tiem", ["name", "time", "forces"]), Some("time"));
        assert_eq!(nearest("x", []), None);
        assert_eq!(nearest("spring", ["constant", "gravity", "trap"]), None);
    }
}
