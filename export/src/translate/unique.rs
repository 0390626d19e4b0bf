//! Identifiers that differ: two names can become one identifier, as `a_b` with `c`, and `a` with `b_c`.

use std::collections::BTreeSet;

/// The identifiers of one kind of part.
#[derive(Default)]
pub(super) struct Unique {
    taken: BTreeSet<String>,
    /// Sentences about parts whose identifier has a number.
    pub(super) renamed: Vec<String>,
}

impl Unique {
    /// Returns the identifier of a part, with a number from 2 if an earlier part has the identifier.
    pub(super) fn take(&mut self, name: &str, part: &str) -> String {
        let wanted = identifier(name);
        let mut out = wanted.clone();
        let mut number = 1;
        while !self.taken.insert(out.clone()) {
            number += 1;
            out = format!("{wanted}_{number}");
        }
        if number > 1 {
            self.renamed.push(format!("{part} is named `{out}`: the name `{wanted}` was taken"));
        }
        out
    }
}

/// Returns a name as an identifier.
pub(super) fn identifier(name: &str) -> String {
    let valid = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let text: String = name.chars().map(valid).collect();
    match text.chars().next() {
        Some(first) if first.is_ascii_alphabetic() => text,
        _ => format!("s_{text}"),
    }
}
