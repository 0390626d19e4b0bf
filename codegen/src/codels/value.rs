//! Values as bytes, in the form of the [`glue`](super::glue), and as JSON.
//!
//! | IDL | JSON |
//! | --- | --- |
//! | numbers, `boolean` | numbers, `true` and `false`; a float that is NaN or infinite is `null` |
//! | `octet`, `char` | a number |
//! | `string` | a string |
//! | enumeration | the name of the enumerator; a number is read too |
//! | `sequence`, array | a list |
//! | `optional` | `null` or the value |
//! | structure | an object with all members; in input, a missing member is zero |
//! | union | an object with `_d` and the selected member |

mod write;

use dotgen_analysis::model::{
    InitValue, Initializer, Label, Param, ParamDir, PathElement, Service, Spec, TypeId, TypeKind,
    Value as Constant,
};
use dotgen_syntax::suggestion::advice;
use serde_json::{Map, Value};

/// Maximum depth of types within types; deeper values are refused.
pub(super) const DEPTH: usize = 64;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ValueError {
    /// The place in the value: `.pos[2].x`.
    pub at: String,
    /// The error, as a predicate: `has to be a number`.
    pub what: String,
}

impl std::fmt::Display for ValueError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.at.is_empty() {
            write!(f, "the value {}", self.what)
        } else {
            write!(f, "`{}` {}", self.at, self.what)
        }
    }
}

impl std::error::Error for ValueError {}

pub(super) fn wrong<T>(at: &str, wanted: impl Into<String>) -> Result<T, ValueError> {
    Err(ValueError { at: at.to_owned(), what: format!("has to be {}", wanted.into()) })
}

/// The error for an unknown name, with the most similar known name, or else all known names.
fn unknown<T>(at: &str, what: &str, name: &str, known: &[&str]) -> Result<T, ValueError> {
    Err(ValueError { at: at.to_owned(), what: format!("is not {what}; {}", advice(name, known)) })
}

/// Values of one specification.
#[derive(Debug, Clone, Copy)]
pub struct Values<'s> {
    spec: &'s Spec,
}

impl<'s> Values<'s> {
    /// The values of a specification's types.
    pub fn new(spec: &'s Spec) -> Self {
        Values { spec }
    }

    /// The inputs of a service, from an object by the names of its parameters. A missing input has its
    /// default, or is zero.
    ///
    /// # Errors
    /// A value does not fit its parameter, or the parameter does not exist.
    pub fn inputs(
        &self,
        service: &Service,
        given: &Map<String, Value>,
    ) -> Result<Vec<u8>, ValueError> {
        let inputs = || service.params.iter().filter(|param| is_input(param));
        if let Some(unknown) =
            given.keys().find(|key| !inputs().any(|input| input.name == key.as_str()))
        {
            let known: Vec<&str> = inputs().map(|input| input.name.as_str()).collect();
            return self::unknown(unknown, "an input of the service", unknown, &known);
        }
        let mut out = Vec::new();
        for param in inputs() {
            let default = self.default_of(param);
            let value = given.get(param.name.as_str()).or(default.as_ref());
            let value = value.unwrap_or(&Value::Null);
            self.write(param.ty, value, param.name.as_str(), DEPTH, &mut out)?;
        }
        Ok(out)
    }

    /// The outputs of a service, as an object.
    ///
    /// # Errors
    /// The bytes are not outputs of the service.
    pub fn outputs(&self, service: &Service, bytes: &[u8]) -> Result<Value, ValueError> {
        let mut reader = Reader { bytes };
        let mut out = Map::new();
        let outputs = service.params.iter().filter(|param| is_output(param));
        for param in outputs {
            let value = self.read(param.ty, &mut reader, DEPTH)?;
            out.insert(param.name.to_string(), value);
        }
        Ok(Value::Object(out))
    }

    /// The value of a type.
    ///
    /// # Errors
    /// The bytes are not a value of the type.
    pub fn decode(&self, ty: TypeId, bytes: &[u8]) -> Result<Value, ValueError> {
        self.read(ty, &mut Reader { bytes }, DEPTH)
    }

    /// The bytes of a value.
    ///
    /// # Errors
    /// The value is not of the type.
    pub fn encode(&self, ty: TypeId, value: &Value) -> Result<Vec<u8>, ValueError> {
        let mut out = Vec::new();
        self.write(ty, value, "", DEPTH, &mut out)?;
        Ok(out)
    }

    /// The layout of a type's bytes. Types of different specifications have equal layouts exactly if they
    /// have the same content.
    pub fn layout(&self, ty: TypeId) -> String {
        let mut out = String::new();
        self.lay_out(ty, &mut Vec::new(), &mut out);
        out
    }

    fn lay_out(&self, ty: TypeId, around: &mut Vec<TypeId>, out: &mut String) {
        let ty = self.spec.resolve_alias(ty);
        if let Some(level) = around.iter().position(|&candidate| candidate == ty) {
            *out += &format!("^{level}");
            return;
        }
        around.push(ty);
        let kind = self.kind(ty);
        *out += kind.word();
        match kind {
            TypeKind::String { bound: Some(bound) } => *out += &bound.to_string(),
            TypeKind::Array { element, length } => {
                *out += &format!("[{length}]");
                self.lay_out(*element, around, out);
            }
            TypeKind::Sequence { element, .. } | TypeKind::Optional { element } => {
                out.push('<');
                self.lay_out(*element, around, out);
                out.push('>');
            }
            TypeKind::Enum { enumerators } => *out += &enumerators.len().to_string(),
            TypeKind::Struct { members } => {
                out.push('{');
                for &member in members {
                    *out += &format!("{}:", self.name(member));
                    self.lay_out(member, around, out);
                }
                out.push('}');
            }
            TypeKind::Union { switch, members } => {
                out.push('(');
                self.lay_out(*switch, around, out);
                for &member in members {
                    if let TypeKind::UnionMember { labels, .. } = &self.spec.ty(member).kind {
                        for label in labels {
                            *out += &match label {
                                Label::Default => " default".to_owned(),
                                Label::Case(value) => format!(" {}", self.number_of(value)),
                            };
                        }
                    }
                    out.push(':');
                    self.lay_out(member, around, out);
                }
                out.push(')');
            }
            _ => {}
        }
        out.push(';');
        around.pop();
    }

    /// The default of a parameter, if the specification has one.
    pub fn default_of(&self, param: &Param) -> Option<Value> {
        let init = param.init.as_ref()?;
        self.initial(init)
    }

    pub(super) fn initial(&self, init: &Initializer) -> Option<Value> {
        match &init.value {
            InitValue::Void => None,
            InitValue::Scalar(value) => Some(self.constant(value)),
            InitValue::Compound(members) => {
                let kind = self.kind(init.ty);
                if let TypeKind::Struct { .. } | TypeKind::Union { .. } = kind {
                    let members = members.iter().filter_map(|member| match &member.member {
                        Some(PathElement::Member(name)) => {
                            Some((name.to_string(), self.initial(member)?))
                        }
                        _ => None,
                    });
                    return Some(Value::Object(members.collect()));
                }
                let mut out = Vec::new();
                for member in members {
                    let at = match member.member {
                        Some(PathElement::Index(at)) => usize::try_from(at).ok()?,
                        _ => out.len(),
                    };
                    if at > 1 << 20 {
                        return None;
                    }
                    out.resize(out.len().max(at + 1), Value::Null);
                    out[at] = self.initial(member).unwrap_or(Value::Null);
                }
                Some(Value::Array(out))
            }
        }
    }

    fn constant(&self, value: &Constant) -> Value {
        match value {
            Constant::Bool(flag) => (*flag).into(),
            Constant::Uint(number) => (*number).into(),
            Constant::Int(number) => (*number).into(),
            Constant::Float(number) => (*number).into(),
            Constant::Char(character) => character.bytes().next().unwrap_or(0).into(),
            Constant::String(text) => text.clone().into(),
            Constant::Enum(enumeration) => self.name(*enumeration).into(),
        }
    }

    pub(super) fn kind(&self, ty: TypeId) -> &'s TypeKind {
        &self.spec.ty(self.spec.resolve_alias(ty)).kind
    }

    fn name(&self, ty: TypeId) -> String {
        let name = self.spec.ty(ty).name.as_ref();
        name.map(ToString::to_string).unwrap_or_default()
    }

    /// The member of a union that a discriminator selects.
    pub(super) fn chosen(&self, members: &[TypeId], number: i64) -> Option<TypeId> {
        let labels = |ty: &TypeId| match &self.spec.ty(*ty).kind {
            TypeKind::UnionMember { labels, .. } => labels.as_slice(),
            _ => &[],
        };
        let case = |ty: &&TypeId| {
            let mut labels = labels(ty).iter();
            labels
                .any(|label| matches!(label, Label::Case(value) if self.number_of(value) == number))
        };
        let default = |ty: &&TypeId| labels(ty).contains(&Label::Default);
        let found = members.iter().find(case);
        found.or_else(|| members.iter().find(default)).copied()
    }

    fn number_of(&self, value: &Constant) -> i64 {
        match value {
            Constant::Bool(flag) => i64::from(*flag),
            Constant::Uint(number) => i64::try_from(*number).unwrap_or(i64::MAX),
            Constant::Int(number) => *number,
            Constant::Float(_) | Constant::String(_) => 0,
            Constant::Char(character) => character.bytes().next().map_or(0, i64::from),
            Constant::Enum(enumeration) => match self.spec.ty(*enumeration).kind {
                TypeKind::Enumerator { value, .. } => i64::from(value),
                _ => 0,
            },
        }
    }

    /// The number of a discriminator.
    fn discriminator(&self, switch: TypeId, value: &Value) -> i64 {
        match (self.kind(switch), value) {
            (TypeKind::Enum { enumerators }, Value::String(name)) => {
                let name = name.rsplit("::").next().unwrap_or(name);
                let at = enumerators.iter().position(|&enumerator| self.name(enumerator) == name);
                at.map_or(0, |place| i64::try_from(place).unwrap_or(0))
            }
            (_, Value::Bool(flag)) => i64::from(*flag),
            (_, kind) => kind.as_i64().unwrap_or(0),
        }
    }

    fn read(&self, ty: TypeId, from: &mut Reader<'_>, depth: usize) -> Result<Value, ValueError> {
        let Some(depth) = depth.checked_sub(1) else {
            return wrong("", "a value that is less deep");
        };
        Ok(match self.kind(ty) {
            TypeKind::Boolean => (from.take::<1>()?[0] != 0).into(),
            TypeKind::Octet => from.take::<1>()?[0].into(),
            TypeKind::Char => i8::from_ne_bytes(from.take()?).into(),
            TypeKind::Short => i16::from_ne_bytes(from.take()?).into(),
            TypeKind::UnsignedShort => u16::from_ne_bytes(from.take()?).into(),
            TypeKind::Long => i32::from_ne_bytes(from.take()?).into(),
            TypeKind::UnsignedLong => u32::from_ne_bytes(from.take()?).into(),
            TypeKind::LongLong => i64::from_ne_bytes(from.take()?).into(),
            TypeKind::UnsignedLongLong => u64::from_ne_bytes(from.take()?).into(),
            // The decimal form of the float, without the additional digits of a double.
            TypeKind::Float => match f32::from_ne_bytes(from.take()?).to_string().parse::<f64>() {
                Ok(number) => number.into(),
                Err(_) => Value::Null,
            },
            TypeKind::Double => f64::from_ne_bytes(from.take()?).into(),
            TypeKind::Enum { enumerators } => {
                let number = u32::from_ne_bytes(from.take()?);
                match enumerators.get(number as usize) {
                    Some(&enumerator) => self.name(enumerator).into(),
                    None => number.into(),
                }
            }
            TypeKind::String { .. } => {
                let length = u32::from_ne_bytes(from.take()?);
                String::from_utf8_lossy(from.some(length as usize)?).into()
            }
            TypeKind::Array { element, length } => {
                let all = (0..*length).map(|_| self.read(*element, from, depth));
                Value::Array(all.collect::<Result<_, _>>()?)
            }
            TypeKind::Sequence { element, .. } => {
                let length = u32::from_ne_bytes(from.take()?);
                let all = (0..length).map(|_| self.read(*element, from, depth));
                Value::Array(all.collect::<Result<_, _>>()?)
            }
            TypeKind::Optional { element } => match from.take::<1>()?[0] {
                0 => Value::Null,
                _ => self.read(*element, from, depth)?,
            },
            TypeKind::Struct { members } | TypeKind::Exception { members } => {
                let mut out = Map::new();
                for &member in members {
                    out.insert(self.name(member), self.read(member, from, depth)?);
                }
                Value::Object(out)
            }
            TypeKind::Union { switch, members } => {
                let chooses = self.read(*switch, from, depth)?;
                let number = self.discriminator(*switch, &chooses);
                let mut out = Map::from_iter([("_d".to_owned(), chooses)]);
                if let Some(member) = self.chosen(members, number) {
                    out.insert(self.name(member), self.read(member, from, depth)?);
                }
                Value::Object(out)
            }
            _ => {
                from.take::<1>()?;
                Value::Null
            }
        })
    }
}

/// True if a request has a value for a parameter.
pub fn is_input(param: &Param) -> bool {
    matches!(param.dir, ParamDir::In | ParamDir::Inout)
}

/// True if an answer has a value for a parameter.
pub fn is_output(param: &Param) -> bool {
    matches!(param.dir, ParamDir::Out | ParamDir::Inout)
}

/// Bytes of the glue to read.
#[derive(Debug, Clone)]
pub struct Reader<'b> {
    pub(super) bytes: &'b [u8],
}

impl<'b> Reader<'b> {
    /// Reads from the begin of bytes.
    pub fn new(bytes: &'b [u8]) -> Self {
        Reader { bytes }
    }

    /// Number of remaining bytes.
    pub fn left(&self) -> usize {
        self.bytes.len()
    }

    /// Takes a number of bytes.
    ///
    /// # Errors
    /// There are fewer.
    pub fn some(&mut self, count: usize) -> Result<&'b [u8], ValueError> {
        match self.bytes.split_at_checked(count) {
            Some((taken, rest)) => {
                self.bytes = rest;
                Ok(taken)
            }
            None => wrong("", "a value that does not break off"),
        }
    }

    /// Takes the bytes of a number, which are in the order of this machine.
    ///
    /// # Errors
    /// There are fewer.
    pub fn take<const N: usize>(&mut self) -> Result<[u8; N], ValueError> {
        let bytes = self.some(N)?;
        bytes.try_into().or_else(|_| wrong("", "a value"))
    }
}
