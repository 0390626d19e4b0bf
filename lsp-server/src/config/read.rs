//! Reading settings leniently: a key that is unknown or has a wrong value is reported where it
//! stands and left out; the others count.

use std::ops::Range;

use rustc_hash::FxHashMap;
use serde_json::{Map, Value};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Settings, schema};

/// What was read, and what was wrong with it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Read {
    /// Everything that made sense.
    pub settings: Settings,
    /// Everything that did not.
    pub problems: Vec<Problem>,
}

/// Something wrong with a source of settings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Kind of problem.
    pub kind: ProblemKind,
    /// What is wrong and what would be right.
    pub message: String,
    /// Byte range in the file, when the source is one.
    pub range: Option<Range<usize>>,
}

/// Kinds of problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProblemKind {
    /// The file is not TOML; nothing was read.
    Syntax,
    /// No setting of that name.
    UnknownKey,
    /// The value is not of the setting's type.
    BadValue,
}

impl Problem {
    /// The file is there but is no text.
    pub(crate) fn unreadable() -> Problem {
        Problem {
            kind: ProblemKind::Syntax,
            message: format!("`{}` cannot be read as UTF-8 text", super::FILE_NAME),
            range: None,
        }
    }
}

impl ProblemKind {
    /// Stable diagnostic code.
    pub fn code(self) -> &'static str {
        match self {
            ProblemKind::Syntax => "config-syntax",
            ProblemKind::UnknownKey => "config-unknown-key",
            ProblemKind::BadValue => "config-bad-value",
        }
    }

    /// An unknown key may come from a newer dotgen, so it is only a warning.
    pub fn is_error(self) -> bool {
        !matches!(self, ProblemKind::UnknownKey)
    }
}

/// Settings that an editor extension keeps for itself under the same prefix.
const CLIENT_ONLY: [&str; 4] = ["server", "trace", "files", "trusted"];

/// Reads the text of a `dotgen.toml`.
pub fn from_toml(text: &str) -> Read {
    let table = match DeTable::parse(text) {
        Ok(table) => table,
        Err(error) => {
            let problem = Problem {
                kind: ProblemKind::Syntax,
                message: format!("not a valid TOML file: {}", error.message().trim()),
                range: Some(error.span().unwrap_or(0..0)),
            };
            return Read {
                problems: vec![problem],
                ..Read::default()
            };
        }
    };
    let mut spans = Spans::default();
    let object = spans.table(table.get_ref(), "");
    let (settings, problems) = read_object(&object, &[]);
    let problems = problems.into_iter().map(|(pointer, mut problem)| {
        let spans = match problem.kind {
            ProblemKind::UnknownKey => &spans.keys,
            _ => &spans.values,
        };
        problem.range = spans.get(&pointer).cloned();
        problem
    });
    let mut problems: Vec<Problem> = problems.collect();
    problems.sort_by_key(|it| it.range.as_ref().map(|range| range.start));
    Read { settings, problems }
}

/// Reads what an editor sent: the section itself, an object that holds it as `dotgen`, or dotted
/// keys (`"dotgen.includePaths"`). Names may be in camel case, as editors prefer.
pub fn from_editor(value: &Value) -> Read {
    let object = editor_section(value);
    let (settings, problems) = read_object(&object, &CLIENT_ONLY);
    Read {
        settings,
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
            // The whole settings of a client that flattens them: the rest is not ours.
            None if dotted => continue,
            None => key,
        };
        // `severity.syntax`, `server.path`
        match key.split_once('.') {
            Some((table, entry)) => {
                let table = section
                    .entry(kebab(table))
                    .or_insert_with(|| Value::Object(Map::new()));
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

/// The settings of an object, and the problems with the JSON pointers they are at.
fn read_object(
    object: &Map<String, Value>,
    ignored: &[&str],
) -> (Settings, Vec<(String, Problem)>) {
    let properties = schema::properties();
    let mut settings = Settings::default();
    let mut problems = Vec::new();
    for (key, value) in object {
        if ignored.contains(&key.as_str()) || value.is_null() {
            continue;
        }
        if !properties.contains_key(key) {
            let message = match nearest(key, properties.keys().map(String::as_str)) {
                Some(near) => format!("unknown setting `{key}`; did you mean `{near}`?"),
                None => format!("unknown setting `{key}`"),
            };
            problems.push((
                format!("/{key}"),
                Problem {
                    kind: ProblemKind::UnknownKey,
                    message,
                    range: None,
                },
            ));
            continue;
        }
        // Entry by entry, so that one bad entry of a table does not lose the others.
        let parts: Vec<(String, Value)> = match value {
            Value::Object(table) => table
                .iter()
                .map(|(entry, value)| {
                    let single = Map::from_iter([(entry.clone(), value.clone())]);
                    (format!("/{key}/{entry}"), Value::Object(single))
                })
                .collect(),
            _ => vec![(format!("/{key}"), value.clone())],
        };
        for (pointer, part) in parts {
            let one = Value::Object(Map::from_iter([(key.clone(), part)]));
            if let Some(problem) = unknown_code(key, &pointer) {
                problems.push((pointer.clone(), problem));
            }
            match serde_json::from_value::<Settings>(one) {
                Ok(one) => settings = settings.over(one),
                Err(error) => problems.push((
                    pointer.clone(),
                    Problem {
                        kind: ProblemKind::BadValue,
                        message: format!(
                            "bad value for `{}`: {}",
                            pointer[1..].replace('/', "."),
                            explain(key, &error)
                        ),
                        range: None,
                    },
                )),
            }
        }
    }
    (settings, problems)
}

/// A severity for a code that does not exist has no effect; that is worth saying.
fn unknown_code(key: &str, pointer: &str) -> Option<Problem> {
    let code = pointer.strip_prefix("/severity/")?;
    let known = schema::codes;
    if key != "severity" || known().any(|it| it == code) {
        return None;
    }
    let message = match nearest(code, known()) {
        Some(near) => format!("there is no diagnostic `{code}`; did you mean `{near}`?"),
        None => format!("there is no diagnostic `{code}`; the manual lists the codes"),
    };
    Some(Problem {
        kind: ProblemKind::UnknownKey,
        message,
        range: None,
    })
}

/// What would be right, in words.
fn explain(key: &str, error: &serde_json::Error) -> String {
    match key {
        "include-paths" | "package-paths" | "template-paths" => {
            "expected a list of directories".to_owned()
        }
        "defines" => "expected a string, a number, `true` or `false`".to_owned(),
        "connections" => {
            "expected a table of ports, each with \"component.port\" or a list of them".to_owned()
        }
        "generate" => {
            "expected tables with a `file`, a `template` and a list of `arguments`".to_owned()
        }
        "severity" => {
            "expected \"error\", \"warning\", \"information\", \"hint\" or \"off\"".to_owned()
        }
        _ => error.to_string(),
    }
}

/// The name within a third of edits, if any.
fn nearest<'n>(name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    known
        .map(|it| (edit_distance(name, it), it))
        .filter(|(distance, it)| *distance <= it.len().max(name.len()) / 3)
        .min()
        .map(|(_, it)| it)
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

/// Where the keys and values of a file are, by JSON pointer.
#[derive(Default)]
struct Spans {
    keys: FxHashMap<String, Range<usize>>,
    values: FxHashMap<String, Range<usize>>,
}

impl Spans {
    fn table(&mut self, table: &DeTable<'_>, pointer: &str) -> Map<String, Value> {
        let entries = table.iter().map(|(key, value)| {
            let pointer = format!("{pointer}/{}", key.get_ref());
            self.keys.insert(pointer.clone(), key.span());
            self.values.insert(pointer.clone(), value.span());
            (key.get_ref().to_string(), self.value(value, &pointer))
        });
        entries.collect()
    }

    fn value(&mut self, value: &Spanned<DeValue<'_>>, pointer: &str) -> Value {
        match value.get_ref() {
            DeValue::String(text) => Value::String(text.to_string()),
            DeValue::Integer(number) => i64::from_str_radix(number.as_str(), number.radix())
                .map_or_else(|_| Value::String(number.as_str().to_owned()), Value::from),
            DeValue::Float(number) => number
                .as_str()
                .parse::<f64>()
                .map_or(Value::Null, Value::from),
            DeValue::Boolean(flag) => Value::Bool(*flag),
            DeValue::Datetime(datetime) => Value::String(datetime.to_string()),
            DeValue::Array(items) => {
                Value::Array(items.iter().map(|it| self.value(it, pointer)).collect())
            }
            DeValue::Table(table) => Value::Object(self.table(table, pointer)),
        }
    }
}
