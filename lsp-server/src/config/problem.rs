//! Errors in settings, and their places in a `dotgen.toml`.

use std::ops::Range;

use rustc_hash::FxHashMap;
use serde_json::{Map, Value};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// An error in a source of settings.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    pub kind: ProblemKind,
    /// The error, and the correct value or name.
    pub message: String,
    /// Byte range in the file, if the source is a file.
    pub range: Option<Range<usize>>,
}

impl Problem {
    /// An unknown setting.
    pub(super) fn unknown(message: String) -> Problem {
        Problem { kind: ProblemKind::UnknownKey, message, range: None }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProblemKind {
    /// The file is not TOML; no setting was read.
    Syntax,
    /// The setting does not exist.
    UnknownKey,
    /// The value is not of the setting's type.
    BadValue,
}

impl Problem {
    /// The file exists but is not text.
    pub fn unreadable() -> Problem {
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

    /// True unless the key is unknown: it may belong to a newer dotgen, so it is only a warning.
    pub fn is_error(self) -> bool {
        !matches!(self, ProblemKind::UnknownKey)
    }
}

/// The place of the value at a JSON pointer in the text of a `dotgen.toml`, or else of what is around it.
pub(super) fn range_of(text: &str, pointer: &str) -> Option<Range<usize>> {
    let table = DeTable::parse(text).ok()?;
    let mut spans = Spans::default();
    spans.table(table.get_ref(), "");
    let ends = pointer.rmatch_indices('/').map(|(at, _)| &pointer[..at]);
    let mut around = std::iter::once(pointer).chain(ends);
    around.find_map(|pointer| spans.values.get(pointer).cloned())
}

/// The places of the keys and values of a file, by JSON pointer.
#[derive(Default)]
pub(super) struct Spans {
    pub(super) keys: FxHashMap<String, Range<usize>>,
    pub(super) values: FxHashMap<String, Range<usize>>,
}

impl Spans {
    pub(super) fn table(&mut self, table: &DeTable<'_>, pointer: &str) -> Map<String, Value> {
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
            DeValue::Float(number) => {
                number.as_str().parse::<f64>().map_or(Value::Null, Value::from)
            }
            DeValue::Boolean(flag) => Value::Bool(*flag),
            DeValue::Datetime(datetime) => Value::String(datetime.to_string()),
            DeValue::Array(items) => {
                Value::Array(items.iter().map(|value| self.value(value, pointer)).collect())
            }
            DeValue::Table(table) => Value::Object(self.table(table, pointer)),
        }
    }
}
