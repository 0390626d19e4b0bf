//! Text helpers of the template language: names, comments, wrapping, rules, numbers.

/// C name: leading `::` removed, scopes joined with `_`, blanks `_`, `+` as `x`.
pub(crate) fn c_name(name: &str) -> String {
    let name = name.strip_prefix("::").unwrap_or(name);
    name.replace("::", "_").replace(' ', "_").replace('+', "x")
}

/// C++ name: leading `::` removed, blanks `_`, `+` as `x`.
pub(crate) fn cxx_name(name: &str) -> String {
    let name = name.strip_prefix("::").unwrap_or(name);
    name.replace(' ', "_").replace('+', "x")
}

/// A C comment; `**/` inside closes as one `*/`.
pub(crate) fn c_comment(text: &str) -> String {
    let lines: Vec<&str> = text.split('\n').collect();
    format!("/*{}*/", lines.join("\n *")).replace("**/", "*/")
}

/// A C++ comment. The lines are joined to one line, for identical output to GenoM3.
pub(crate) fn cxx_comment(text: &str) -> String {
    let lines: Vec<&str> = text.split('\n').collect();
    // Words are joined as by Tcl's `concat`: trimmed.
    let joined = lines.join("// ");
    let joined = joined.trim_matches(|c: char| c.is_ascii_whitespace() || c == '\u{b}');
    if joined.is_empty() { "//".to_owned() } else { format!("// {joined}") }
}

/// Puts `mark` before every line.
pub(crate) fn marked_comment(mark: &str, text: &str) -> String {
    let lines: Vec<&str> = text.split('\n').collect();
    format!("{mark}{}", lines.join(&format!("\n{mark}")))
}

/// The `---` rule: `FFF text FFF…`, filled to `column`.
pub fn rule(text: &str, filler: Option<char>, column: i64) -> String {
    let filler = filler.map(String::from).unwrap_or_default();
    let count = column - 5 - text.chars().count() as i64;
    format!("{} {text} {}", filler.repeat(3), filler.repeat(usize::try_from(count).unwrap_or(0)))
}

/// Cuts a text into lines of at most `column` characters at `separator`, each line after the first starting
/// with `prefix`. A separator that is not blank stays at the end of its line; the character after a cut is
/// dropped.
pub(crate) fn wrap(text: &str, prefix: &str, separator: &str, column: usize) -> String {
    let separator_chars: Vec<char> = separator.chars().collect();
    let prefix: Vec<char> = prefix.chars().collect();
    let blank = separator.chars().all(char::is_whitespace);
    let mut text: Vec<char> = text.chars().collect();
    let mut out = String::new();
    let mut first = true;
    while text.len() > column {
        let head = &text[..(column + 1).min(text.len())];
        let Some(at) =
            find_last(head, &separator_chars).or_else(|| find_first(&text, &separator_chars, 0))
        else {
            break;
        };
        // A cut inside the prefix would never shorten the text: cut after the word.
        let at = if !first && at < prefix.len() {
            match find_first(&text, &separator_chars, prefix.len()) {
                Some(at) => at,
                None => break,
            }
        } else {
            at
        };
        let cut = if blank { at } else { at + 1 };
        out.extend(&text[..cut.min(text.len())]);
        out.push('\n');
        let rest = text.get(cut + 1..).unwrap_or_default();
        let ended = rest.is_empty();
        text = prefix.iter().chain(rest).copied().collect();
        first = false;
        if ended {
            break;
        }
    }
    out.extend(text);
    out
}

fn find_last(text: &[char], wanted: &[char]) -> Option<usize> {
    if wanted.is_empty() {
        return None;
    }
    text.windows(wanted.len()).rposition(|window| window == wanted)
}

fn find_first(text: &[char], wanted: &[char], from: usize) -> Option<usize> {
    if wanted.is_empty() {
        return None;
    }
    let text = text.get(from..)?;
    let at = text.windows(wanted.len()).position(|window| window == wanted)?;
    Some(at + from)
}

/// A number as C `%g` prints it: six significant digits, no trailing zeros.
pub(crate) fn format_g(value: f64) -> String {
    if value.is_nan() {
        return if value.is_sign_negative() { "-nan" } else { "nan" }.into();
    }
    if value.is_infinite() {
        return if value < 0.0 { "-inf" } else { "inf" }.into();
    }
    if value == 0.0 {
        return if value.is_sign_negative() { "-0" } else { "0" }.into();
    }
    let scientific = format!("{value:.5e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if (-4..6).contains(&exponent) {
        let decimals = usize::try_from(5 - exponent).unwrap_or(0);
        return trim_zeros(&format!("{value:.decimals$}")).to_owned();
    }
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{}e{sign}{:02}", trim_zeros(mantissa), exponent.abs())
}

fn trim_zeros(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_print_as_c_does() {
        for (value, text) in [
            (0.004, "0.004"),
            (1.0, "1"),
            (1e-5, "1e-05"),
            (123_456.0, "123456"),
            (1_234_567.0, "1.23457e+06"),
            (0.0001, "0.0001"),
            (0.000_012_345_67, "1.23457e-05"),
            (-2.5, "-2.5"),
            (999_999.5, "1e+06"),
            (100_000.0, "100000"),
            (1e100, "1e+100"),
        ] {
            assert_eq!(format_g(value), text);
        }
    }

    #[test]
    fn wrapping_cuts_at_the_last_separator_that_fits() {
        assert_eq!(wrap("aa bb cc dd", "  ", " ", 5), "aa bb\n  cc\n  dd");
        // The character after the cut is dropped, blank or not.
        assert_eq!(wrap("a, b, c, d", "-", ",", 5), "a, b,\n-c, d");
    }

    #[test]
    fn wrapping_ends_when_a_word_is_wider_than_the_line() {
        assert_eq!(
            wrap("Yields aaaaaaaaaaaaaaaaaaaa b", "      ", " ", 10),
            "Yields\n      aaaaaaaaaaaaaaaaaaaa\n      b"
        );
        assert_eq!(wrap("aaaaaaaaaaaaaaaa", " ", " ", 5), "aaaaaaaaaaaaaaaa");
    }

    #[test]
    fn comments() {
        assert_eq!(c_comment("a\nb"), "/*a\n *b*/");
        assert_eq!(c_comment("ends with *"), "/*ends with */");
        assert_eq!(cxx_comment("a\nb"), "// a// b");
        assert_eq!(marked_comment("#", "a\nb"), "#a\n#b");
    }

    #[test]
    fn rules_fill_to_the_column() {
        assert_eq!(rule("one two", Some('-'), 20), "--- one two --------");
        assert_eq!(rule("long text", Some('='), 5), "=== long text ");
    }
}
