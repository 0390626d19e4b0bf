//! JSON Schema of the inputs and outputs of a component: requests, replies, exceptions and ports, in the JSON
//! of GenoM3's clients.
//!
//! In that JSON a struct is an object of its members. A union is `{ "d": discriminator, "u": { member: value
//! } }`. An enumerator is its name, with or without its scope. An absent optional value and a number that is
//! NaN or infinite are `null`.

use std::collections::BTreeMap;

use dotgen_analysis::model::{Component, Param, ParamDir, Spec, TypeId, TypeKind};
use serde_json::{Map, Value, json};

pub(super) fn schema(spec: &Spec, component: &Component) -> Value {
    let mut types = Types { spec, definitions: BTreeMap::new() };
    let mut services = Map::new();
    for service in &component.services {
        let params = |wanted: [ParamDir; 2], needed: bool| -> Vec<&Param> {
            let params = service.params.iter();
            let params = params.filter(|param| wanted.contains(&param.dir));
            params.filter(|param| !needed || param.init.is_none()).collect()
        };
        let input = params([ParamDir::In, ParamDir::Inout], false);
        let needed = params([ParamDir::In, ParamDir::Inout], true);
        let output = params([ParamDir::Out, ParamDir::Inout], false);
        let needed = needed.iter().map(|param| param.name.as_str());
        let mut parts = Map::new();
        parts.insert("input".into(), types.params(&input, needed.collect()));
        let given = output.iter().map(|param| param.name.as_str());
        parts.insert("output".into(), types.params(&output, given.collect()));
        let throws: Vec<Value> = component
            .throws
            .iter()
            .chain(&service.throws)
            .map(|exception| types.exception(*exception))
            .collect();
        if !throws.is_empty() {
            parts.insert("exception".into(), json!({ "oneOf": throws }));
        }
        let kind = service.kind.word();
        let mut value = json!({ "title": kind, "type": "object", "properties": parts,
                             "additionalProperties": false });
        describe(&mut value, service.doc.as_deref());
        services.insert(service.name.to_string(), value);
    }
    let mut ports = Map::new();
    for port in &component.ports {
        let mut value = types.of(port.data);
        if port.multiple {
            value = json!({ "type": "object", "additionalProperties": value });
        }
        describe(&mut value, port.doc.as_deref());
        ports.insert(port.name.to_string(), value);
    }
    let object = |properties: Map<String, Value>| json!({ "type": "object", "properties": properties, "additionalProperties": false });
    let mut out = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": component.name.as_str(),
        "type": "object",
        "properties": { "services": object(services), "ports": object(ports) },
        "additionalProperties": false,
        "$defs": types.definitions,
    });
    describe(&mut out, component.doc.as_deref());
    out
}

fn describe(schema: &mut Value, doc: Option<&str>) {
    if let Some(doc) = doc.filter(|doc| !doc.is_empty()) {
        schema["description"] = json!(doc);
    }
}

/// Definitions of named types, in order of first use.
struct Types<'a> {
    spec: &'a Spec,
    definitions: BTreeMap<String, Value>,
}

impl Types<'_> {
    fn params(&mut self, params: &[&Param], required: Vec<&str>) -> Value {
        let mut properties = Map::new();
        for param in params {
            let mut value = self.of(param.ty);
            let doc = param.init.as_ref().and_then(|init| init.doc.as_deref());
            describe(&mut value, doc);
            properties.insert(param.name.to_string(), value);
        }
        let mut out = json!({ "type": "object", "properties": properties,
                              "additionalProperties": false });
        if !required.is_empty() {
            out["required"] = json!(required);
        }
        out
    }

    /// `{ "ex": NAME, "detail": … }`.
    fn exception(&mut self, id: TypeId) -> Value {
        let name = self.spec.full_name(id).unwrap_or_default();
        let mut properties = json!({ "ex": { "const": name } });
        if let TypeKind::Exception { members } = &self.spec.ty(id).kind
            && !members.is_empty()
        {
            properties["detail"] = self.of(id);
        }
        json!({ "type": "object", "properties": properties, "required": ["ex"] })
    }

    /// A reference to a named type, or the schema itself.
    fn of(&mut self, id: TypeId) -> Value {
        let ty = self.spec.ty(id);
        let target = match &ty.kind {
            TypeKind::ForwardStruct { definition } | TypeKind::ForwardUnion { definition } => {
                return definition.map_or_else(|| json!({}), |definition| self.of(definition));
            }
            TypeKind::StructMember { ty } | TypeKind::UnionMember { ty, .. } => {
                return self.of(*ty);
            }
            TypeKind::Const { ty, .. } => return self.of(*ty),
            TypeKind::Struct { .. }
            | TypeKind::Union { .. }
            | TypeKind::Enum { .. }
            | TypeKind::Exception { .. }
            | TypeKind::Typedef { .. } => self.spec.full_name(id),
            _ => None,
        };
        let Some(name) = target else {
            return self.body(id);
        };
        let name = name.trim_start_matches("::").to_owned();
        if !self.definitions.contains_key(&name) {
            // A type may contain itself, in a sequence.
            self.definitions.insert(name.clone(), json!({}));
            let body = self.body(id);
            self.definitions.insert(name.clone(), body);
        }
        json!({ "$ref": format!("#/$defs/{name}") })
    }

    fn body(&mut self, id: TypeId) -> Value {
        let spec = self.spec;
        let kind = &spec.ty(id).kind;
        if let Some((bits, signed)) = kind.integer() {
            return crate::codels::schema::integer(bits, signed);
        }
        match kind {
            TypeKind::Boolean => json!({ "type": "boolean" }),
            TypeKind::Char => json!({ "type": "string", "minLength": 1, "maxLength": 1 }),
            TypeKind::Float | TypeKind::Double => json!({ "type": ["number", "null"] }),
            TypeKind::String { bound: None } => json!({ "type": "string" }),
            // The C type of that length ends with a zero.
            TypeKind::String { bound: Some(bound) } => {
                json!({ "type": "string", "maxLength": bound.saturating_sub(1) })
            }
            TypeKind::Array { element, length } => json!({
                "type": "array", "items": self.of(*element), "minItems": length, "maxItems": length,
            }),
            TypeKind::Sequence { element, bound } => {
                let mut schema = json!({ "type": "array", "items": self.of(*element) });
                if let Some(bound) = bound {
                    schema["maxItems"] = json!(bound);
                }
                schema
            }
            TypeKind::Optional { element } => {
                json!({ "anyOf": [self.of(*element), { "type": "null" }] })
            }
            TypeKind::Enum { enumerators } => {
                let mut names: Vec<String> = Vec::new();
                let full = enumerators.iter().filter_map(|enumerator| spec.full_name(*enumerator));
                let short =
                    enumerators.iter().filter_map(|enumerator| spec.ty(*enumerator).name.as_ref());
                for name in full.chain(short.map(ToString::to_string)) {
                    if !names.contains(&name) {
                        names.push(name);
                    }
                }
                json!({ "enum": names })
            }
            TypeKind::Struct { members } | TypeKind::Exception { members } => self.members(members),
            TypeKind::Union { switch, members } => {
                let switch = self.of(*switch);
                let members = self.members(members);
                json!({
                    "type": "object",
                    "properties": { "d": switch, "u": members },
                    "required": ["d"],
                    "additionalProperties": false,
                })
            }
            TypeKind::Typedef { ty } => self.of(*ty),
            TypeKind::Enumerator { .. } => {
                json!({ "const": spec.full_name(id).unwrap_or_default() })
            }
            // Data of the component's own, or of any type, may have any form.
            _ => json!({}),
        }
    }

    fn members(&mut self, members: &[TypeId]) -> Value {
        let mut properties = Map::new();
        for member in members {
            let name = self.spec.ty(*member).name.clone().unwrap_or_default();
            properties.insert(name.to_string(), self.of(*member));
        }
        json!({ "type": "object", "properties": properties, "additionalProperties": false })
    }
}
