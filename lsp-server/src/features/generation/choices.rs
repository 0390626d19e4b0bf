//! The templates run on a specification, and their options. They are stored in the `dotgen.toml` of the
//! workspace folder, so that they can be run again.

use camino::Utf8Path;
use toml_edit::{Array, ArrayOfTables, DocumentMut, Item, Table, value};

use crate::config::Generate;

/// The text of a `dotgen.toml` with one more choice, which replaces the choice for the same file and
/// template. All other text, comments included, is unchanged.
///
/// # Errors
/// The reason why the text cannot be edited.
pub(crate) fn remember(text: &str, choice: &Generate) -> Result<String, String> {
    let mut document: DocumentMut =
        text.parse().map_err(|error: toml_edit::TomlError| error.message().trim().to_owned())?;
    let entry =
        document.entry("generate").or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new()));
    let Some(tables) = entry.as_array_of_tables_mut() else {
        return Err("`generate` is not a list of tables, `[[generate]]`".to_owned());
    };
    let is =
        |table: &Table, key: &str, text: &str| table.get(key).and_then(Item::as_str) == Some(text);
    let known = tables
        .iter_mut()
        .find(|table| is(table, "file", &choice.file) && is(table, "template", &choice.template));
    let arguments: Array = choice.arguments.iter().map(String::as_str).collect();
    if let Some(table) = known {
        let same = table.get("arguments").and_then(Item::as_array);
        let same = same.is_some_and(|array| {
            let given = array.iter().map(toml_edit::Value::as_str);
            given.eq(choice.arguments.iter().map(|argument| Some(argument.as_str())))
        });
        if !same {
            table.insert("arguments", value(arguments));
        }
    } else {
        let mut table = Table::new();
        table.insert("file", value(&choice.file));
        table.insert("template", value(&choice.template));
        table.insert("arguments", value(arguments));
        tables.push(table);
    }
    Ok(document.to_string())
}

/// The name of a file in `dotgen.toml`: relative to its folder, with slashes.
pub(crate) fn relative(file: &Utf8Path, folder: &Utf8Path) -> String {
    let name = file.strip_prefix(folder).unwrap_or(file);
    name.as_str().replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use expect_test::expect;

    use super::*;

    fn choice(template: &str, arguments: &[&str]) -> Generate {
        Generate {
            file: "arm.gen".to_owned(),
            template: template.to_owned(),
            arguments: arguments.iter().map(|argument| (*argument).to_owned()).collect(),
        }
    }

    #[test]
    fn comments_stay_and_choices_replace_each_other() {
        let text = "# mine\nseverity = { \"pp-redefined\" = \"off\" } # loud\n";
        let text = remember(text, &choice("skeleton", &["-u"])).unwrap();
        let text = remember(&text, &choice("docs", &[])).unwrap();
        let text = text.replace("[\"-u\"]", "[\"-u\"] # keep mine");
        let same = remember(&text, &choice("skeleton", &["-u"])).unwrap();
        assert_eq!(same, text);
        let text = remember(&text, &choice("skeleton", &["-f", "-C", "out"])).unwrap();
        expect![[r#"
            # mine
            severity = { "pp-redefined" = "off" } # loud

            [[generate]]
            file = "arm.gen"
            template = "skeleton"
            arguments = ["-f", "-C", "out"]

            [[generate]]
            file = "arm.gen"
            template = "docs"
            arguments = []
        "#]]
        .assert_eq(&text);
        let read = crate::config::from_toml(&text);
        assert_eq!(read.problems, []);
        assert_eq!(read.settings.generate.len(), 2);
    }

    #[test]
    fn what_is_no_list_is_left_alone() {
        let error = remember("generate = 1\n", &choice("docs", &[])).unwrap_err();
        assert!(error.contains("[[generate]]"), "{error}");
        assert!(remember("x = = 1\n", &choice("docs", &[])).is_err());
    }
}
