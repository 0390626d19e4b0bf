//! "Did you mean": the declared name nearest to a misspelt one.

/// The candidate nearest to `name`, if one is near enough. Of equally near candidates, the alphabetically
/// first is returned, so that the result does not depend on their order.
pub fn nearest<'n>(name: &str, candidates: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    // A name of one or two letters is near to everything.
    let length = name.chars().count();
    let limit = if length < 3 { 0 } else { (length / 3).clamp(1, 3) };
    nearest_within(limit, name, candidates)
}

/// The keyword that a word stands for where only a few may stand: two edits away, or one edit if the word has
/// fewer than four letters.
pub fn nearest_keyword<'n>(
    word: &str,
    keywords: impl IntoIterator<Item = &'n str>,
) -> Option<&'n str> {
    let limit = match word.chars().count() {
        0 | 1 => 0,
        2 | 3 => 1,
        _ => 2,
    };
    nearest_within(limit, word, keywords)
}

fn nearest_within<'n>(
    limit: usize,
    name: &str,
    candidates: impl IntoIterator<Item = &'n str>,
) -> Option<&'n str> {
    candidates
        .into_iter()
        .filter(|candidate| *candidate != name && !candidate.is_empty())
        .filter_map(|candidate| Some((distance(name, candidate, limit)?, candidate)))
        .min()
        .map(|(_, candidate)| candidate)
}

/// What to write instead of a name that is not among some: the nearest of them, or all.
pub fn advice(name: &str, names: &[&str]) -> String {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match (nearest(name, names.iter().copied()), quoted.as_slice()) {
        (Some(near), _) => format!("did you mean `{near}`?"),
        (None, []) => "there are none".to_owned(),
        (None, [one]) => format!("the only one is {one}"),
        (None, several) => format!("there are {}", several.join(", ")),
    }
}

/// Insertions, deletions, replacements and transpositions between two names (optimal string
/// alignment), or `None` above the limit. A difference of case alone counts as 1.
fn distance(a: &str, b: &str, limit: usize) -> Option<usize> {
    if a.len().abs_diff(b.len()) > limit {
        return None;
    }
    if a.eq_ignore_ascii_case(b) {
        return Some(1);
    }
    let total = strsim::osa_distance(a, b);
    (total <= limit).then_some(total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_names_are_found() {
        let names = ["trajectory", "path", "velocity", "Position"];
        assert_eq!(nearest("trajectry", names), Some("trajectory"));
        assert_eq!(nearest("velcoity", names), Some("velocity"));
        assert_eq!(nearest("position", names), Some("Position"));
        assert_eq!(nearest("acceleration", names), None);
        assert_eq!(nearest("x", ["y", "z"]), None);
    }

    #[test]
    fn ties_do_not_depend_on_order() {
        assert_eq!(nearest("posd", ["posb", "posa"]), Some("posa"));
        assert_eq!(nearest("posd", ["posa", "posb"]), Some("posa"));
    }
}
