//! Type stubs of a component for the Python client (`clients/python`): the type of `load("NAME")`, with
//! values as in the JSON of docs/socket.md.

use std::collections::{HashMap, HashSet};

use dotgen_analysis::model::{Component, Param, PortDir, Service, Spec, TypeId, TypeKind};

use crate::codels::value::{is_input, is_output};

/// Reserved words of Python.
const KEYWORDS: &[&str] = &[
    "False", "None", "True", "and", "as", "assert", "async", "await", "break", "class", "continue",
    "def", "del", "elif", "else", "except", "finally", "for", "from", "global", "if", "import",
    "in", "is", "lambda", "nonlocal", "not", "or", "pass", "raise", "return", "try", "while",
    "with", "yield",
];

/// Names that a stub uses itself.
const RESERVED_NAMES: &[&str] = &[
    "Activity",
    "Any",
    "Callable",
    "Dict",
    "InputPort",
    "List",
    "Literal",
    "Optional",
    "Port",
    "TypedDict",
    "bool",
    "float",
    "int",
    "overload",
    "str",
];

pub(super) fn stub(spec: &Spec, component: &Component) -> String {
    let class = class_name(&component.name);
    let taken =
        RESERVED_NAMES.iter().chain(KEYWORDS).map(|reserved_name| (*reserved_name).to_owned());
    let mut types = Types {
        taken: taken.chain([class.clone()]).collect(),
        names: HashMap::new(),
        text: String::new(),
        spec,
    };
    let mut members = String::new();
    doc(&mut members, component.doc.as_deref(), "    ");
    for service in &component.services {
        if !KEYWORDS.contains(&service.name.as_str()) {
            types.service(service, &mut members);
        }
    }
    let services: HashSet<&str> =
        component.services.iter().map(|service| service.name.as_str()).collect();
    for port in &component.ports {
        let class = match port.dir {
            PortDir::In => "InputPort",
            PortDir::Out => "Port",
        };
        // A service of the same name is the attribute.
        let name = port.name.as_str();
        if !KEYWORDS.contains(&name) && !services.contains(name) {
            members += &format!("    {name}: {class}[{}]\n", types.of(port.data));
        }
    }
    if members.is_empty() {
        members += "    pass\n";
    }
    format!(
        "# What `load(\"{}\")` returns. Written by `dotgen generate python`.\n\
         from typing import Any, Callable, Dict, List, Literal, Optional, TypedDict, overload\n\n\
         from dotgen import Activity, InputPort, Port\n\n\
         {}class {class}:\n{members}",
        component.name, types.text
    )
}

/// The name of a class: `pump` is `Pump`, `color_tracker` is `ColorTracker`.
fn class_name(component: &str) -> String {
    let mut out = String::new();
    for word in component.split('_') {
        let mut letters = word.chars();
        out.extend(letters.next().map(|letter| letter.to_ascii_uppercase()));
        out.push_str(letters.as_str());
    }
    if out.starts_with(|character: char| character.is_ascii_alphabetic())
        && !RESERVED_NAMES.contains(&out.as_str())
    {
        out
    } else {
        format!("Component{out}")
    }
}

/// A docstring, if there is any text.
fn doc(out: &mut String, doc: Option<&str>, indentation: &str) {
    if let Some(doc) = doc.filter(|doc| !doc.is_empty()) {
        *out += &format!("{indentation}{}\n", quoted(doc));
    }
}

/// A string literal of Python, whose escapes are the same as those of JSON.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// Definitions of types, in order of first use.
struct Types<'s> {
    spec: &'s Spec,
    names: HashMap<TypeId, String>,
    taken: HashSet<String>,
    text: String,
}

impl Types<'_> {
    fn service(&mut self, service: &Service, out: &mut String) {
        let name = &service.name;
        let inputs: Vec<&Param> = service.params.iter().filter(|param| is_input(param)).collect();
        let outputs: Vec<&Param> = service.params.iter().filter(|param| is_output(param)).collect();
        let result = match outputs.as_slice() {
            [] => "None".to_owned(),
            [one] => self.of(one.ty),
            several => {
                let members = several.iter().map(|param| (param.name.to_string(), param.ty));
                let wanted = self.free(&format!("{name}_outputs"));
                self.dictionary(&wanted, members.collect());
                wanted
            }
        };
        let plain = |param: &&Param| {
            !KEYWORDS.contains(&param.name.as_str())
                && !["self", "ack"].contains(&param.name.as_str())
        };
        let parameters = match inputs.iter().all(plain) {
            true if inputs.is_empty() => "*, ".to_owned(),
            true => {
                // A missing input has its default value, or zero.
                let all = inputs
                    .iter()
                    .map(|input| format!("{}: {} = ..., ", input.name, self.of(input.ty)));
                all.collect::<String>() + "*, "
            }
            // Inputs can be passed in order, or as a dictionary with `**`.
            false => "*args: Any, ".to_owned(),
        };
        let rest = if inputs.iter().all(plain) { "" } else { ", **inputs: Any" };
        // An input hides an option of the same name.
        let is_free = |option: &str| !inputs.iter().any(|input| input.name == option);
        let mut options = String::new();
        if is_free("callback") {
            options += &format!(", callback: Callable[[Activity[{result}]], object] = ...");
        }
        if is_free("timeout") {
            options += ", timeout: float = ...";
        }
        for (ack, result) in [
            ("ack: Literal[False] = ...", result.clone()),
            ("ack: Literal[True]", format!("Activity[{result}]")),
        ] {
            *out += &format!(
                "    @overload\n    def {name}(self, {parameters}{ack}{options}{rest}) -> {result}:"
            );
            match service.doc.as_deref().filter(|doc| !doc.is_empty()) {
                None => *out += " ...\n",
                described => {
                    out.push('\n');
                    doc(out, described, "        ");
                }
            }
        }
    }

    /// A name for a definition that no other definition has.
    fn free(&mut self, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        let mut count = 2;
        while !self.taken.insert(name.clone()) {
            name = format!("{wanted}_{count}");
            count += 1;
        }
        name
    }

    fn dictionary(&mut self, name: &str, members: Vec<(String, TypeId)>) {
        let members: Vec<String> = members
            .into_iter()
            .map(|(name, ty)| format!("{}: {}", quoted(&name), self.of(ty)))
            .collect();
        // In this form a member may have any name.
        self.text +=
            &format!("{name} = TypedDict({}, {{{}}})\n\n", quoted(name), members.join(", "));
    }

    /// The Python type of a type. Types with members get a definition.
    fn of(&mut self, id: TypeId) -> String {
        let spec = self.spec;
        match &spec.ty(id).kind {
            TypeKind::ForwardStruct { definition } | TypeKind::ForwardUnion { definition } => {
                definition.map_or_else(|| "Any".to_owned(), |definition| self.of(definition))
            }
            TypeKind::StructMember { ty }
            | TypeKind::UnionMember { ty, .. }
            | TypeKind::Const { ty, .. }
            | TypeKind::Typedef { ty } => self.of(*ty),
            TypeKind::Boolean => "bool".to_owned(),
            TypeKind::Octet
            | TypeKind::Char
            | TypeKind::Short
            | TypeKind::UnsignedShort
            | TypeKind::Long
            | TypeKind::UnsignedLong
            | TypeKind::LongLong
            | TypeKind::UnsignedLongLong => "int".to_owned(),
            // NaN and infinity are `null`. The type omits that rare case.
            TypeKind::Float | TypeKind::Double => "float".to_owned(),
            TypeKind::String { .. } => "str".to_owned(),
            TypeKind::Array { element, .. } | TypeKind::Sequence { element, .. } => {
                format!("List[{}]", self.of(*element))
            }
            TypeKind::Optional { element } => format!("Optional[{}]", self.of(*element)),
            TypeKind::Enum { enumerators } => {
                let names =
                    enumerators.iter().filter_map(|enumerator| spec.ty(*enumerator).name.as_ref());
                let names: Vec<String> = names.map(|name| quoted(name.as_str())).collect();
                if names.is_empty() {
                    "str".to_owned()
                } else {
                    format!("Literal[{}]", names.join(", "))
                }
            }
            TypeKind::Struct { members } => {
                let members = members.clone();
                self.defined(id, |types, name| {
                    let named = |ty: TypeId| {
                        let name = types.spec.ty(ty).name.as_ref();
                        (name.map(ToString::to_string).unwrap_or_default(), ty)
                    };
                    let members = members.into_iter().map(named).collect();
                    types.dictionary(name, members);
                })
            }
            // `_d` and the selected member, whose type depends on `_d`.
            TypeKind::Union { .. } => "Dict[str, Any]".to_owned(),
            _ => "Any".to_owned(),
        }
    }

    /// The name of a type, which is defined at its first use. A type may contain itself.
    fn defined(&mut self, id: TypeId, define: impl FnOnce(&mut Self, &str)) -> String {
        if let Some(name) = self.names.get(&id) {
            return name.clone();
        }
        let full = self.spec.full_name(id).unwrap_or_else(|| "::anonymous".to_owned());
        let name = self.free(&full.trim_start_matches("::").replace("::", "_"));
        self.names.insert(id, name.clone());
        define(self, &name);
        name
    }
}
