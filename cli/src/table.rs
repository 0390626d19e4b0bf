//! Tables of values: a header with the paths of members, and a value per row.

use serde_json::{Map, Value};

/// The name of the first column, if it has times.
const TIME: &str = "time";

/// The name of the single column of values that have no members.
const WHOLE: &str = "value";

/// Largest index of a list in a header.
const MAX_INDEX: usize = 100_000;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
    /// Line of the file, from 1.
    pub(super) line: usize,
    /// Seconds.
    pub(super) time: Option<f64>,
    pub(super) value: Value,
}

/// A step into a value.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Step {
    Member(String),
    Index(usize),
}

struct Column {
    title: String,
    path: Vec<Step>,
    /// The schema of its cells; an empty one if it is not known.
    schema: Value,
}

/// Reads a table of values of a schema.
///
/// # Errors
/// A message: the text is not such a table.
pub(super) fn read(bytes: &[u8], schema: &Value) -> Result<Vec<Row>, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "it is not UTF-8".to_owned())?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = (1usize..).zip(text.lines());
    let (_, header) = lines.next().ok_or("it is empty")?;
    let titles = cells(header).map_err(|error| format!("line 1 {error}"))?;
    let timed = titles.first().is_some_and(|title| title.trim() == TIME);
    let mut columns: Vec<Column> = Vec::new();
    for title in titles.iter().skip(usize::from(timed)) {
        let title = title.trim();
        let path = path(title, schema).map_err(|error| format!("column `{title}` {error}"))?;
        if columns.iter().any(|column| column.path == path) {
            return Err(format!("column `{title}` is there twice"));
        }
        columns.push(Column {
            title: title.to_owned(),
            schema: inside(schema, &path).clone(),
            path,
        });
    }
    if columns.is_empty() {
        return Err("its header names no members".to_owned());
    }
    let mut rows: Vec<Row> = Vec::new();
    for (line, text) in lines.filter(|line| !line.1.trim().is_empty()) {
        let told = |text: String| format!("line {line} {text}");
        let row = row(line, text, timed, &columns).map_err(told)?;
        if rows.last().is_some_and(|other| other.time > row.time) {
            return Err(told("goes back in time".to_owned()));
        }
        rows.push(row);
    }
    Ok(rows)
}

fn row(line: usize, text: &str, timed: bool, columns: &[Column]) -> Result<Row, String> {
    let cells = cells(text)?;
    let mut all = cells.iter().map(String::as_str);
    let expected = columns.len() + usize::from(timed);
    if cells.len() != expected {
        return Err(format!("has {} cells, and the header {expected}", cells.len()));
    }
    let time = match timed {
        true => {
            let text = all.next().unwrap_or_default().trim();
            let time = text.parse::<f64>().ok().filter(|number| number.is_finite());
            Some(time.ok_or_else(|| format!("has the time `{text}`, which is no number"))?)
        }
        false => None,
    };
    let mut value = Value::Null;
    for (column, text) in columns.iter().zip(all) {
        let cell = cell(text, &column.schema);
        let cell = cell.map_err(|error| format!("has `{text}` for `{}`: {error}", column.title))?;
        put(&mut value, &column.path, cell)
            .ok_or_else(|| format!("has no place for `{}`", column.title))?;
    }
    Ok(Row { line, time, value })
}

/// Splits a line into cells. A cell in quotes may contain commas, and doubled quotes.
fn cells(line: &str) -> Result<Vec<String>, String> {
    let mut out = vec![String::new()];
    let mut rest = line.chars().peekable();
    let mut quoted = false;
    while let Some(character) = rest.next() {
        let Some(cell) = out.last_mut() else { break };
        match character {
            '"' if quoted && rest.peek() == Some(&'"') => {
                rest.next();
                cell.push('"');
            }
            '"' if quoted => quoted = false,
            '"' if cell.is_empty() => quoted = true,
            ',' if !quoted => out.push(String::new()),
            character => cell.push(character),
        }
    }
    match quoted {
        true => Err("ends within quotes".to_owned()),
        false => Ok(out),
    }
}

/// Parses `pos.x`, `.pos.x` or `points[2].x` into steps.
fn path(title: &str, schema: &Value) -> Result<Vec<Step>, String> {
    if title == WHOLE && schema.get("properties").is_none() {
        return Ok(Vec::new());
    }
    let mut out = Vec::new();
    let starts = title.starts_with('[');
    let words = title.strip_prefix('.').unwrap_or(title).split('.');
    for (number, word) in words.enumerate() {
        let (name, indices) = word.split_at(word.find('[').unwrap_or(word.len()));
        if name.is_empty() && !(starts && number == 0) {
            return Err("is no path of a member, for example pos.x".to_owned());
        }
        if !name.is_empty() {
            out.push(Step::Member(name.to_owned()));
        }
        for index in indices.split_inclusive(']') {
            let index = index.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
            let index = index.and_then(|index| index.parse().ok());
            let index = index.filter(|&index| index <= MAX_INDEX);
            out.push(Step::Index(index.ok_or("has a wrong index")?));
        }
    }
    Ok(out)
}

fn inside<'v>(schema: &'v Value, path: &[Step]) -> &'v Value {
    path.iter().fold(schema, |schema, step| {
        // The first is the type of an optional value.
        let schema = match &schema["anyOf"] {
            Value::Array(all) => all.first().unwrap_or(&Value::Null),
            _ => schema,
        };
        match step {
            Step::Member(name) => &schema["properties"][name.as_str()],
            Step::Index(_) => &schema["items"],
        }
    })
}

/// Converts a cell to a value.
fn cell(text: &str, schema: &Value) -> Result<Value, String> {
    let choices = match &schema["anyOf"] {
        Value::Array(all) => all.as_slice(),
        _ => std::slice::from_ref(schema),
    };
    let has = |wanted: &str| {
        choices.iter().any(|choice| match &choice["type"] {
            Value::String(text) => text == wanted,
            Value::Array(all) => all.iter().any(|value| value == wanted),
            _ => false,
        })
    };
    let word = text.trim();
    let number = word.parse::<f64>().ok();
    if has("string") && !(has("integer") && word.parse::<u64>().is_ok()) {
        // An enumeration accepts a number too.
        return Ok(text.into());
    }
    if word.is_empty() {
        let optional = choices.iter().any(|choice| choice["type"] == "null");
        return match optional {
            true => Ok(Value::Null),
            false => Err("write a value, zero too".to_owned()),
        };
    }
    if has("boolean") && matches!(word, "0" | "1") {
        return Ok((word == "1").into());
    }
    if has("number") && number.is_some_and(|number| !number.is_finite()) {
        return Err("it is not finite".to_owned());
    }
    let read = serde_json::from_str(word).ok();
    match (read, number) {
        (Some(Value::Number(entry)), Some(number)) if has("integer") && entry.is_f64() => {
            Ok(integer(number).unwrap_or_else(|| number.into()))
        }
        (Some(read), _) => Ok(read),
        // JSON has neither `.5` nor `+1`.
        (None, Some(number)) if has("integer") => {
            Ok(integer(number).unwrap_or_else(|| number.into()))
        }
        (None, Some(number)) => Ok(number.into()),
        // The run reports the type of the member.
        (None, None) => Ok(word.into()),
    }
}

/// A whole number below 2^53.
fn integer(number: f64) -> Option<Value> {
    let fits = number.fract() == 0.0 && number.abs() < 9e15;
    fits.then(|| (number as i64).into())
}

/// Puts a cell into a value. Returns `None` if another column has the same place.
fn put(value: &mut Value, path: &[Step], cell: Value) -> Option<()> {
    let Some((step, rest)) = path.split_first() else {
        *value = cell;
        return Some(());
    };
    let slot = match step {
        Step::Member(name) => {
            if value.is_null() {
                *value = Value::Object(Map::new());
            }
            value.as_object_mut()?.entry(name.as_str()).or_insert(Value::Null)
        }
        Step::Index(index) => {
            if value.is_null() {
                *value = Value::Array(Vec::new());
            }
            let all = value.as_array_mut()?;
            if all.len() <= *index {
                all.resize(index + 1, Value::Null);
            }
            all.get_mut(*index)?
        }
    };
    put(slot, rest, cell)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn schema() -> Value {
        json!({"type": "object", "properties": {
            "pos": {"type": "object", "properties": {
                "x": {"type": ["number", "null"]}, "n": {"type": "integer"},
            }},
            "name": {"type": "string"},
            "on": {"type": "boolean"},
            "list": {"type": "array", "items": {"type": "integer"}},
            "maybe": {"anyOf": [{"type": "integer"}, {"type": "null"}]},
            "colour": {"anyOf": [{"type": "string"}, {"type": "integer"}]},
        }})
    }

    fn values(text: &str) -> Result<Vec<Value>, String> {
        let rows = read(text.as_bytes(), &schema())?;
        Ok(rows.into_iter().map(|row| row.value).collect())
    }

    #[test]
    fn cells_are_members() {
        let text = "pos.x,pos.n,name,list[1],list[0]\r\n.5,2.0,\"12, \"\"b\"\"\",8,+7\r\n\r\n1e3,-4,,0,0\n";
        let expected = [
            json!({"pos": {"x": 0.5, "n": 2}, "name": "12, \"b\"", "list": [7, 8]}),
            json!({"pos": {"x": 1000.0, "n": -4}, "name": "", "list": [0, 0]}),
        ];
        assert_eq!(values(text).expect("a table"), expected);
        let text = "on,maybe,colour\n1,,RED\nfalse,3,2\n";
        let expected = [
            json!({"on": true, "maybe": null, "colour": "RED"}),
            json!({"on": false, "maybe": 3, "colour": 2}),
        ];
        assert_eq!(values(text).expect("a table"), expected);
        // The run checks values that do not fit.
        assert_eq!(values("pos.n\n1.5\nx\n").expect("a table")[1], json!({"pos": {"n": "x"}}));
    }

    #[test]
    fn a_column_has_times() {
        let rows = read(b"time,time\n1.5,3\n1.5,4\n", &schema()).expect("a table");
        assert_eq!(rows[1].value, json!({"time": 4}));
        assert_eq!((rows[0].time, rows[0].line), (Some(1.5), 2));
        let whole = json!({"type": ["number", "null"]});
        let rows = read(b"value\n3.5\n", &whole).expect("a table");
        assert_eq!((rows[0].time, &rows[0].value), (None, &json!(3.5)));
    }

    #[test]
    fn what_is_no_table_is_told() {
        let told = |text: &str| values(text).expect_err("it is none");
        assert!(told("").contains("is empty"));
        assert!(told("time\n1\n").contains("names no members"));
        assert!(told("pos.x,pos.x\n1,1\n").contains("twice"));
        assert!(told("pos..x\n1\n").contains("no path"));
        assert!(told("list[a]\n1\n").contains("wrong index"));
        assert!(told("pos.x,name\n1\n").contains("line 2 has 1 cells, and the header 2"));
        assert!(told("pos.x\n1\nnan\n").contains("line 3 has `nan` for `pos.x`: it is not finite"));
        assert!(told("pos.n,name\n,a\n").contains("write a value"));
        assert!(told("time,pos.x\n2,1\n1,1\n").contains("line 3 goes back in time"));
        assert!(told("time,pos.x\nsoon,1\n").contains("no number"));
        assert!(told("name\n\"a\n").contains("within quotes"));
        assert!(told("pos,pos.x\n1,2\n").contains("no place for `pos.x`"));
    }
}
