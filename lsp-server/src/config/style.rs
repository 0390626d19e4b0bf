//! The style of the formatter for a file, and the order of its sources.
//!
//! Strongest first: the settings of dotgen, `.editorconfig`, the file itself, the editor. The editor comes
//! last because most editors send their own default for every file.

use camino::Utf8Path;
use dotgen_syntax::format::{Align, DEFAULT_UNIT, Options, TAB, Unit};
use ec4rs::property::{IndentSize, IndentStyle, MaxLineLen, TabWidth};

use crate::config::{Format, FormatAlign, FormatUnit};
use crate::protocol::types::FormattingOptions;

/// The style for a file. Without `editor`, a file without indentation gets [`DEFAULT_UNIT`].
pub fn options(settings: &Format, path: &Utf8Path, editor: Option<&FormattingOptions>) -> Options {
    let shared = ec4rs::properties_of(path).unwrap_or_default();
    let default = Options::default();
    let unit = match settings.unit {
        Some(FormatUnit::Blanks(count)) => Some(Unit::Spaces(usize::from(count).max(1))),
        Some(FormatUnit::Word(_)) => Some(Unit::Tabs(tab_width(&shared))),
        None => editorconfig_unit(&shared),
    };
    let width = match (settings.width, shared.get::<MaxLineLen>()) {
        (Some(width), _) => usize::from(width),
        (None, Ok(MaxLineLen::Value(width))) => width,
        (None, Ok(MaxLineLen::Off)) => usize::MAX / 2,
        (None, Err(_)) => default.width,
    };
    Options {
        unit,
        otherwise: editor.map_or(DEFAULT_UNIT, editor_unit),
        width,
        align: match settings.align {
            None | Some(FormatAlign::Keep) => Align::Keep,
            Some(FormatAlign::None) => Align::None,
        },
    }
}

fn editorconfig_unit(shared: &ec4rs::Properties) -> Option<Unit> {
    match (shared.get::<IndentStyle>(), shared.get::<IndentSize>()) {
        (Ok(IndentStyle::Tabs), _) => Some(Unit::Tabs(tab_width(shared))),
        (_, Ok(IndentSize::Value(count))) => Some(Unit::Spaces(count.max(1))),
        (Ok(IndentStyle::Spaces), Ok(IndentSize::UseTabWidth)) => {
            Some(Unit::Spaces(tab_width(shared)))
        }
        _ => None,
    }
}

fn tab_width(shared: &ec4rs::Properties) -> usize {
    match shared.get::<TabWidth>() {
        Ok(TabWidth::Value(width)) => width.max(1),
        Err(_) => TAB,
    }
}

fn editor_unit(editor: &FormattingOptions) -> Unit {
    let columns = (editor.tab_size as usize).clamp(1, 16);
    if editor.insert_spaces { Unit::Spaces(columns) } else { Unit::Tabs(columns) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_lead_then_editorconfig_then_the_file_then_the_editor() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        let path = folder.join("a.gen");
        let editor =
            FormattingOptions { tab_size: 3, insert_spaces: true, ..FormattingOptions::default() };
        let asked = |settings: &Format| options(settings, &path, Some(&editor));
        let none = asked(&Format::default());
        assert_eq!((none.unit, none.otherwise), (None, Unit::Spaces(3)));
        assert_eq!(none.width, 80);

        let shared =
            "root = true\n[*.gen]\nindent_style = tab\ntab_width = 4\nmax_line_length = 100\n";
        std::fs::write(folder.join(".editorconfig"), shared).unwrap();
        let shared = asked(&Format::default());
        assert_eq!(shared.unit, Some(Unit::Tabs(4)));
        assert_eq!(shared.width, 100);

        let own = Format {
            unit: Some(FormatUnit::Blanks(4)),
            width: Some(90),
            align: Some(FormatAlign::None),
        };
        let own = asked(&own);
        assert_eq!(own.unit, Some(Unit::Spaces(4)));
        assert_eq!((own.width, own.align), (90, Align::None));
    }
}
