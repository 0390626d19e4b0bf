//! The JSON schema of the settings, from the Rust types.

use serde_json::{Map, Value, json};

use super::Settings;

/// The schema of `dotgen.toml`, as committed in `docs/dotgen.schema.json`.
pub fn settings_schema() -> Value {
    let mut schema = schemars::schema_for!(Settings).to_value();
    let codes: Vec<&str> = codes().collect();
    schema["properties"]["severity"]["propertyNames"] = json!({ "enum": codes });
    schema
}

/// The codes of all diagnostics about specifications and their codels, sorted.
pub(crate) fn codes() -> impl Iterator<Item = &'static str> {
    let codels = dotgen_codegen::codels::codes::CODES.iter();
    let mut all: Vec<&str> = dotgen_analysis::codes::all()
        .map(|it| it.id)
        .chain(codels.map(|it| it.code.as_str()))
        .collect();
    all.sort_unstable();
    all.into_iter()
}

/// The settings by name, with their schemas.
pub(crate) fn properties() -> Map<String, Value> {
    match settings_schema().get_mut("properties").map(Value::take) {
        Some(Value::Object(properties)) => properties,
        _ => Map::new(),
    }
}

/// The entries of a setting that is a table with fixed ones.
pub(crate) fn entries(setting: &Value) -> Option<Vec<String>> {
    let name = setting["$ref"].as_str()?.rsplit('/').next()?;
    let definition = settings_schema();
    let entries = definition["$defs"][name]["properties"].as_object()?;
    Some(entries.keys().cloned().collect())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::{Value, json};

    /// Freshness: regenerates the committed schema and fails if it had to write.
    #[test]
    fn committed_schema_is_up_to_date() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/dotgen.schema.json");
        let mut fresh =
            serde_json::to_string_pretty(&super::settings_schema()).expect("a schema is JSON");
        fresh.push('\n');
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        if committed != fresh {
            std::fs::create_dir_all(path.parent().expect("has a parent")).expect("docs/");
            std::fs::write(&path, fresh).expect("docs/ is writable");
            panic!("docs/dotgen.schema.json was not up to date; commit the new one");
        }
    }

    /// The extension offers every setting, and none that the server does not know.
    #[test]
    fn extension_offers_the_same_settings() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vscode-extension/package.json");
        let text = std::fs::read_to_string(path).expect("the extension's manifest");
        let manifest: Value = serde_json::from_str(&text).expect("JSON");
        let offered = &manifest["contributes"]["configuration"]["properties"];
        let offered = offered.as_object().expect("settings");
        let properties = super::properties();
        let definitions = &super::settings_schema()["$defs"];
        for (name, schema) in &properties {
            let mut camel = String::new();
            for (index, part) in name.split('-').enumerate() {
                let (first, rest) = part.split_at(1);
                let first = match index {
                    0 => first.to_owned(),
                    _ => first.to_uppercase(),
                };
                camel += &format!("{first}{rest}");
            }
            let setting = offered.get(&format!("dotgen.{camel}"));
            let setting = setting.unwrap_or_else(|| panic!("the extension lacks dotgen.{camel}"));
            let named = schema["$ref"].as_str().and_then(|it| it.rsplit('/').next());
            let ty = match named {
                Some(name) => &definitions[name]["type"],
                None => &schema["type"],
            };
            assert_eq!(&setting["type"], ty, "dotgen.{camel}");
        }
        let unknown = offered.keys().filter(|it| {
            let name = it.strip_prefix("dotgen.").unwrap_or(it);
            let name = name.split('.').next().unwrap_or(name);
            let read = crate::config::from_editor(&json!({ name: {} }));
            read.problems.iter().any(is_unknown)
        });
        assert_eq!(unknown.collect::<Vec<_>>(), Vec::<&String>::new());
    }

    fn is_unknown(problem: &crate::config::Problem) -> bool {
        problem.kind == crate::config::ProblemKind::UnknownKey
    }
}
