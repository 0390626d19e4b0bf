//! Tolerant reading of settings: a key that is unknown or has a wrong value is reported at its place and
//! ignored. The other keys are used.

use dotgen_analysis::release::ReleaseOrigin;
use serde_json::{Map, Value};
use toml::de::DeTable;

use super::problem::{Problem, ProblemKind, Spans};
use super::{Settings, schema};

/// Settings, and the errors in their source.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct LoadedSettings {
    /// The valid settings.
    pub settings: Settings,
    /// The errors.
    pub problems: Vec<Problem>,
}

/// Settings under the same prefix that are for the editor extension itself.
pub(super) const CLIENT_ONLY: [&str; 6] =
    ["server", "trace", "files", "run", "diagrams", "trusted"];

/// Reads the text of a `dotgen.toml`.
pub fn from_toml(text: &str) -> LoadedSettings {
    let table = match DeTable::parse(text) {
        Ok(table) => table,
        Err(error) => {
            let problem = Problem {
                kind: ProblemKind::Syntax,
                message: format!("not a valid TOML file: {}", error.message().trim()),
                range: Some(error.span().unwrap_or(0..0)),
            };
            return LoadedSettings { problems: vec![problem], ..LoadedSettings::default() };
        }
    };
    let mut spans = Spans::default();
    let object = spans.table(table.get_ref(), "");
    let (settings, problems) = read_object(&object, &[], &str::to_owned);
    let problems = problems.into_iter().map(|(pointer, mut problem)| {
        let spans = match problem.kind {
            ProblemKind::UnknownKey => &spans.keys,
            _ => &spans.values,
        };
        problem.range = spans.get(&pointer).cloned();
        problem
    });
    let mut problems: Vec<Problem> = problems.collect();
    problems.sort_by_key(|problem| problem.range.as_ref().map(|range| range.start));
    LoadedSettings { settings, problems }
}

/// Reads the settings of an editor: the section itself, an object with the member `dotgen`, or dotted keys
/// (`"dotgen.includePaths"`). Names may be in camel case, as editors prefer.
pub fn from_editor(value: &Value) -> LoadedSettings {
    let section = value.get("dotgen").unwrap_or(value);
    if section.is_string() || section.is_number() || section.is_boolean() {
        let message =
            format!("bad value for `dotgen`: expected an object of settings, found `{section}`");
        let problem = Problem { kind: ProblemKind::BadValue, message, range: None };
        return LoadedSettings { problems: vec![problem], ..LoadedSettings::default() };
    }
    let object = editor_section(value);
    let name = |key: &str| format!("dotgen.{}", camel(key));
    let (settings, problems) = read_object(&object, &CLIENT_ONLY, &name);
    LoadedSettings {
        settings: settings.chosen_by(ReleaseOrigin::Editor),
        problems: problems.into_iter().map(|(_, problem)| problem).collect(),
    }
}

fn editor_section(value: &Value) -> Map<String, Value> {
    let Some(object) = value.as_object() else {
        return Map::new();
    };
    if let Some(section) = object.get("dotgen") {
        return editor_section(section);
    }
    let mut section = Map::new();
    let dotted = object.keys().any(|key| key.starts_with("dotgen."));
    for (key, value) in object {
        let key = match key.strip_prefix("dotgen.") {
            Some(key) => key,
            // Some clients send all of their settings as dotted keys: those of other programs are ignored.
            None if dotted => continue,
            None => key,
        };
        // `severity.syntax`, `server.path`
        match key.split_once('.') {
            Some((table, entry)) => {
                let table =
                    section.entry(kebab(table)).or_insert_with(|| Value::Object(Map::new()));
                if let Value::Object(table) = table {
                    table.insert(entry.to_owned(), value.clone());
                }
            }
            None => {
                section.insert(kebab(key), value.clone());
            }
        }
    }
    section
}

/// `includePaths` to `include-paths`.
fn kebab(name: &str) -> String {
    let mut out = String::with_capacity(name.len() + 2);
    for c in name.chars() {
        if c.is_ascii_uppercase() {
            out.push('-');
            out.push(c.to_ascii_lowercase());
        } else if c == '_' {
            out.push('-');
        } else {
            out.push(c);
        }
    }
    out
}

/// `include-paths` to `includePaths`; the text after a point is unchanged.
fn camel(key: &str) -> String {
    let (name, rest) = key.split_at(key.find('.').unwrap_or(key.len()));
    let mut words = name.split('-');
    let mut out = words.next().unwrap_or_default().to_owned();
    for word in words {
        let mut letters = word.chars();
        out.extend(letters.next().map(|letter| letter.to_ascii_uppercase()));
        out.push_str(letters.as_str());
    }
    out + rest
}

/// The settings of an object, and the errors with their JSON pointers. `name` converts a key to the spelling
/// of its source.
fn read_object(
    object: &Map<String, Value>,
    ignored: &[&str],
    name: &dyn Fn(&str) -> String,
) -> (Settings, Vec<(String, Problem)>) {
    let properties = schema::properties();
    let mut settings = Settings::default();
    let mut problems = Vec::new();
    for (key, value) in object {
        if ignored.contains(&key.as_str()) || value.is_null() {
            continue;
        }
        if !properties.contains_key(key) {
            let hint = did_you_mean(key, properties.keys().map(String::as_str), name);
            let message = format!("unknown setting `{}`{hint}", name(key));
            problems.push((format!("/{key}"), Problem::unknown(message)));
            continue;
        }
        // Each entry is read separately, so that an invalid entry of a table does not remove the others.
        let entries = schema::entries(&properties[key]);
        let mut parts: Vec<(String, Value)> = Vec::new();
        for (entry, value) in value.as_object().into_iter().flatten() {
            let pointer = format!("/{key}/{entry}");
            // Editors use camel case for these names too.
            let known = match &entries {
                Some(all) => {
                    [entry.clone(), kebab(entry)].into_iter().find(|entry| all.contains(entry))
                }
                None => Some(entry.clone()),
            };
            if let Some(entry) = known {
                let single = Map::from_iter([(entry, value.clone())]);
                parts.push((pointer, Value::Object(single)));
                continue;
            }
            let known = entries.iter().flatten().map(String::as_str);
            let hint = did_you_mean(entry, known, &str::to_owned);
            let message = format!("unknown setting `{}`{hint}", name(&dotted(&pointer)));
            problems.push((pointer, Problem::unknown(message)));
        }
        if !value.is_object() {
            parts.push((format!("/{key}"), value.clone()));
        }
        for (pointer, part) in parts {
            let one = Value::Object(Map::from_iter([(key.clone(), part)]));
            if let Some(problem) = unknown_code(key, &pointer) {
                problems.push((pointer.clone(), problem));
            }
            match serde_json::from_value::<Settings>(one) {
                Ok(one) => {
                    problems.extend(one.ros2.problems());
                    settings = settings.over(one);
                }
                Err(error) => {
                    let (written, why) = (name(&dotted(&pointer)), explain(key, &error));
                    let problem = Problem {
                        kind: ProblemKind::BadValue,
                        message: format!("bad value for `{written}`: {why}"),
                        range: None,
                    };
                    problems.push((pointer, problem));
                }
            }
        }
    }
    (settings, problems)
}

/// The nearest known name, as the end of a message.
fn did_you_mean<'k>(
    written: &str,
    known: impl Iterator<Item = &'k str>,
    name: &dyn Fn(&str) -> String,
) -> String {
    let near = nearest(written, known);
    near.map_or(String::new(), |near| format!("; did you mean `{}`?", name(near)))
}

/// A JSON pointer in the syntax of settings: `/severity/fsm/busy-loop` with the quotes that the code needs.
fn dotted(pointer: &str) -> String {
    match pointer[1..].split_once('/') {
        Some((table, entry)) if entry.contains('/') => format!("{table}.\"{entry}\""),
        Some((table, entry)) => format!("{table}.{entry}"),
        None => pointer[1..].to_owned(),
    }
}

/// A problem for a severity of a code that does not exist, because such a setting has no effect.
fn unknown_code(key: &str, pointer: &str) -> Option<Problem> {
    let code = pointer.strip_prefix("/severity/")?;
    let known = schema::codes;
    if key != "severity" || known().any(|name| name == code) {
        return None;
    }
    let message = match nearest(code, known()) {
        Some(near) => format!("there is no diagnostic `{code}`; did you mean `{near}`?"),
        None => format!("there is no diagnostic `{code}`; the manual lists the codes"),
    };
    Some(Problem { kind: ProblemKind::UnknownKey, message, range: None })
}

/// A description of the correct values.
fn explain(key: &str, error: &serde_json::Error) -> String {
    match key {
        "include-paths" | "package-paths" | "template-paths" => {
            "expected a list of directories".to_owned()
        }
        "release" => "expected the number of a release as a text, such as \"2.99.41\"".to_owned(),
        "defines" => "expected a string, a number, `true` or `false`".to_owned(),
        "connections" => {
            "expected a table of ports, each with \"component.port\" or a list of them".to_owned()
        }
        "generate" => {
            "expected tables with a `file`, a `template` and a list of `arguments`".to_owned()
        }
        "ros2" => {
            "expected, for each component and port, a `type`, and tables `fields` and `constants`"
                .to_owned()
        }
        "severity" => {
            "expected \"error\", \"warning\", \"information\", \"hint\" or \"off\"".to_owned()
        }
        _ => {
            let error = error.to_string();
            let (_, expected) = error.split_once("expected ").unwrap_or(("", &error));
            let expected = match expected.split_whitespace().next() {
                Some("struct") => "a table",
                Some("f32" | "f64") => "a number",
                Some("u8" | "u16" | "u32" | "u64" | "usize") => "a whole number",
                Some("a" | "boolean") if expected.contains("boolean") => "`true` or `false`",
                _ => expected,
            };
            format!("expected {expected}")
        }
    }
}

/// The most similar name, if it differs in at most a third of its letters.
fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    known
        .map(|text| (edit_distance(name, text), text))
        .filter(|(distance, text)| *distance <= text.len().max(name.len()) / 3)
        .min()
        .map(|(_, distance)| distance)
}

fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let cost = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = cost.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row.last().copied().unwrap_or(0)
}
