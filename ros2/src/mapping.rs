//! Messages for types of GenoM3.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use dotgen_analysis::model::{Scope, ScopeKind, Spec, Src, TypeId, TypeKind};
use dotgen_analysis::phrase::Phrase;

use crate::description::{Base, Count, Field, FieldType, Types};
use crate::{common, masquerade, names};

/// The reason for which a part of the model has no form in ROS 2, and its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Obstacle {
    /// The reason and the remedy.
    pub why: String,
    /// The place in the model.
    pub src: Src,
}

/// Maximum depth of types within types. Values that are deeper are refused too.
const DEPTH: usize = 60;

/// A place for a name of a message whose type has none.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    pub(crate) package: String,
    /// The local name.
    pub(crate) local: String,
    /// The place in the model.
    pub(crate) src: Src,
}

/// Messages of one specification.
#[derive(Debug)]
pub struct Mapping<'s> {
    spec: &'s Spec,
    /// All messages, services and actions.
    pub types: Types,
    /// By message of an enumeration: the names and values of its constants.
    pub constants: BTreeMap<String, Vec<(String, usize)>>,
    /// By package: the path of its modules.
    packages: BTreeMap<String, String>,
    /// By full name: the part of the model and its place.
    origins: BTreeMap<String, (Phrase, Src)>,
    /// By generated files: the full name and its part of the model.
    files: BTreeMap<String, (String, Phrase)>,
    /// Messages of types that are complete.
    done: HashMap<TypeId, String>,
    /// Types whose messages are being made.
    around: Vec<TypeId>,
    /// Number of types around the current one.
    depth: usize,
}

impl<'s> Mapping<'s> {
    /// A mapping without messages, except for those of ROS 2.
    pub fn new(spec: &'s Spec) -> Self {
        Mapping {
            spec,
            types: Types::standard(),
            constants: BTreeMap::new(),
            packages: BTreeMap::new(),
            origins: BTreeMap::new(),
            files: BTreeMap::new(),
            done: HashMap::new(),
            around: Vec::new(),
            depth: 0,
        }
    }

    /// The package of modules, if no other modules have it.
    pub(crate) fn package(&mut self, scope: &[Scope], src: Src) -> Result<String, Obstacle> {
        let modules = scope.iter().filter(|scope| scope.kind == ScopeKind::Module);
        let modules: Vec<&str> = modules.map(|module| module.name.as_str()).collect();
        let obstacle = |why| Obstacle { why, src };
        let package = names::package(modules.iter().copied()).map_err(obstacle)?;
        let path = modules.join("::");
        match self.packages.get(&package) {
            Some(other) if *other != path => Err(obstacle(format!(
                "`{other}` and `{path}` both become the package `{package}`: rename one"
            ))),
            _ => {
                self.packages.insert(package.clone(), path);
                Ok(package)
            }
        }
    }

    /// Reserves a full name, and the generated files of this name, for a part of the model.
    pub(crate) fn claim(&mut self, name: &str, origin: Phrase, src: Src) -> Result<(), Obstacle> {
        let files = names::files(name);
        let why = match self.files.get(&files) {
            Some((same, other)) if same == name && *other != origin => {
                format!("{other} and {origin} both become `{name}`: rename one")
            }
            Some((close, other)) if close != name => {
                format!("{other} and {origin} both become the files `{files}`: rename one")
            }
            _ => {
                self.files.insert(files, (name.to_owned(), origin.clone()));
                self.origins.insert(name.to_owned(), (origin, src));
                return Ok(());
            }
        };
        Err(Obstacle { why, src })
    }

    /// The packages of the specification, in order.
    pub fn packages(&self) -> impl Iterator<Item = &str> {
        self.packages.keys().map(String::as_str)
    }

    /// The part of the model with a full name, and its place.
    pub fn origin(&self, name: &str) -> Option<(&Phrase, Src)> {
        self.origins.get(name).map(|(part, src)| (part, *src))
    }

    /// A field for a member or parameter.
    pub(crate) fn field(
        &mut self,
        name: &str,
        ty: TypeId,
        place: &Place,
    ) -> Result<Field, Obstacle> {
        let obstacle = |why| Obstacle { why, src: place.src };
        let field = names::field(name).map_err(obstacle)?;
        let local = names::camel(name).map_err(obstacle)?;
        let place = Place { local: place.local.clone() + &local, ..place.clone() };
        let mut out = Field::new(field, self.field_type(ty, &place)?);
        out.constants = self.constants_of(ty);
        Ok(out)
    }

    /// The message with the constants of an enumeration, also of one in sequences, arrays or optionals.
    fn constants_of(&mut self, mut ty: TypeId) -> Option<String> {
        loop {
            ty = self.spec.resolve_alias(ty);
            ty = match &self.spec.ty(ty).kind {
                TypeKind::Enum { .. } => return self.name_of(ty).ok(),
                TypeKind::Array { element, .. }
                | TypeKind::Sequence { element, .. }
                | TypeKind::Optional { element } => *element,
                _ => return None,
            };
        }
    }

    /// The message of a value that is not a field of another: a structure or union itself, a message of
    /// `std_msgs`, or a message with the field `data`.
    pub(crate) fn message(&mut self, ty: TypeId, place: &Place) -> Result<String, Obstacle> {
        let field_type = self.field_type(ty, place)?;
        if field_type.count == Count::One {
            let local = match &field_type.base {
                Base::Nested(name) => return Ok(name.clone()),
                Base::BoundedString(_) => None,
                Base::Int8 => Some("Int8"),
                Base::Uint8 => Some("UInt8"),
                Base::Int16 => Some("Int16"),
                Base::Uint16 => Some("UInt16"),
                Base::Int32 => Some("Int32"),
                Base::Uint32 => Some("UInt32"),
                Base::Int64 => Some("Int64"),
                Base::Uint64 => Some("UInt64"),
                Base::Float32 => Some("Float32"),
                Base::Float64 => Some("Float64"),
                Base::Bool => Some("Bool"),
                Base::String => Some("String"),
            };
            if let Some(local) = local {
                let name = format!("std_msgs/msg/{local}");
                self.types.add(&name, vec![Field::new("data", field_type)]);
                return Ok(name);
            }
        }
        self.wrapped(ty, field_type, place)
    }

    /// Adds the message of a type with a name.
    pub(crate) fn named(&mut self, ty: TypeId) -> Result<(), Obstacle> {
        let place =
            Place { package: String::new(), local: String::new(), src: self.spec.ty(ty).src };
        self.field_type(ty, &place).map(|_| ())
    }

    /// A message with the field `data`. It has the name of the typedef, if there is one.
    fn wrapped(&mut self, ty: TypeId, data: FieldType, place: &Place) -> Result<String, Obstacle> {
        let ty = match self.spec.ty(ty).kind {
            TypeKind::StructMember { ty } | TypeKind::UnionMember { ty, .. } => ty,
            _ => ty,
        };
        let is_typedef = matches!(self.spec.ty(ty).kind, TypeKind::Typedef { .. });
        let (name, origin) = match self.spec.full_name(ty) {
            Some(full) if is_typedef => (self.name_of(ty)?, Phrase::name(full)),
            _ => {
                let name = format!("{}/msg/{}", place.package, place.local);
                let origin = Phrase::words("the type at ").and_name(place.local.as_str());
                (name, origin)
            }
        };
        self.claim(&name, origin, place.src)?;
        let fields = vec![Field::new("data", data)];
        // Parameters of different services may give types without a name the same one.
        if self.types.fields(&name).is_some_and(|field| *field != *fields) {
            return Err(Obstacle {
                why: format!("two types would be `{name}`: name one by a typedef"),
                src: place.src,
            });
        }
        self.types.add(&name, fields);
        Ok(name)
    }

    /// The full name of the message of a type with a name.
    fn name_of(&mut self, ty: TypeId) -> Result<String, Obstacle> {
        let known_type = self.spec.ty(ty);
        let package = self.package(&known_type.scope, known_type.src)?;
        let (_, local) =
            names::of_type(self.spec, ty).map_err(|why| Obstacle { why, src: known_type.src })?;
        Ok(format!("{package}/msg/{local}"))
    }

    fn field_type(&mut self, ty: TypeId, place: &Place) -> Result<FieldType, Obstacle> {
        if self.depth >= DEPTH {
            return Err(Obstacle {
                why: format!("the type is deeper than {DEPTH} types: make it flatter"),
                src: place.src,
            });
        }
        self.depth += 1;
        let found = self.field_type_here(ty, place);
        self.depth -= 1;
        found
    }

    fn field_type_here(&mut self, ty: TypeId, place: &Place) -> Result<FieldType, Obstacle> {
        let masked = masquerade::nested(self.spec, ty);
        if let Some(message) = masked.map_err(|why| Obstacle { why, src: place.src })? {
            common::add(&message, &mut self.types);
            return Ok(FieldType::nested(message));
        }
        let resolved = self.spec.resolve_alias(ty);
        let kind = &self.spec.ty(resolved).kind;
        let base = match kind {
            TypeKind::Boolean => Base::Bool,
            TypeKind::Octet => Base::Uint8,
            TypeKind::Char => Base::Int8,
            TypeKind::Short => Base::Int16,
            TypeKind::UnsignedShort => Base::Uint16,
            TypeKind::Long => Base::Int32,
            TypeKind::UnsignedLong => Base::Uint32,
            TypeKind::LongLong => Base::Int64,
            TypeKind::UnsignedLongLong => Base::Uint64,
            TypeKind::Float => Base::Float32,
            TypeKind::Double => Base::Float64,
            TypeKind::String { bound: None } => Base::String,
            TypeKind::String { bound: Some(bound) } => Base::BoundedString(*bound),
            TypeKind::Enum { enumerators } => {
                self.enumeration(resolved, enumerators)?;
                Base::Uint32
            }
            TypeKind::Struct { members } | TypeKind::Exception { members } => {
                Base::Nested(self.structure(resolved, None, members)?)
            }
            TypeKind::Union { switch, members } => {
                Base::Nested(self.structure(resolved, Some(*switch), members)?)
            }
            TypeKind::Array { element, length } => {
                return self.array(*element, *length, place);
            }
            TypeKind::Sequence { element, bound } => {
                let base = self.element(*element, place)?;
                let count = bound.map_or(Count::Any, Count::AtMost);
                return Ok(FieldType { base, count });
            }
            TypeKind::Optional { element } => {
                let base = self.element(*element, place)?;
                let count = Count::AtMost(1);
                return Ok(FieldType { base, count });
            }
            TypeKind::Unknown => {
                return Err(Obstacle {
                    why: "a type is not known: correct the errors of the specification".to_owned(),
                    src: place.src,
                });
            }
            other => {
                let name = self.spec.full_name(resolved).unwrap_or_default();
                return Err(Obstacle {
                    why: format!("ROS 2 has no `{}` types, as `{name}` is one", other.word()),
                    src: self.spec.ty(resolved).src,
                });
            }
        };
        Ok(base.into())
    }

    /// An array; arrays in an array are flattened.
    fn array(
        &mut self,
        element: TypeId,
        length: u64,
        place: &Place,
    ) -> Result<FieldType, Obstacle> {
        if let TypeKind::Array { .. } = self.spec.ty(self.spec.resolve_alias(element)).kind {
            let inner = self.field_type(element, place)?;
            if let Count::Exactly(inner_length) = inner.count {
                let Some(length) = length.checked_mul(inner_length) else {
                    return Err(Obstacle {
                        why: "the array has too many elements: make it shorter".to_owned(),
                        src: place.src,
                    });
                };
                let count = Count::Exactly(length);
                return Ok(FieldType { count, ..inner });
            }
        }
        let base = self.element(element, place)?;
        let count = Count::Exactly(length);
        Ok(FieldType { base, count })
    }

    /// The type of the elements of a sequence, array or optional. Elements of several values are messages.
    fn element(&mut self, ty: TypeId, place: &Place) -> Result<Base, Obstacle> {
        let place = Place { local: format!("{}Item", place.local), ..place.clone() };
        let field_type = self.field_type(ty, &place)?;
        match field_type.count {
            Count::One => Ok(field_type.base),
            _ => Ok(Base::Nested(self.wrapped(ty, field_type, &place)?)),
        }
    }

    /// The message of a structure, exception or union. A union has a discriminator, and a sequence of at most
    /// one element for each branch.
    fn structure(
        &mut self,
        ty: TypeId,
        switch: Option<TypeId>,
        members: &[TypeId],
    ) -> Result<String, Obstacle> {
        if let Some(name) = self.done.get(&ty) {
            return Ok(name.clone());
        }
        let (spec, src) = (self.spec, self.spec.ty(ty).src);
        let full = spec.full_name(ty).unwrap_or_default();
        if self.around.contains(&ty) {
            return Err(Obstacle {
                why: format!(
                    "a message cannot contain itself, as `{full}` does: refer to it by a number"
                ),
                src,
            });
        }
        let name = self.name_of(ty)?;
        self.claim(&name, Phrase::name(full.as_str()), src)?;
        let (package, local) = name.split_once("/msg/").unwrap_or_default();
        let place = Place { package: package.to_owned(), local: local.to_owned(), src };
        self.around.push(ty);
        let fields = self.members(switch, members, &place);
        self.around.pop();
        let fields = fields?;
        distinct(&fields, src)?;
        self.types.add(&name, fields);
        self.done.insert(ty, name.clone());
        Ok(name)
    }

    fn members(
        &mut self,
        switch: Option<TypeId>,
        members: &[TypeId],
        place: &Place,
    ) -> Result<Vec<Field>, Obstacle> {
        let mut out = Vec::new();
        if let Some(switch) = switch {
            out.push(self.field("discriminator", switch, place)?);
        }
        for &ty in members {
            let name = self.plain_name(ty);
            let src = self.spec.ty(ty).src;
            let place = Place { src, ..place.clone() };
            let mut field = self.field(&name, ty, &place)?;
            if switch.is_some() {
                if field.ty.count != Count::One {
                    let local = names::camel(&name).unwrap_or_default();
                    let local = place.local.clone() + &local;
                    let place = Place { local, ..place };
                    field.ty = FieldType::nested(self.wrapped(ty, field.ty, &place)?);
                }
                field.ty.count = Count::AtMost(1);
            }
            out.push(field);
        }
        Ok(out)
    }

    /// The constants of an enumeration.
    fn enumeration(&mut self, ty: TypeId, enumerators: &[TypeId]) -> Result<(), Obstacle> {
        let name = self.name_of(ty)?;
        let src = self.spec.ty(ty).src;
        let full = self.spec.full_name(ty).unwrap_or_default();
        self.claim(&name, Phrase::name(full.as_str()), src)?;
        let mut seen = BTreeSet::new();
        let mut out = Vec::new();
        for (value, &enumerator) in enumerators.iter().enumerate() {
            let src = self.spec.ty(enumerator).src;
            let plain = self.plain_name(enumerator);
            let constant = names::constant(&plain).map_err(|why| Obstacle { why, src })?;
            if !seen.insert(constant.clone()) {
                return Err(Obstacle {
                    why: format!("two enumerators of `{full}` become `{constant}`: rename one"),
                    src,
                });
            }
            out.push((constant, value));
        }
        self.constants.insert(name, out);
        Ok(())
    }

    fn plain_name(&self, ty: TypeId) -> String {
        let name = self.spec.ty(ty).name.as_ref();
        name.map(ToString::to_string).unwrap_or_default()
    }
}

/// Fields of one message have different names.
pub(crate) fn distinct(fields: &[Field], src: Src) -> Result<(), Obstacle> {
    let mut seen = BTreeSet::new();
    match fields.iter().find(|field| !seen.insert(&field.name)) {
        None => Ok(()),
        Some(field) => {
            Err(Obstacle { why: format!("two fields become `{}`: rename one", field.name), src })
        }
    }
}
