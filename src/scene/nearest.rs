//! The known name nearest to a misspelt one.

/// The number of edits (insert, delete, replace, swap neighbours) from one name to another: the Damerau-Levenshtein
/// distance in which no part is edited twice.
fn distance(a: &str, b: &str) -> usize {
    let [a, b]: [Vec<char>; 2] = [a, b].map(|name| name.chars().collect());
    let mut before: Vec<usize> = Vec::new();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut next = vec![i + 1];
        for (j, y) in b.iter().enumerate() {
            let replaced = row[j] + usize::from(x != y);
            let mut least = replaced.min(row[j + 1] + 1).min(next[j] + 1);
            if i > 0 && j > 0 && a[i - 1] == *y && b[j - 1] == *x {
                least = least.min(before[j - 1] + 1);
            }
            next.push(least);
        }
        before = std::mem::replace(&mut row, next);
    }
    row[b.len()]
}

/// Longest name worth comparing: no known name is longer than half of it.
const LONGEST: usize = 64;

/// The nearest of `known`, the first among equals; `None` if none is similar, `known` is empty or the name is longer
/// than 64 characters. Names are similar if the edits are at most two fifths of the letters of the longer one.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.chars().count() > LONGEST {
        return None;
    }
    let alike = |known: &&str| 5 * distance(name, known) <= 2 * name.chars().count().max(known.chars().count());
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
        assert_eq!(distance("rnu", "run"), 1);
        assert_eq!(distance("abcd", "badc"), 2);
        assert_eq!(nearest("rnu", ["batch", "run", "render"]), Some("run"));
        assert_eq!(nearest("tiem", ["name", "time", "forces"]), Some("time"));
        assert_eq!(nearest("x", []), None);
        assert_eq!(nearest("spring", ["constant", "gravity", "trap"]), None);
    }
}
