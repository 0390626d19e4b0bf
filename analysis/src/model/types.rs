//! Types and constants, as resolved.

use serde::{Deserialize, Serialize};

use super::{ComponentId, Name, PortId, RemoteId, Spec, Src, TypeId};

/// A type object: named types, anonymous types, and other named objects in scopes (constants, members,
/// enumerators, states, ports, remotes).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Type {
    pub kind: TypeKind,
    /// Name inside its scope; `None` for anonymous types.
    pub name: Option<Name>,
    /// Enclosing scopes, outermost first; empty at global scope. An anonymous type has the scopes of the
    /// place where it was written.
    pub scope: Vec<Scope>,
    /// The declaration (its name if it has one).
    pub src: Src,
    /// The struct, union or exception it is nested in.
    pub parent: Option<TypeId>,
    /// `#pragma masquerade TEMPLATE TYPE DATA`: pairs of template and data.
    pub masquerade: Vec<(String, String)>,
}

/// One enclosing scope of a type.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Scope {
    pub kind: ScopeKind,
    pub name: Name,
}

/// Kinds of scope, in the words of the template language.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ScopeKind {
    /// A module, component, interface, or the `pause` scope of a component.
    Module,
    /// A struct (the ids included).
    Struct,
    Union,
    Exception,
}

impl TypeKind {
    /// The number of bits of an integer type, and true if it is signed. A `char` is not an integer here.
    pub fn integer(&self) -> Option<(u32, bool)> {
        Some(match self {
            TypeKind::Octet => (8, false),
            TypeKind::Short => (16, true),
            TypeKind::UnsignedShort => (16, false),
            TypeKind::Long => (32, true),
            TypeKind::UnsignedLong => (32, false),
            TypeKind::LongLong => (64, true),
            TypeKind::UnsignedLongLong => (64, false),
            _ => return None,
        })
    }

    /// Returns true for integers, characters and floating-point numbers.
    pub fn is_number(&self) -> bool {
        matches!(self, TypeKind::Char | TypeKind::Float | TypeKind::Double)
            || self.integer().is_some()
    }

    /// The word for the kind: the IDL name of base types, and the template language's word for others.
    pub fn word(&self) -> &'static str {
        match self {
            TypeKind::Boolean => "boolean",
            TypeKind::Octet => "octet",
            TypeKind::Char => "char",
            TypeKind::Short => "short",
            TypeKind::UnsignedShort => "unsigned short",
            TypeKind::Long => "long",
            TypeKind::UnsignedLong => "unsigned long",
            TypeKind::LongLong => "long long",
            TypeKind::UnsignedLongLong => "unsigned long long",
            TypeKind::Float => "float",
            TypeKind::Double => "double",
            TypeKind::Any => "any",
            TypeKind::String { .. } => "string",
            TypeKind::Array { .. } => "array",
            TypeKind::Sequence { .. } => "sequence",
            TypeKind::Optional { .. } => "optional",
            TypeKind::Enum { .. } => "enum",
            TypeKind::Enumerator { .. } => "enumerator",
            TypeKind::Struct { .. } => "struct",
            TypeKind::StructMember { .. } => "struct member",
            TypeKind::Union { .. } => "union",
            TypeKind::UnionMember { .. } => "union member",
            TypeKind::Exception { .. } => "exception",
            TypeKind::Native => "native",
            TypeKind::Typedef { .. } => "typedef",
            TypeKind::Const { .. } => "const",
            TypeKind::ForwardStruct { .. } => "forward struct",
            TypeKind::ForwardUnion { .. } => "forward union",
            TypeKind::Event => "event",
            TypeKind::PauseEvent => "pause event",
            TypeKind::Port { .. } => "port",
            TypeKind::Remote { .. } => "remote",
            TypeKind::Unknown => "unknown",
        }
    }
}

/// Kinds of type objects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TypeKind {
    Boolean,
    Octet,
    Char,
    Short,
    UnsignedShort,
    Long,
    UnsignedLong,
    LongLong,
    UnsignedLongLong,
    Float,
    Double,
    Any,
    /// `string` or `string<bound>`.
    String {
        bound: Option<u64>,
    },
    /// One dimension; `long a[2][3]` is an array of 2 of an array of 3.
    Array {
        element: TypeId,
        length: u64,
    },
    Sequence {
        element: TypeId,
        bound: Option<u64>,
    },
    Optional {
        element: TypeId,
    },
    Enum {
        enumerators: Vec<TypeId>,
    },
    /// One value of an enum; `value` counts from 0.
    Enumerator {
        enumeration: TypeId,
        value: u32,
    },
    Struct {
        members: Vec<TypeId>,
    },
    StructMember {
        ty: TypeId,
    },
    Union {
        switch: TypeId,
        members: Vec<TypeId>,
    },
    UnionMember {
        ty: TypeId,
        labels: Vec<Label>,
    },
    /// Without members it carries no data and is not a data type.
    Exception {
        members: Vec<TypeId>,
    },
    Native,
    Typedef {
        ty: TypeId,
    },
    /// A named constant, or an anonymous one (the value of a `period`, `priority`, …).
    Const {
        ty: TypeId,
        value: Value,
    },
    /// `struct s;`: `definition` is set once completed.
    ForwardStruct {
        definition: Option<TypeId>,
    },
    /// `union u;`
    ForwardUnion {
        definition: Option<TypeId>,
    },
    /// A state of a state machine.
    Event,
    /// The paused form of a state (`pause::s`); lives in scope `pause` of its component.
    PauseEvent,
    /// The type object of a port; `component` and `port` index into `Spec::components` and
    /// `Component::ports`.
    Port {
        component: ComponentId,
        port: PortId,
    },
    /// The type object of a remote service.
    Remote {
        component: ComponentId,
        remote: RemoteId,
    },
    /// An unresolved type; causes no further diagnostic.
    Unknown,
}

/// A label of a union case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Label {
    /// `default:`
    Default,
    /// `case VALUE:`
    Case(Value),
}
impl Eq for Label {}

/// The value of a constant expression.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", content = "value", rename_all = "lowercase")]
pub enum Value {
    /// `TRUE`, `FALSE`
    Bool(bool),
    /// Unsigned integer (also the result of arithmetic on unsigned operands).
    Uint(u64),
    /// Signed integer.
    Int(i64),
    /// Floating point number.
    Float(f64),
    /// One character, its raw text without quotes.
    Char(String),
    /// Raw text between the quotes, escapes uninterpreted except `\"`.
    String(String),
    /// An enumerator.
    Enum(TypeId),
}

impl Value {
    /// The word for the kind.
    pub fn word(&self) -> &'static str {
        match self {
            Value::Bool(_) => "bool",
            Value::Uint(_) => "uint",
            Value::Int(_) => "int",
            Value::Float(_) => "float",
            Value::Char(_) => "char",
            Value::String(_) => "string",
            Value::Enum(_) => "enum",
        }
    }
}
impl Eq for Value {}

impl Spec {
    /// The type of a member, or the type itself.
    pub fn member_type(&self, id: TypeId) -> TypeId {
        match self.ty(id).kind {
            TypeKind::StructMember { ty } | TypeKind::UnionMember { ty, .. } => ty,
            _ => id,
        }
    }

    /// The text of a type without a name, with `text` for the types in it.
    pub(crate) fn composed_text(
        &self,
        id: TypeId,
        comma: &str,
        text: &dyn Fn(TypeId) -> String,
    ) -> String {
        match &self.ty(id).kind {
            TypeKind::Array { .. } => {
                let (mut element, mut dimensions) = (id, String::new());
                while let Type {
                    kind: TypeKind::Array { element: inner, length },
                    name: None,
                    ..
                } = self.ty(element)
                {
                    dimensions += &format!("[{length}]");
                    element = *inner;
                }
                text(element) + &dimensions
            }
            TypeKind::Sequence { element, bound: Some(bound) } => {
                format!("sequence<{}{comma}{bound}>", text(*element))
            }
            TypeKind::Sequence { element, bound: None } => format!("sequence<{}>", text(*element)),
            TypeKind::Optional { element } => format!("optional<{}>", text(*element)),
            TypeKind::String { bound: Some(bound) } => format!("string<{bound}>"),
            kind => kind.word().to_owned(),
        }
    }
}
