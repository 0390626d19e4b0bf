//! The JSON schema of the settings, from the Rust types.

use serde_json::{Map, Value, json};

use super::Settings;
use dotgen_codegen::codels::drift;

/// The schema of `dotgen.toml`, as committed in `docs/dotgen.schema.json`.
pub(crate) fn settings_schema() -> Value {
    let mut schema = schemars::schema_for!(Settings).to_value();
    let codes: Vec<&str> = codes().collect();
    schema["properties"]["severity"]["propertyNames"] = json!({ "enum": codes });
    drop_absent_defaults(&mut schema);
    schema
}

/// Removes defaults that say that nothing is set.
fn drop_absent_defaults(schema: &mut Value) {
    if let Value::Object(entries) = schema {
        entries.retain(|key, value| key != "default" || !value.is_null());
        entries.values_mut().for_each(drop_absent_defaults);
    }
}

/// The codes of all diagnostics about specifications and their codels, sorted.
pub(crate) fn codes() -> impl Iterator<Item = &'static str> {
    let mut all: Vec<&str> = dotgen_analysis::codes::all()
        .map(|code| code.id)
        .chain(drift::CODES.map(|code| code.0))
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

/// The entries of a setting that is a table with fixed entries.
pub(crate) fn entries(setting: &Value) -> Option<Vec<String>> {
    let name = setting["$ref"].as_str()?.rsplit('/').next()?;
    let definition = settings_schema();
    let entries = definition["$defs"][name]["properties"].as_object()?;
    Some(entries.keys().cloned().collect())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use serde_json::Value;

    /// Regenerates the committed schema, and fails if it was out of date.
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

    /// The extension offers every setting, and none that the server does not know. The entries of tables are
    /// separate settings in the extension. Settings that commands write are not offered.
    #[test]
    fn extension_offers_the_same_settings() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../vscode-extension/package.json");
        let text = std::fs::read_to_string(path).expect("the extension's manifest");
        let manifest: Value = serde_json::from_str(&text).expect("JSON");
        let offered = &manifest["contributes"]["configuration"]["properties"];
        let offered = offered.as_object().expect("settings");
        let mut known: Vec<String> = Vec::new();
        for (name, schema) in super::properties() {
            match super::entries(&schema) {
                _ if name == "generate" => {}
                Some(entries) => {
                    let full = entries.iter().map(|entry| format!("{name}.{entry}"));
                    known.extend(full.map(|format| camel(&format)));
                }
                None => known.push(camel(&name)),
            }
        }
        for name in &known {
            assert!(
                offered.contains_key(&format!("dotgen.{name}")),
                "the extension lacks dotgen.{name}"
            );
        }
        let names = offered.keys().filter_map(|key| key.strip_prefix("dotgen."));
        let table = |name: &str| name.split('.').next().unwrap_or_default().to_owned();
        let unknown =
            names.filter(|name| !crate::config::read::CLIENT_ONLY.contains(&&*table(name)));
        let unknown: Vec<&str> =
            unknown.filter(|name| !known.iter().any(|known| known == name)).collect();
        assert_eq!(unknown, Vec::<&str>::new());
    }

    /// `time-limit` as `timeLimit`
    fn camel(name: &str) -> String {
        let mut parts = name.split('-');
        let mut out = parts.next().unwrap_or_default().to_owned();
        for part in parts {
            let (first, rest) = part.split_at(1);
            out += &first.to_uppercase();
            out += rest;
        }
        out
    }
}
