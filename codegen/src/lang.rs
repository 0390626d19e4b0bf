//! The mapping of specifications to programming languages, as pure functions of the model.
//!
//! A [`Mapper`] answers every question the template language asks about a type or a codel in the current
//! language: its name, the declaration of a variable, how it is passed, returned and dereferenced, the
//! prototype of a codel, and the whole text of the type definitions. C is in [`c`], C++ in [`cxx`]; the code
//! they share is here.
//!
//! Rules: "Mappings" chapter of the GenoM3 manual.

mod access;
mod c;
mod c_types;
mod codel;
mod cxx;
mod cxx_types;
mod kind;
mod prototypes;
pub mod text;

use dotgen_analysis::model::{
    CodelRef, Component, ComponentId, Name, Param, ParamDir, ParamSource, Port, PortDir, Remote,
    Spec, Src, TypeId, TypeKind,
};
use dotgen_analysis::release::Change;

pub use kind::{label_text, length_of, scope_word, value_text};
pub use prototypes::prototypes;

/// The calls of a port, in the order in which they are declared.
pub(crate) fn port_calls(port: &Port) -> &'static [&'static str] {
    match (port.dir, port.multiple) {
        (PortDir::In, _) => &["read"],
        (PortDir::Out, false) => &["write"],
        (PortDir::Out, true) => &["write", "open", "close"],
    }
}

/// The way a parameter of a remote service is passed; `None` for a local one, which is none of its arguments.
pub(crate) fn remote_passing(param: &Param) -> Option<PassingMode> {
    match param.dir {
        ParamDir::In => Some(PassingMode::Value),
        ParamDir::Out | ParamDir::Inout => Some(PassingMode::Reference),
        ParamDir::Local => None,
    }
}

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
    /// The language of a name as written in templates and specifications.
    pub(crate) fn from_name(name: &str) -> Option<Language> {
        match name {
            "c" => Some(Language::C),
            "c++" => Some(Language::Cxx),
            "tcl" => Some(Language::Tcl),
            _ => None,
        }
    }

    /// The language of a component's codels, which selects the file suffix and the mapping.
    pub fn of(component: &Component) -> Language {
        match component.lang.as_deref().and_then(Language::from_name) {
            Some(Language::Cxx) => Language::Cxx,
            _ => Language::C,
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

/// The error of a language question.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LangError {
    /// The message, in the words that templates see.
    pub message: String,
    /// True if it is raised like `template fatal` (unwinds every level), not as a plain Tcl error.
    pub fatal: bool,
}

impl LangError {
    pub(crate) fn error(message: impl Into<String>) -> LangError {
        LangError { message: message.into(), fatal: false }
    }

    pub(crate) fn fatal(message: impl Into<String>) -> LangError {
        LangError { message: message.into(), fatal: true }
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

/// The token of a declaration that GenoM3 uses as its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor<'a> {
    /// The first token of the declaration in the model.
    First,
    /// A keyword before it.
    Keyword(&'static str),
    /// The name a declaration in it gives.
    Named(&'a str),
    /// The token after the direction of a parameter.
    Path,
}

/// Finds the places of the model's items.
pub trait Places {
    /// The place of an item, `None` if it has none.
    fn place(&self, src: Src, anchor: Anchor<'_>) -> Option<Place>;
}

/// Places for models without sources: mappings then hold no `#line` mark.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoPlaces;

impl Places for NoPlaces {
    fn place(&self, _: Src, _: Anchor<'_>) -> Option<Place> {
        None
    }
}

/// The way a value is passed to a function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PassingMode {
    /// For inputs.
    Value,
    /// For outputs.
    Reference,
}

impl PassingMode {
    /// Reads `value` or `reference`.
    ///
    /// # Errors
    /// Fails for any other word.
    pub(crate) fn from_name(name: &str) -> Result<PassingMode, LangError> {
        match name {
            "value" => Ok(PassingMode::Value),
            "reference" => Ok(PassingMode::Reference),
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
    Codel(ComponentId, CodelRef),
}

/// The name of a type whose name is not known.
pub(crate) const OPAQUE: &str = "dotgen_opaque";

/// Answers language questions about one specification.
#[derive(Clone, Copy)]
pub struct Mapper<'a> {
    /// The model.
    pub spec: &'a Spec,
    /// The places of its items, for the `#line` marks.
    pub places: &'a dyn Places,
    /// The language of the answers.
    pub language: Language,
}

impl<'a> Mapper<'a> {
    pub fn new(spec: &'a Spec, places: &'a dyn Places, language: Language) -> Mapper<'a> {
        Mapper { spec, places, language }
    }

    /// Returns true if the specification's release has a change.
    pub(crate) fn has(&self, change: Change) -> bool {
        self.spec.release.has(change)
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
        self.inner(ty).ok_or_else(|| LangError::error("no such member \"type\""))
    }

    /// Full name of a type.
    ///
    /// # Errors
    /// Returns the error that templates get for an anonymous type.
    pub(crate) fn full_name(&self, ty: TypeId) -> LangResult {
        self.spec.full_name(ty).ok_or_else(|| LangError::error("no such member \"fullname\""))
    }

    pub(crate) fn short_name(&self, ty: TypeId) -> Result<&'a Name, LangError> {
        let name = self.spec.ty(ty).name.as_ref();
        name.ok_or_else(|| LangError::error("no such member \"name\""))
    }

    /// A name in the language: scopes joined by the language's separator, blanks and `+` replaced.
    ///
    /// # Errors
    /// Fails in Tcl.
    pub(crate) fn cname(&self, name: &str) -> LangResult {
        match self.language {
            Language::C => Ok(text::c_name(name)),
            Language::Cxx => Ok(text::cxx_name(name)),
            Language::Tcl => self.unsupported("cname"),
        }
    }

    /// [`Mapper::cname`] of the full name of a type.
    ///
    /// # Errors
    /// Fails for an anonymous type, and in Tcl.
    pub(crate) fn type_cname(&self, ty: TypeId) -> LangResult {
        self.cname(&self.full_name(ty)?)
    }

    /// The name of an opaque type.
    ///
    /// # Errors
    /// Fails in Tcl.
    pub(crate) fn opaque_name(&self, ty: TypeId) -> LangResult {
        match self.spec.ty(ty).name {
            Some(_) => self.type_cname(ty),
            None => Ok(OPAQUE.to_owned()),
        }
    }

    /// A name for the type that is a valid identifier and different for different types. The same in every
    /// language.
    ///
    /// # Errors
    /// Fails if a constructed type without a name is inside.
    pub(crate) fn mangle(&self, ty: TypeId) -> LangResult {
        let kind = self.kind(ty);
        Ok(match kind {
            TypeKind::Enum { .. }
            | TypeKind::Enumerator { .. }
            | TypeKind::Struct { .. }
            | TypeKind::Union { .. }
            | TypeKind::Exception { .. }
            | TypeKind::Typedef { .. }
            | TypeKind::Native => format!("t{}", self.full_name(ty)?.replace("::", "_")),
            TypeKind::Port { .. } if self.has(Change::PortManglings) => {
                format!("t{}", self.full_name(ty)?.replace("::", "_"))
            }
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

    /// The declaration of a variable of a type, or the abstract declarator if `var` is empty.
    ///
    /// # Errors
    /// Fails for types that the language cannot declare, such as `any`, and in Tcl.
    pub fn declarator(&self, ty: TypeId, var: &str) -> LangResult {
        match self.language {
            Language::C => c::declarator(self, ty, var),
            Language::Cxx => cxx::declarator(self, ty, var),
            Language::Tcl => self.unsupported("declarator"),
        }
    }

    /// The address of a variable of a type.
    ///
    /// # Errors
    /// Fails in Tcl.
    pub fn address(&self, ty: TypeId, var: &str) -> LangResult {
        match self.language {
            Language::C => Ok(c::address(self, ty, var)),
            Language::Cxx => Ok(cxx::address(self, ty, var)),
            Language::Tcl => self.unsupported("address"),
        }
    }

    /// The declaration of a function parameter.
    ///
    /// # Errors
    /// Fails for types that the language cannot declare or pass, and in Tcl.
    pub fn argument(&self, ty: TypeId, passing: PassingMode, var: &str) -> LangResult {
        match self.language {
            Language::C => c::argument(self, ty, passing, var),
            Language::Cxx => cxx::argument(self, ty, passing, var),
            Language::Tcl => self.unsupported("argument"),
        }
    }

    /// The expression that passes a variable for a parameter of this type and way of passing.
    ///
    /// # Errors
    /// Fails for types that the language cannot pass, and in Tcl.
    pub fn pass(&self, ty: TypeId, passing: PassingMode, var: &str) -> LangResult {
        match self.language {
            Language::C => c::pass(self, ty, passing, var),
            Language::Cxx => Ok(var.to_owned()),
            Language::Tcl => self.unsupported("pass"),
        }
    }

    /// The declarations of the arguments of a remote service.
    ///
    /// # Errors
    /// The same as of [`Mapper::argument`].
    pub(crate) fn remote_arguments(&self, remote: &Remote) -> Result<Vec<String>, LangError> {
        let mut out = Vec::new();
        for param in &remote.params {
            if let Some(passing) = remote_passing(param) {
                out.push(self.argument(param.ty, passing, &param.name)?);
            }
        }
        match self.language {
            Language::Cxx if out.is_empty() => out.push("void".into()),
            Language::Cxx => {}
            _ => out.push("genom_context self".into()),
        }
        Ok(out)
    }

    /// The value of a parameter of this type and way of passing, inside the function.
    ///
    /// # Errors
    /// Fails in Tcl.
    pub fn dereference(&self, ty: TypeId, passing: PassingMode, var: &str) -> LangResult {
        match self.language {
            Language::C => Ok(c::dereference(self, ty, passing, var)),
            Language::Cxx => Ok(var.to_owned()),
            Language::Tcl => self.unsupported("dereference"),
        }
    }

    /// [`Mapper::return_value`] for a way of passing given by its name.
    ///
    /// # Errors
    /// Fails for an unknown name, and like [`Mapper::return_value`].
    pub(crate) fn return_value_by_name(&self, ty: TypeId, passing: &str, var: &str) -> LangResult {
        let parsed = PassingMode::from_name(passing);
        let pointer = matches!(
            self.final_kind(ty),
            TypeKind::Array { .. } | TypeKind::String { bound: Some(_) }
        );
        // GenoM3 joins the two parts of this message with a blank.
        let joined =
            pointer && self.language == Language::C && self.has(Change::ReturnValueVariables);
        match parsed {
            Err(_) if joined => Err(LangError::fatal(format!(
                "unknown argument kind \"{passing}\":  must be value or reference"
            ))),
            parsed => self.return_value(ty, parsed?, var),
        }
    }

    /// The declaration of a returned value, or of a variable if `var` is not empty.
    ///
    /// # Errors
    /// Fails for types that the language cannot declare or return, and in Tcl.
    pub(crate) fn return_value(&self, ty: TypeId, passing: PassingMode, var: &str) -> LangResult {
        match self.language {
            Language::C => c::return_value(self, ty, passing, var),
            Language::Cxx => cxx::argument(self, ty, passing, var),
            Language::Tcl => self.unsupported("return-value"),
        }
    }

    /// The definitions of types and the prototypes of codels, with the includes they need. `locations` adds
    /// `#line` marks.
    ///
    /// # Errors
    /// Fails for types that the language cannot declare, and in Tcl.
    pub fn mapping(&self, objects: &[MapObject], locations: bool) -> LangResult {
        match self.language {
            Language::C => c_types::mapping(self, objects, locations),
            Language::Cxx => cxx_types::mapping(self, objects, locations),
            Language::Tcl => self.unsupported("mapping"),
        }
    }

    /// A comment in the language.
    ///
    /// # Errors
    /// Fails in Tcl.
    pub fn comment(&self, text: &str) -> LangResult {
        match self.language {
            Language::C => Ok(text::c_comment(text)),
            Language::Cxx => Ok(text::cxx_comment(text)),
            Language::Tcl => self.unsupported("comment"),
        }
    }

    /// The file extension of sources or headers, with its dot.
    ///
    /// # Errors
    /// Fails in Tcl.
    pub(crate) fn file_extension(&self, header: bool) -> LangResult {
        match (self.language, header) {
            (Language::C | Language::Cxx, true) => Ok(".h".into()),
            (Language::C, false) => Ok(".c".into()),
            (Language::Cxx, false) => Ok(".cc".into()),
            (Language::Tcl, _) => self.unsupported("fileext"),
        }
    }

    /// `#line` mark of an item, starting with a newline; empty if its place is unknown.
    pub(crate) fn line_mark(&self, place: Option<Place>) -> String {
        match place {
            Some(place) => {
                format!("\n#line {} \"{}\"", place.line, place.file.replace('"', "\\\""))
            }
            None => String::new(),
        }
    }

    pub(crate) fn type_place(&self, ty: TypeId) -> Option<Place> {
        let known_type = self.spec.ty(ty);
        let keyword = match &known_type.kind {
            TypeKind::Const { .. } if known_type.name.is_some() => "const",
            // The ids have no keyword except their name.
            TypeKind::Struct { .. } if known_type.name.as_deref() != Some("ids") => "struct",
            TypeKind::Union { .. } => "union",
            TypeKind::ForwardStruct { .. } => "struct",
            TypeKind::ForwardUnion { .. } => "union",
            TypeKind::Native => "native",
            TypeKind::Port { .. } => "port",
            // The alias of a provided port has the place of the port.
            TypeKind::Typedef { ty } if self.spec.ty(*ty).src == known_type.src => {
                match self.kind(*ty) {
                    TypeKind::Port { .. } => "port",
                    _ => return self.places.place(known_type.src, Anchor::First),
                }
            }
            TypeKind::PauseEvent => "pause",
            TypeKind::Remote { component, remote } => {
                let remote = &self.spec.components[*component].remotes[*remote];
                remote.kind.word()
            }
            _ => return self.places.place(known_type.src, Anchor::First),
        };
        self.places.place(known_type.src, Anchor::Keyword(keyword))
    }

    pub(crate) fn type_mark(&self, ty: TypeId, wanted: bool) -> String {
        if wanted { self.line_mark(self.type_place(ty)) } else { String::new() }
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

/// The type a parameter's path starts from, and its own. Ports and remotes are passed as objects: they have
/// their own types, for any data type.
pub fn param_types(spec: &Spec, component: ComponentId, param: &Param) -> (TypeId, TypeId) {
    let component = &spec.components[component];
    match param.source {
        ParamSource::Port(port) => {
            let ty = component.ports[port].ty;
            (ty, ty)
        }
        ParamSource::Remote(remote) => {
            let ty = component.remotes[remote].ty;
            (ty, ty)
        }
        ParamSource::Ids => (component.ids.unwrap_or(param.base), param.ty),
        ParamSource::Local(_) | ParamSource::Opaque => (param.base, param.ty),
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
        matches!(kind, TypeKind::Struct { .. } | TypeKind::Union { .. } | TypeKind::Enum { .. })
    };
    let all = spec.types.iter_enumerated();
    all.filter(|(_, candidate)| candidate.parent == Some(ty) && kinds(&candidate.kind))
        .map(|(id, _)| id)
        .collect()
}
