//! The indentation of new functions: as in the file, as in the other sources, or as `.clang-format` or
//! `.editorconfig` of the folder or of one around it says.

use camino::Utf8Path;
use ec4rs::property::{IndentSize, IndentStyle};
use ec4rs::{ConfigParser, Properties, PropertiesSource as _};

use super::files::{Files, IndexedFile};

/// The indentation of the skeleton.
const SKELETON: &str = "  ";

/// Maximum number of columns.
const MAX_WIDTH: usize = 8;

/// The text by which the body of a function in a file is indented. `files` are the file, if it exists, and
/// then the other sources.
pub(super) fn indentation<'a>(
    path: &Utf8Path,
    files: impl Iterator<Item = &'a IndexedFile>,
    text: &dyn Files,
) -> String {
    let mut written = files.filter_map(of_functions).filter(|(_, sample)| !sample);
    if let Some((unit, _)) = written.next() {
        return unit.to_owned();
    }
    let folders = || path.ancestors().skip(1);
    folders()
        .find_map(|folder| of_clang_format(&text.read(&folder.join(".clang-format"))?))
        .or_else(|| folders().find_map(|folder| of_editorconfig(folder, path, text)))
        .unwrap_or_else(|| SKELETON.to_owned())
}

/// The indentation of most functions of a file that are not samples of the skeleton, else of its samples, and
/// true for those.
fn of_functions(file: &IndexedFile) -> Option<(&str, bool)> {
    let bodies = file.index().functions.iter().filter_map(|function| function.body.as_ref());
    let units = bodies.filter_map(|body| {
        let text = file.text.get(body.span.clone())?;
        let mut lines = text.lines().skip(1).filter(|line| !line.trim().is_empty());
        let line = lines.next()?;
        let unit = &line[..line.len() - line.trim_start().len()];
        let is_unit = unit == "\t" || (1..=MAX_WIDTH).contains(&unit.len()) && !unit.contains('\t');
        is_unit.then_some((unit, body.sample))
    });
    let mut counted: Vec<((&str, bool), usize)> = Vec::new();
    for unit in units {
        match counted.iter_mut().find(|known| known.0 == unit) {
            Some(known) => known.1 += 1,
            None => counted.push((unit, 1)),
        }
    }
    let most = counted.into_iter().min_by_key(|((_, sample), count)| (*sample, usize::MAX - count));
    most.map(|(unit, _)| unit)
}

fn spaces(width: usize) -> Option<String> {
    (1..=MAX_WIDTH).contains(&width).then(|| " ".repeat(width))
}

/// `IndentWidth`, `UseTab`, and the indentation of the styles that are not of two columns.
fn of_clang_format(text: &str) -> Option<String> {
    let value = |key: &str| {
        let mut lines = text.lines().filter_map(|line| line.split_once(':'));
        lines.find(|line| line.0.trim() == key).map(|line| line.1.trim().to_owned())
    };
    if value("UseTab").is_some_and(|tab| !matches!(tab.as_str(), "Never" | "false")) {
        return Some("\t".to_owned());
    }
    if let Some(width) = value("IndentWidth") {
        return spaces(width.parse().ok()?);
    }
    match value("BasedOnStyle")?.to_ascii_lowercase().as_str() {
        "webkit" | "microsoft" => spaces(4),
        _ => spaces(2),
    }
}

fn of_editorconfig(folder: &Utf8Path, path: &Utf8Path, text: &dyn Files) -> Option<String> {
    let file = text.read(&folder.join(".editorconfig"))?;
    let relative = path.strip_prefix(folder).ok()?.as_std_path();
    let parser = ConfigParser::new_buffered(file.as_bytes()).ok()?;
    let mut found = Properties::new();
    for section in parser.flatten() {
        if section.applies_to(relative) {
            section.apply_to(&mut found, relative).ok()?;
        }
    }
    if matches!(found.get::<IndentStyle>(), Ok(IndentStyle::Tabs)) {
        return Some("\t".to_owned());
    }
    match found.get::<IndentSize>().ok()? {
        IndentSize::Value(width) => spaces(width),
        IndentSize::UseTabWidth => None,
    }
}
