//! The JSON document of the model: a snapshot of all its content, and its schema.

use std::{fs, path::Path, sync::Arc};

use camino::Utf8Path;
use dotgen_analysis::{
    host::{AnalysisHost, BatchInput, Input},
    model_json,
};
use dotgen_loaders::EmptyLoader;
use serde_json::Value as Json;

fn folder() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The document of a specification that must be accepted.
fn model(path: &Path) -> Json {
    let text = fs::read_to_string(path).unwrap();
    let host = AnalysisHost::new(Arc::new(EmptyLoader));
    let name = Utf8Path::new("/model").join(path.file_name().unwrap().to_str().unwrap());
    let input = BatchInput {
        inputs: vec![Input::Text { name, text: text.into() }],
        ..BatchInput::default()
    };
    let unit = host.analysis().batch(&input).unwrap();
    assert!(unit.accepted(), "{:#?}", unit.diagnostics);
    model_json::to_json(&unit.spec, Some(&*unit.locations))
}

#[test]
fn everything() {
    let model = model(&folder().join("tests/data/model/everything.gen"));
    insta::assert_json_snapshot!(model);
}

#[test]
fn documents_follow_the_schema() {
    let schema = fs::read_to_string(folder().join("../docs/model.schema.json")).unwrap();
    let schema: Json = serde_json::from_str(&schema).unwrap();
    let model = model(&folder().join("tests/data/model/everything.gen"));
    let mut problems = Vec::new();
    validate(&schema, &schema, &model, "model", &mut problems);
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// Every type object in order of creation, `KIND NAME`.
fn types(text: &str) -> String {
    let host = AnalysisHost::new(Arc::new(EmptyLoader));
    let input = BatchInput {
        inputs: vec![Input::Text { name: "/types.gen".into(), text: text.into() }],
        ..BatchInput::default()
    };
    let unit = host.analysis().batch(&input).unwrap();
    assert!(unit.accepted(), "{:#?}", unit.diagnostics);
    let spec = &unit.spec;
    let mut out = String::new();
    for (id, ty) in spec.types.iter_enumerated() {
        let kind = format!("{:?}", ty.kind);
        let kind = kind.split([' ', '{']).next().unwrap_or_default();
        let name = spec.full_name(id).unwrap_or_default();
        out.push_str(format!("{kind} {name}").trim_end());
        out.push('\n');
    }
    out
}

#[test]
fn types_are_in_order_of_creation() {
    let found = types(
        r"
struct node;
struct node { sequence<node> children; };
enum mode { SLOW, FAST };
const long N = 2;
typedef double row[2][3];
component arm {
  ids { long a; };
  port in row goal;
  ids { mode m; };
  task main { period 2 ms; codel<start> run(in goal) yields tick; codel<tick> work() yields pause::tick, ether; };
};
",
    );
    expect_test::expect![[r"
        ForwardStruct ::node
        Sequence
        StructMember ::node::children
        Struct ::node
        Enumerator ::SLOW
        Enumerator ::FAST
        Enum ::mode
        Long
        Const ::N
        Double
        Array
        Array
        Typedef ::row
        Event ::arm::ether
        Event ::arm::start
        Event ::arm::stop
        Long
        StructMember ::arm::ids::a
        Port ::arm::goal
        StructMember ::arm::ids::m
        Struct ::arm::ids
        Double
        Const
        Event ::arm::tick
        PauseEvent ::arm::pause::tick
        Double
        Const
    "]]
    .assert_eq(&found);
}

#[test]
fn imported_ids_keep_their_members() {
    let found = types(
        r"
interface base { ids { long a; }; };
component arm { provides base; ids { long b; }; attribute get(out a, out b); };
",
    );
    expect_test::expect![[r"
        Long
        StructMember ::base::ids::a
        Struct ::base::ids
        Event ::arm::ether
        Event ::arm::start
        Event ::arm::stop
        StructMember ::arm::ids::a
        Long
        StructMember ::arm::ids::b
        Struct ::arm::ids
    "]]
    .assert_eq(&found);
}

/// Checks the parts of JSON schema that dotgen's schema uses, and also that every key is described.
fn validate(root: &Json, schema: &Json, value: &Json, at: &str, problems: &mut Vec<String>) {
    if let Some(reference) = schema["$ref"].as_str() {
        let target = root.pointer(reference.trim_start_matches('#')).unwrap();
        return validate(root, target, value, at, problems);
    }
    let matches = |name: &str| match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "integer" => value.is_u64(),
        "number" => value.is_number(),
        other => panic!("unknown type {other}"),
    };
    let fits = match &schema["type"] {
        Json::String(name) => matches(name),
        Json::Array(names) => names.iter().any(|name| matches(name.as_str().unwrap())),
        _ => true,
    };
    let listed = schema["enum"].as_array();
    if !fits || listed.is_some_and(|enumeration| !enumeration.contains(value)) {
        problems.push(format!("{at}: {value} is not {schema}"));
    }
    for key in schema["required"].as_array().into_iter().flatten() {
        if value.get(key.as_str().unwrap()).is_none() {
            problems.push(format!("{at}: {key} is missing"));
        }
    }
    if let (Some(properties), Some(fields)) = (schema["properties"].as_object(), value.as_object())
    {
        for (key, field) in fields {
            match properties.get(key) {
                Some(schema) => validate(root, schema, field, &format!("{at}.{key}"), problems),
                None => problems.push(format!("{at}.{key} is not described")),
            }
        }
    }
    if let (Some(schema), Some(fields)) = (schema.get("additionalProperties"), value.as_object()) {
        for (key, field) in fields {
            validate(root, schema, field, &format!("{at}.{key}"), problems);
        }
    }
    if let (Some(schema), Some(items)) = (schema.get("items"), value.as_array()) {
        for (i, item) in items.iter().enumerate() {
            validate(root, schema, item, &format!("{at}[{i}]"), problems);
        }
    }
}
