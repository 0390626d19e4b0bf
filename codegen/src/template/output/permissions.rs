//! Permissions as templates write them, and the rights of templates.

use std::path::PathBuf;

/// The results that a template may write without being confined.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Rights {
    /// All: the template is part of dotgen.
    All,
    /// Also executables. In control folders only files that the user named.
    Tcl(Vec<PathBuf>),
    /// Executables, and files in control folders, only if the user named them.
    MiniJinja(Vec<PathBuf>),
}

/// Reads permissions in the forms of Tcl's `file attributes -permissions`: octal, `rwxr-xr-x`,
/// or `chmod` words.
pub(super) fn parse(text: &str, current: u32) -> Option<u32> {
    let text = text.trim();
    let digits = text.strip_prefix("0o").unwrap_or(text);
    if !digits.is_empty() && digits.chars().all(|c| c.is_digit(8)) {
        return u32::from_str_radix(digits, 8).ok().map(|number| number & 0o7777);
    }
    if text.len() == 9 && text.chars().all(|c| "rwxstST-".contains(c)) {
        return parse_listing(text);
    }
    let mut mode = current;
    for clause in text.split(',') {
        mode = parse_clause(clause, mode)?;
    }
    Some(mode)
}

/// `rwxr-xr-x`.
fn parse_listing(text: &str) -> Option<u32> {
    let mut mode = 0;
    for (index, c) in text.chars().enumerate() {
        let bit = 0o400 >> index;
        let (expected, special) = match index {
            2 => ('x', 0o4000),
            5 => ('x', 0o2000),
            8 => ('x', 0o1000),
            _ if index % 3 == 0 => ('r', 0),
            _ => ('w', 0),
        };
        match c {
            '-' => {}
            c if c == expected => mode |= bit,
            's' | 't' if special != 0 => mode |= bit | special,
            'S' | 'T' if special != 0 => mode |= special,
            _ => return None,
        }
    }
    Some(mode)
}

/// `u+x`, `go-w`, `a=r`.
fn parse_clause(clause: &str, mode: u32) -> Option<u32> {
    let at = clause.find(['+', '-', '='])?;
    let (who, rest) = clause.split_at(at);
    let mut classes = 0;
    for c in who.chars() {
        classes |= match c {
            'u' => 0o4700,
            'g' => 0o2070,
            'o' => 0o1007,
            'a' => 0o7777,
            _ => return None,
        };
    }
    if who.is_empty() {
        classes = 0o7777;
    }
    let mut characters = rest.chars();
    let operator = characters.next()?;
    let mut bits = 0;
    for c in characters {
        bits |= match c {
            'r' => 0o444,
            'w' => 0o222,
            'x' => 0o111,
            's' => 0o6000,
            't' => 0o1000,
            _ => return None,
        };
    }
    let bits = bits & classes;
    Some(match operator {
        '+' => mode | bits,
        '-' => mode & !bits,
        _ => (mode & !classes) | bits,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permissions_in_every_form() {
        for (text, mode) in [
            ("0755", 0o755),
            ("755", 0o755),
            ("a+x", 0o755),
            ("a+x,go-w", 0o755),
            ("u=rwx,g=rx,o=", 0o750),
            ("rwxr-x---", 0o750),
            ("+x", 0o755),
        ] {
            assert_eq!(parse(text, 0o644), Some(mode), "{text}");
        }
        assert_eq!(parse("q+x", 0o644), None);
        assert_eq!(parse("", 0o644), None);
    }
}
