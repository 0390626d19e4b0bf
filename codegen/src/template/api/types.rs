//! Methods of types.

use dotgen_analysis::model::{TypeId, TypeKind};
use dotgen_analysis::release::Change;

use super::component::{digest, types};
use super::{Answer, AnswerResult, Lambda, Model, method, wrong_args};
use crate::lang::{PassingMode, label_text, length_of, nested, scope_word, value_text};
use crate::template::object::Object;
use crate::template::{Failure, tcl};

const METHODS: &[&str] = &[
    "kind",
    "name",
    "fullname",
    "scope",
    "fixed",
    "final",
    "parent",
    "nested",
    "types",
    "type",
    "length",
    "value",
    "valuekind",
    "members",
    "discriminator",
    "port",
    "remote",
    "cname",
    "mangle",
    "mapping",
    "declarator",
    "address",
    "dereference",
    "argument",
    "return-value",
    "pass",
    "digest",
    "masquerade",
    "loc",
    "class",
];

pub(super) const CHEAP: &[&str] =
    &["kind", "name", "fullname", "final", "type", "length", "members", "cname", "mangle", "class"];

pub(super) fn call(
    model: &Model<'_>,
    ty: TypeId,
    words: &[String],
    lambda: &mut Lambda<'_>,
) -> AnswerResult {
    let method = method(METHODS, words, "fullname")?;
    let arguments = words.get(1..).unwrap_or_default();
    check_arguments(model, ty, method, arguments)?;
    let spec = model.spec;
    let known_type = spec.ty(ty);
    let mapper = model.mapper();
    let pure = |text: String| Some(Answer::pure(text));
    let answer = match method {
        "kind" => pure(known_type.kind.word().into()),
        "name" => known_type.name.as_ref().and_then(|name| pure(name.to_string())),
        "fullname" => spec.full_name(ty).map(Answer::pure),
        "scope" => {
            let scopes = known_type.scope.iter();
            let scopes =
                scopes.map(|scope| tcl::list([scope_word(scope.kind), scope.name.as_str()]));
            pure(tcl::list(scopes))
        }
        "fixed" => pure(u8::from(fixed(model, ty, spec.types.len())).to_string()),
        "final" => Some(model.type_handle(spec.resolve_alias(ty))),
        "parent" => known_type.parent.map(|parent| model.type_handle(parent)),
        "nested" => Some(model.type_list(nested(spec, ty))),
        "types" => {
            let mut words = vec!["public".to_owned()];
            words.extend_from_slice(arguments);
            return types(model, &Object::Type(ty), &words, lambda);
        }
        "type" => mapper.inner(ty).map(|inner| model.type_handle(inner)),
        "length" => length_of(&known_type.kind).and_then(|length| pure(length.to_string())),
        "value" => value_of(model, ty).and_then(pure),
        "valuekind" => match &known_type.kind {
            TypeKind::Const { value, .. } => pure(value.word().into()),
            _ => None,
        },
        "members" => Some(members_of(model, ty, arguments)),
        "discriminator" => match known_type.kind {
            TypeKind::Union { switch, .. } => Some(model.type_handle(switch)),
            _ => None,
        },
        "port" => match known_type.kind {
            TypeKind::Port { component, port } => Some(model.handle(Object::Port(component, port))),
            _ => None,
        },
        "remote" => match known_type.kind {
            TypeKind::Remote { component, remote } => {
                Some(model.handle(Object::Remote(component, remote)))
            }
            _ => None,
        },
        "cname" | "mangle" | "mapping" | "declarator" | "address" | "dereference" | "argument"
        | "return-value" | "pass" => return mapped(model, ty, method, arguments),
        "digest" => return digest(model, &Object::Type(ty), &[], lambda),
        "masquerade" => {
            let template = arguments.first().map_or(model.template, String::as_str);
            let pairs = known_type.masquerade.iter();
            let found = pairs.filter(|_| known_type.name.is_some()).find(|(of, _)| of == template);
            found.map(|(_, data)| Answer::pure(data.clone()))
        }
        "loc" => {
            let context = spec.body_of(known_type.src);
            model.place(mapper.type_place(ty), context, arguments)?
        }
        _ => pure("type".into()),
    };
    answer.ok_or_else(|| Failure::Error(format!("no such member \"{method}\"")))
}

/// The members of a type, those that match a pattern if one is given.
fn members_of(model: &Model<'_>, ty: TypeId, arguments: &[String]) -> Answer {
    let matches = |member: &TypeId| {
        let name = model.spec.ty(*member).name.as_deref();
        arguments.first().zip(name).is_none_or(|(glob, name)| tcl::glob_match(glob, name))
    };
    let mapper = model.mapper();
    let members = mapper.members(model.spec.resolve_alias(ty)).iter().copied();
    model.type_list(members.filter(matches))
}

/// The value of a constant, or the labels of a member of a union.
fn value_of(model: &Model<'_>, ty: TypeId) -> Option<String> {
    match &model.spec.ty(ty).kind {
        TypeKind::Const { value, .. } => Some(value_text(model.spec, value)),
        TypeKind::UnionMember { labels, .. } => {
            Some(tcl::list(labels.iter().map(|label| label_text(model.spec, label))))
        }
        _ => None,
    }
}

/// Methods that print a type in the language of the template.
fn mapped(model: &Model<'_>, ty: TypeId, method: &str, arguments: &[String]) -> AnswerResult {
    let mapper = model.mapper();
    let argument = |index: usize| arguments.get(index).map_or("", String::as_str);
    let text = match method {
        "cname" => mapper.type_cname(ty)?,
        "mangle" => mapper.mangle(ty)?,
        "mapping" => {
            let object = [crate::lang::MapObject::Type(ty)];
            mapper.mapping(&object, true)?
        }
        "declarator" => mapper.declarator(ty, argument(0))?,
        "address" => mapper.address(ty, argument(0))?,
        "dereference" => {
            let passing = PassingMode::from_name(argument(0));
            // C++ passes by reference for every kind.
            let passing = match (model.language, passing) {
                (crate::lang::Language::Cxx, Err(_)) => PassingMode::Value,
                (_, passing) => passing?,
            };
            mapper.dereference(ty, passing, argument(1))?
        }
        "argument" => {
            let passing = PassingMode::from_name(argument(0))?;
            mapper.argument(ty, passing, argument(1))?
        }
        "return-value" => {
            if arguments.len() > 1 && !model.spec.release.has(Change::ReturnValueVariables) {
                return Err(wrong_args("language::return-value type kind"));
            }
            mapper.return_value_by_name(ty, argument(0), argument(1))?
        }
        _ => {
            let passing = PassingMode::from_name(argument(0))?;
            mapper.pass(ty, passing, argument(1))?
        }
    };
    Ok(Answer::pure(text))
}

fn check_arguments(
    model: &Model<'_>,
    ty: TypeId,
    method: &str,
    arguments: &[String],
) -> Result<(), Failure> {
    let (allowed, usage) = match method {
        "members" => (0..=1, " ?pattern?"),
        "types" => (0..=1, " ?filter?"),
        "declarator" | "address" => (0..=1, " ?var?"),
        "masquerade" => (0..=1, " ?template?"),
        "loc" => (0..=1, " ?element?"),
        "argument" | "return-value" | "pass" | "dereference" => (1..=2, " kind ?var?"),
        _ => (0..=0, ""),
    };
    if allowed.contains(&arguments.len()) {
        return Ok(());
    }
    let handle = model.registry.handle(&Object::Type(ty));
    Err(if usage.is_empty() {
        wrong_args(&format!("{handle} subcommand"))
    } else {
        wrong_args(&format!("{handle} {method}{usage}"))
    })
}

/// Returns true if values of the type have a constant size.
fn fixed(model: &Model<'_>, ty: TypeId, depth: usize) -> bool {
    let Some(depth) = depth.checked_sub(1) else {
        return false;
    };
    let ty = model.spec.resolve_alias(ty);
    match &model.spec.ty(ty).kind {
        TypeKind::String { bound } => bound.is_some(),
        TypeKind::Sequence { bound: None, .. } | TypeKind::Native => false,
        TypeKind::Sequence { element, .. }
        | TypeKind::Array { element, .. }
        | TypeKind::Optional { element } => fixed(model, *element, depth),
        TypeKind::Struct { members }
        | TypeKind::Union { members, .. }
        | TypeKind::Exception { members } => {
            members.iter().all(|member| fixed(model, *member, depth))
        }
        _ => true,
    }
}
