//! Widths of text without a font.
//!
//! The picture must be the same on a robot without fonts and in an editor with any. Widths come from a small
//! table that is slightly wider than common sans-serif faces, so text fits its box with any face; monospaced
//! text is 0.61 em a character.

use crate::graph::LineStyle;

/// Font size and height of a line, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Metrics {
    /// Font size.
    pub size: f64,
    /// Distance of baselines, in pixels.
    pub height: f64,
    /// Monospaced.
    pub mono: bool,
    pub bold: bool,
}

impl LineStyle {
    /// The metrics of lines of this style.
    pub(crate) fn metrics(self) -> Metrics {
        match self {
            LineStyle::Title => Metrics { size: 13.0, height: 18.0, mono: false, bold: true },
            LineStyle::Code => Metrics { size: 11.0, height: 15.0, mono: true, bold: false },
            LineStyle::Detail => Metrics { size: 11.0, height: 15.0, mono: false, bold: false },
        }
    }
}

/// The metrics of edge labels.
pub const LABEL: Metrics = Metrics { size: 11.0, height: 15.0, mono: false, bold: false };

/// The metrics of the notes below the picture.
pub const NOTE: Metrics = Metrics { size: 11.0, height: 16.0, mono: false, bold: false };

/// Width of a text in pixels.
pub fn width(text: &str, metrics: Metrics) -> f64 {
    let em: f64 = if metrics.mono {
        text.chars().map(|c| if is_wide(c) { 1.22 } else { 0.61 }).sum()
    } else {
        text.chars().map(em_width).sum::<f64>() * if metrics.bold { 1.08 } else { 1.0 }
    };
    em * metrics.size
}

/// Returns true for East Asian scripts and emoji, approximately: they are twice as wide.
fn is_wide(c: char) -> bool {
    c >= '\u{1100}' && !('\u{2000}'..'\u{2E80}').contains(&c)
}

fn em_width(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | '\'' | '|' | '.' | ',' | ':' | ';' | '!' => 0.32,
        'f' | 't' | 'r' | 'I' | '(' | ')' | '[' | ']' | '{' | '}' | '/' | '\\' | '-' | ' '
        | '"' => 0.40,
        'm' | 'w' | 'M' | 'W' | '@' | '%' | '—' | '→' => 0.95,
        'A'..='Z' | '&' | '#' | '+' | '<' | '>' | '=' | '~' | '≤' | '≥' | 'Σ' | '∞' => 0.74,
        _ if is_wide(c) => 1.1,
        _ => 0.61,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wider_text_is_wider() {
        let m = LineStyle::Title.metrics();
        assert!(width("exec", m) < width("execute", m));
        assert!(width("iii", m) < width("mmm", m));
        assert!((width("", m)).abs() < f64::EPSILON);
        // The width of a monospaced line depends only on the number of characters.
        let code = LineStyle::Code.metrics();
        assert!((width("iii", code) - width("mmm", code)).abs() < 1e-9);
    }
}
