//! The mapping of specifications to programming languages, as pure functions of the model.
//!
//! A [`Mapper`] answers every question the template language asks about a type or a codel in the
//! current language: its name, how a variable of it is declared, passed, returned and dereferenced,
//! the prototype of a codel, and the whole text of the type definitions. C lives in [`c`], C++ in
//! [`cxx`]; what they share is here.
//!
//! Rules: "Mappings" chapter of the GenoM3 manual.

mod c;
mod c_types;
mod cxx;
mod cxx_types;
mod kind;
mod prototypes;
pub mod text;

use dotgen_analysis::model::{
    Codel, CodelRef, Name, Param, ParamDir, ParamSource, PathElement, Spec, Src, TypeId, TypeKind,
};

pub use kind::{
    dir_word, label_text, length_of, scope_word, service_word, source_word, value_text,
};
pub use prototypes::prototypes;

/// A programming language that templates can select with `lang`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Language {
    /// C, the language at start.
    #[default]
    C,
    /// C++.
    Cxx,
    /// Known by name only: every language procedure fails.
    Tcl,
}

impl Language {
    /// The language of a name as templates and specifications write it.
    pub fn from_name(name: &str) -> Option<Language> {
        match name {
            "c" => Some(Language::C),
            "c++" => Some(Language::Cxx),
            "tcl" => Some(Language::Tcl),
            _ => None,
        }
    }

    /// `c`, `c++`, `tcl`.
    pub fn name(self) -> &'static str {
        match self {
            Language::C => "c",
            Language::Cxx => "c++",
            Language::Tcl => "tcl",
        }
    }
}

/// Why a language question has no answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LangError {
    /// What is wrong, in the words templates see.
    pub message: String,
    /// Raised like `template fatal` (unwinds every level) rather than as a plain Tcl error.
    pub fatal: bool,
}

impl LangError {
    pub(crate) fn error(message: impl Into<String>) -> LangError {
        LangError {
            message: message.into(),
            fatal: false,
        }
    }

    pub(crate) fn fatal(message: impl Into<String>) -> LangError {
        LangError {
            message: message.into(),
            fatal: true,
        }
    }
}

impl std::fmt::Display for LangError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for LangError {}

/// Result of a language question.
pub type LangResult = Result<String, LangError>;

/// A place in a source file as generated code and templates show it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Normalized path of the file.
    pub file: String,
    /// Line, from 1.
    pub line: u32,
    /// Column of the end of the first token, from 1.
    pub column: u32,
}

/// Which token of a declaration GenoM3 takes for its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor<'a> {
    /// The first of what the model points to.
    First,
    /// A keyword before it.
    Keyword(&'static str),
    /// The name a declaration in it gives.
    Named(&'a str),
    /// What follows the direction of a parameter.
    Path,
}

/// Finds the places of the model's items.
pub trait Places {
    /// The place of an item, `None` when it has none.
    fn place(&self, src: Src, anchor: Anchor<'_>) -> Option<Place>;
}

/// Knows no place: mappings then hold no `#line` mark.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoPlaces;

impl Places for NoPlaces {
    fn place(&self, _: Src, _: Anchor<'_>) -> Option<Place> {
        None
    }
}

/// How a value crosses a function boundary.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Passing {
    /// For inputs.
    Value,
    /// For outputs.
    Reference,
}

impl Passing {
    /// Reads `value` or `reference`.
    pub fn from_name(name: &str) -> Result<Passing, LangError> {
        match name {
            "value" => Ok(Passing::Value),
            "reference" => Ok(Passing::Reference),
            _ => Err(LangError::fatal(format!(
                "unknown argument kind \"{name}\": must be value or reference"
            ))),
        }
    }
}

/// Something that has a definition or declaration in generated code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MapObject {
    /// A type object.
    Type(TypeId),
    /// A codel of a component (index into [`Spec::components`]).
    Codel(u32, CodelRef),
}

/// Answers language questions about one specification.
#[derive(Clone, Copy)]
pub struct Mapper<'a> {
    /// The model.
    pub spec: &'a Spec,
    /// Where its items were written; gives the `#line` marks.
    pub places: &'a dyn Places,
    /// The language of the answers.
    pub language: Language,
}

impl<'a> Mapper<'a> {
    /// A mapper to a language.
    pub fn new(spec: &'a Spec, places: &'a dyn Places, language: Language) -> Mapper<'a> {
        Mapper {
            spec,
            places,
            language,
        }
    }

    fn unsupported<T>(&self, procedure: &str) -> Result<T, LangError> {
        Err(LangError::error(format!(
            "invalid command name \"::language::{}::{procedure}\"",
            self.language.name()
        )))
    }

    pub(crate) fn kind(&self, ty: TypeId) -> &'a TypeKind {
        &self.spec.ty(ty).kind
    }

    pub(crate) fn final_kind(&self, ty: TypeId) -> &'a TypeKind {
        self.kind(self.spec.resolve_alias(ty))
    }

    /// The type that a type object is made of: element, aliased type, type of a member, constant
    /// or enumerator, definition of a forward declaration.
    pub fn inner(&self, ty: TypeId) -> Option<TypeId> {
        inner(self.spec, ty)
    }

    pub(crate) fn inner_or_error(&self, ty: TypeId) -> Result<TypeId, LangError> {
        self.inner(ty)
            .ok_or_else(|| LangError::error("no such member \"type\""))
    }

    /// Full name, or the error templates get for an anonymous type.
    pub(crate) fn full_name(&self, ty: TypeId) -> LangResult {
        self.spec
            .full_name(ty)
            .ok_or_else(|| LangError::error("no such member \"fullname\""))
    }

    pub(crate) fn short_name(&self, ty: TypeId) -> Result<&'a Name, LangError> {
        let name = self.spec.ty(ty).name.as_ref();
        name.ok_or_else(|| LangError::error("no such member \"name\""))
    }

    /// A name in the language: scopes joined as the language does, blanks and `+` replaced.
    pub fn cname(&self, name: &str) -> LangResult {
        match self.language {
            Language::C => Ok(text::c_name(name)),
            Language::Cxx => Ok(text::cxx_name(name)),
            Language::Tcl => self.unsupported("cname"),
        }
    }

    /// [`Mapper::cname`] of the full name of a type.
    pub fn type_cname(&self, ty: TypeId) -> LangResult {
        self.cname(&self.full_name(ty)?)
    }

    /// A name for the type that is a valid identifier and different for different types. The same
    /// in every language.
    pub fn mangle(&self, ty: TypeId) -> LangResult {
        let kind = self.kind(ty);
        Ok(match kind {
            TypeKind::Enum { .. }
            | TypeKind::Enumerator { .. }
            | TypeKind::Struct { .. }
            | TypeKind::Union { .. }
            | TypeKind::Exception { .. }
            | TypeKind::Typedef { .. }
            | TypeKind::Native => format!("t{}", self.full_name(ty)?.replace("::", "_")),
            TypeKind::Array { element, .. }
            | TypeKind::Sequence { element, .. }
            | TypeKind::Optional { element } => {
                let length = length_of(kind).map(|l| l.to_string()).unwrap_or_default();
                format!("{}{length}_{}", kind.word(), self.mangle(*element)?)
            }
            TypeKind::String { bound } => {
                format!("string{}", bound.map(|l| l.to_string()).unwrap_or_default())
            }
            TypeKind::StructMember { ty }
            | TypeKind::UnionMember { ty, .. }
            | TypeKind::Const { ty, .. } => self.mangle(*ty)?,
            _ => kind.word().replace(' ', "_"),
        })
    }

    /// The declaration of a variable of a type, or the abstract declarator when `var` is empty.
    pub fn declarator(&self, ty: TypeId, var: &str) -> LangResult {
        match self.language {
            Language::C => c::declarator(self, ty, var),
            Language::Cxx => cxx::declarator(self, ty, var),
            Language::Tcl => self.unsupported("declarator"),
        }
    }

    /// The address of a variable of a type.
    pub fn address(&self, ty: TypeId, var: &str) -> LangResult {
        match self.language {
            Language::C => Ok(c::address(self, ty, var)),
            Language::Cxx => Ok(cxx::address(self, ty, var)),
            Language::Tcl => self.unsupported("address"),
        }
    }

    /// The declaration of a function parameter.
    pub fn argument(&self, ty: TypeId, passing: Passing, var: &str) -> LangResult {
        match self.language {
            Language::C => c::argument(self, ty, passing, var),
            Language::Cxx => cxx::argument(self, ty, passing, var),
            Language::Tcl => self.unsupported("argument"),
        }
    }

    /// The expression that passes a variable for such a parameter.
    pub fn pass(&self, ty: TypeId, passing: Passing, var: &str) -> LangResult {
        match self.language {
            Language::C => c::pass(self, ty, passing, var),
            Language::Cxx => Ok(var.to_owned()),
            Language::Tcl => self.unsupported("pass"),
        }
    }

    /// The value of such a parameter inside the function.
    pub fn dereference(&self, ty: TypeId, passing: Passing, var: &str) -> LangResult {
        match self.language {
            Language::C => Ok(c::dereference(self, ty, passing, var)),
            Language::Cxx => Ok(var.to_owned()),
            Language::Tcl => self.unsupported("dereference"),
        }
    }

    /// The declaration of a returned value.
    pub fn return_value(&self, ty: TypeId, passing: Passing) -> LangResult {
        match self.language {
            Language::C => c::return_value(self, ty, passing),
            Language::Cxx => cxx::argument(self, ty, passing, ""),
            Language::Tcl => self.unsupported("return-value"),
        }
    }

    /// The text that reaches a member from a variable of the type. `path` holds member names and
    /// indexes.
    pub fn member(&self, ty: TypeId, path: &[String]) -> LangResult {
        match self.language {
            Language::C | Language::Cxx => self.access(ty, path),
            Language::Tcl => self.unsupported("member"),
        }
    }

    /// [`Mapper::member`] for a path of the model.
    pub fn member_path(&self, ty: TypeId, path: &[PathElement]) -> LangResult {
        let path: Vec<String> = path
            .iter()
            .map(|element| match element {
                PathElement::Member(name) => name.to_string(),
                PathElement::Index(index) => index.to_string(),
            })
            .collect();
        self.member(ty, &path)
    }

    fn access(&self, ty: TypeId, path: &[String]) -> LangResult {
        let mut out = String::new();
        let mut ty = ty;
        let mut path = path;
        // Each turn without using up an element goes one step down a chain of types.
        let mut steps = self.spec.types.len();
        while let Some((first, rest)) = path.split_first() {
            steps = match steps.checked_sub(1) {
                Some(left) => left,
                None => return Err(LangError::error("type refers to itself")),
            };
            let c = self.language == Language::C;
            let kind = self.kind(ty);
            let word = kind.word();
            match kind {
                TypeKind::Boolean
                | TypeKind::UnsignedShort
                | TypeKind::Short
                | TypeKind::UnsignedLong
                | TypeKind::Long
                | TypeKind::UnsignedLongLong
                | TypeKind::LongLong
                | TypeKind::Float
                | TypeKind::Double
                | TypeKind::Char
                | TypeKind::Octet
                | TypeKind::Enum { .. }
                | TypeKind::Enumerator { .. }
                | TypeKind::String { .. } => {
                    return Err(LangError::fatal(format!("{word} has no member")));
                }
                TypeKind::Array { element, .. } => {
                    out += &format!("[{first}]");
                    (ty, path) = (*element, rest);
                }
                TypeKind::Sequence { element, .. } => {
                    out += &format!("{}[{first}]", if c { "._buffer" } else { "" });
                    (ty, path) = (*element, rest);
                }
                TypeKind::Struct { members } | TypeKind::Union { members, .. } => {
                    let union = matches!(kind, TypeKind::Union { .. });
                    ty = self.find_member(members, word, first)?;
                    out += &format!("{}.{first}", if union { "._u" } else { "" });
                    path = rest;
                }
                TypeKind::Exception { members } if c => {
                    ty = self.find_member(members, word, first)?;
                    out += &format!(".{first}");
                    path = rest;
                }
                TypeKind::Optional { element } => {
                    out += "._value";
                    ty = *element;
                }
                TypeKind::ForwardStruct { .. }
                | TypeKind::ForwardUnion { .. }
                | TypeKind::StructMember { .. }
                | TypeKind::UnionMember { .. }
                | TypeKind::Typedef { .. } => ty = self.inner_or_error(ty)?,
                _ => {
                    return Err(LangError::error(format!(
                        "internal error: unhandled type '{word}'"
                    )));
                }
            }
        }
        Ok(out)
    }

    fn find_member(&self, members: &[TypeId], word: &str, name: &str) -> Result<TypeId, LangError> {
        let named = |id: &&TypeId| self.spec.ty(**id).name.as_deref() == Some(name);
        members
            .iter()
            .find(named)
            .copied()
            .ok_or_else(|| LangError::fatal(format!("{word} has no member {name}")))
    }

    /// The prototype of a codel. `separator` stands between the return type and the name;
    /// `location` puts a `#line` mark in front.
    ///
    /// It is cut into lines as GenoM3 does, which loses a character where an argument holds a comma
    /// (C++ templates): [`Mapper::prototype`] does not.
    pub fn signature(
        &self,
        component: u32,
        codel: &Codel,
        separator: &str,
        location: bool,
    ) -> LangResult {
        let result = self.event_type()?;
        let arguments = self.codel_arguments(component, codel)?;
        let symbol = self.cname(&codel.name)?;
        let prefix = " ".repeat(symbol.chars().count() + 1);
        let call = format!("{symbol}({})", arguments.join(", "));
        let mut out = String::new();
        if location {
            out += &self.line_mark(self.places.place(codel.src, Anchor::First));
            out.push('\n');
        }
        out += result;
        out += separator;
        out += &text::wrap(&call, &prefix, ",", 70);
        Ok(out)
    }

    /// The prototype of a codel as a compiler takes it, cut into lines between arguments only.
    pub fn prototype(&self, component: u32, codel: &Codel, separator: &str) -> LangResult {
        let arguments = self.codel_arguments(component, codel)?;
        let symbol = self.cname(&codel.name)?;
        let indent = symbol.chars().count() + 1;
        let mut out = format!("{}{separator}{symbol}(", self.event_type()?);
        let mut column = indent;
        for (index, argument) in arguments.iter().enumerate() {
            let last = index + 1 == arguments.len();
            let width = argument.chars().count() + 1;
            if index > 0 {
                // As `signature` does: a comma may stand after the last column.
                if column + 1 + width > if last { 70 } else { 71 } {
                    out.push('\n');
                    out += &" ".repeat(indent);
                    column = indent;
                } else {
                    out.push(' ');
                    column += 1;
                }
            }
            out += argument;
            out.push(if last { ')' } else { ',' });
            column += width;
        }
        Ok(out)
    }

    fn event_type(&self) -> Result<&'static str, LangError> {
        match self.language {
            Language::C => Ok("genom_event"),
            Language::Cxx => Ok("genom::event"),
            Language::Tcl => self.unsupported("signature"),
        }
    }

    fn codel_arguments(&self, component: u32, codel: &Codel) -> Result<Vec<String>, LangError> {
        let mut arguments = Vec::with_capacity(codel.params.len() + 1);
        for param in &codel.params {
            let remote = matches!(param.source, ParamSource::Port(_) | ParamSource::Remote(_));
            let passing = match param.dir {
                _ if remote => Passing::Value,
                ParamDir::In => Passing::Value,
                ParamDir::Out | ParamDir::Inout => Passing::Reference,
                ParamDir::Local => {
                    arguments.push(String::new());
                    continue;
                }
            };
            let ty = param_types(self.spec, component, param).1;
            arguments.push(self.argument(ty, passing, &param.name)?);
        }
        match self.language {
            Language::C => arguments.push("const genom_context self".into()),
            _ if arguments.is_empty() => arguments.push("void".into()),
            _ => {}
        }
        Ok(arguments)
    }

    /// A call of a codel with the given arguments.
    pub fn invoke(&self, component: u32, codel: &Codel, arguments: &[String]) -> LangResult {
        let expected = match self.language {
            Language::C => codel.params.len() + 1,
            Language::Cxx => codel.params.len(),
            Language::Tcl => return self.unsupported("invoke"),
        };
        if arguments.len() != expected {
            return Err(LangError::fatal(format!(
                "wrong # arguments in \"{} invoke\":\n{}\nexpecting:\n{}",
                codel.name,
                arguments.join(", "),
                self.signature(component, codel, " ", false)?
            )));
        }
        let symbol = self.cname(&codel.name)?;
        Ok(format!("{symbol}({})", arguments.join(", ")))
    }

    /// The definitions of types and the prototypes of codels, with the includes they need.
    /// `locations` adds `#line` marks.
    pub fn mapping(&self, objects: &[MapObject], locations: bool) -> LangResult {
        match self.language {
            Language::C => c_types::mapping(self, objects, locations),
            Language::Cxx => cxx_types::mapping(self, objects, locations),
            Language::Tcl => self.unsupported("mapping"),
        }
    }

    /// [`Mapper::mapping`] of every type of the specification, in order of creation.
    pub fn mapping_all(&self, locations: bool) -> LangResult {
        let objects: Vec<MapObject> = (0..self.spec.types.len() as u32)
            .map(|i| MapObject::Type(TypeId(i)))
            .collect();
        self.mapping(&objects, locations)
    }

    /// A comment in the language.
    pub fn comment(&self, text: &str) -> LangResult {
        match self.language {
            Language::C => Ok(text::c_comment(text)),
            Language::Cxx => Ok(text::cxx_comment(text)),
            Language::Tcl => self.unsupported("comment"),
        }
    }

    /// The file extension of sources or headers.
    pub fn file_extension(&self, header: bool) -> LangResult {
        match (self.language, header) {
            (Language::C | Language::Cxx, true) => Ok(".h".into()),
            (Language::C, false) => Ok(".c".into()),
            (Language::Cxx, false) => Ok(".cc".into()),
            (Language::Tcl, _) => self.unsupported("fileext"),
        }
    }

    /// `#line` mark of an item, starting with a newline; empty when its place is unknown.
    pub(crate) fn line_mark(&self, place: Option<Place>) -> String {
        match place {
            Some(place) => format!(
                "\n#line {} \"{}\"",
                place.line,
                place.file.replace('"', "\\\"")
            ),
            None => String::new(),
        }
    }

    /// The place of a type.
    pub(crate) fn type_place(&self, ty: TypeId) -> Option<Place> {
        let it = self.spec.ty(ty);
        let keyword = match &it.kind {
            TypeKind::Const { .. } if it.name.is_some() => "const",
            // The ids have no keyword but their name.
            TypeKind::Struct { .. } if it.name.as_deref() != Some("ids") => "struct",
            TypeKind::Union { .. } => "union",
            TypeKind::ForwardStruct { .. } => "struct",
            TypeKind::ForwardUnion { .. } => "union",
            TypeKind::Native => "native",
            TypeKind::Port { .. } => "port",
            TypeKind::PauseEvent => "pause",
            TypeKind::Remote { component, remote } => {
                let remote = &self.spec.components[*component as usize].remotes[*remote as usize];
                service_word(remote.kind)
            }
            _ => return self.places.place(it.src, Anchor::First),
        };
        self.places.place(it.src, Anchor::Keyword(keyword))
    }

    pub(crate) fn type_mark(&self, ty: TypeId, wanted: bool) -> String {
        if wanted {
            self.line_mark(self.type_place(ty))
        } else {
            String::new()
        }
    }

    /// Types defined inside a struct, union or exception, in order of creation.
    pub fn nested(&self, ty: TypeId) -> Vec<TypeId> {
        nested(self.spec, ty)
    }

    /// Members of a kind: members, cases or enumerators.
    pub(crate) fn members(&self, ty: TypeId) -> &'a [TypeId] {
        match self.kind(ty) {
            TypeKind::Struct { members }
            | TypeKind::Union { members, .. }
            | TypeKind::Exception { members } => members,
            TypeKind::Enum { enumerators } => enumerators,
            _ => &[],
        }
    }
}

/// The type a parameter's path starts from, and its own. Ports and remotes are passed as objects:
/// they have their own types, whatever data they give.
pub fn param_types(spec: &Spec, component: u32, param: &Param) -> (TypeId, TypeId) {
    let component = &spec.components[component as usize];
    match param.source {
        ParamSource::Port(port) => {
            let ty = component.ports[port as usize].ty;
            (ty, ty)
        }
        ParamSource::Remote(remote) => {
            let ty = component.remotes[remote as usize].ty;
            (ty, ty)
        }
        ParamSource::Ids => (component.ids.unwrap_or(param.base), param.ty),
        ParamSource::Local(_) => (param.base, param.ty),
    }
}

/// See [`Mapper::inner`].
pub fn inner(spec: &Spec, ty: TypeId) -> Option<TypeId> {
    match spec.ty(ty).kind {
        TypeKind::Enumerator { enumeration, .. } => Some(enumeration),
        TypeKind::Array { element, .. }
        | TypeKind::Sequence { element, .. }
        | TypeKind::Optional { element } => Some(element),
        TypeKind::StructMember { ty }
        | TypeKind::UnionMember { ty, .. }
        | TypeKind::Typedef { ty }
        | TypeKind::Const { ty, .. } => Some(ty),
        TypeKind::ForwardStruct { definition } | TypeKind::ForwardUnion { definition } => {
            definition
        }
        _ => None,
    }
}

/// See [`Mapper::nested`].
pub fn nested(spec: &Spec, ty: TypeId) -> Vec<TypeId> {
    let kinds = |kind: &TypeKind| {
        matches!(
            kind,
            TypeKind::Struct { .. } | TypeKind::Union { .. } | TypeKind::Enum { .. }
        )
    };
    let all = spec.types.iter().enumerate();
    all.filter(|(_, it)| it.parent == Some(ty) && kinds(&it.kind))
        .map(|(index, _)| TypeId(index as u32))
        .collect()
}
