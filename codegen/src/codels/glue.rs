//! The glue between the codels of a component and a host that runs them: one source in the language of the
//! codels, compiled with them into one shared object.
//!
//! It contains the data of a server (the ids, the parameters of the activities, the data of the ports) and
//! calls the codels by their prototypes. A host calls the six C functions in [`ENTRIES`]. Services, codels
//! and ports have the numbers of the model. The head of `glue/prelude.h` describes how values are passed;
//! [`value`](super::value) reads and writes the same bytes.

mod calls;
mod ports;
mod release;
mod types;

use dotgen_analysis::model::{Name, Param, ParamSource, TypeId, TypeKind};
use rustc_hash::{FxHashMap, FxHashSet};

use super::expected::Expected;
use super::stub::types_header;
use crate::lang::{LangError, LangResult, Language, Mapper, param_types};

const PRELUDE: &str = include_str!("glue/prelude.h");
const PRELUDE_C: &str = include_str!("glue/prelude_c.h");

/// Names of the functions that a host calls:
///
/// - `int make(service, instance, bytes, size)`: begins an activity or a request, with these inputs; not 0 if
///   the bytes are not valid inputs;
/// - `void run(codel, instance, struct { bytes, size, room } *)`: runs a codel and appends its result;
/// - `void end(service, instance, buffer)`: appends the outputs, and frees them;
/// - `board *share(port, id, board *)`: sets the new address of the data of an input port (`struct
///   glue_board`); returns the previous one;
/// - `void drop(buffer)`: frees the bytes of a buffer;
/// - `void asks(function)`: sets the function that calls services of other components (`glue_asks`).
///
/// All numbers are `uint32_t`, sizes `size_t`.
pub const ENTRIES: [&str; 6] = [
    "dotgen_glue_make",
    "dotgen_glue_run",
    "dotgen_glue_end",
    "dotgen_glue_share",
    "dotgen_glue_drop",
    "dotgen_glue_asks",
];

/// The source. Codels of the functions in `missing` are not called: the host must not run them.
///
/// # Errors
/// A declaration of the component has no mapping to the language.
pub fn source(expected: &Expected<'_>, missing: &FxHashSet<Name>) -> LangResult {
    let mut glue = Glue {
        missing,
        mapper: expected.mapper(),
        expected,
        numbers: FxHashMap::default(),
        order: Vec::new(),
    };
    let component = expected.component();
    if let Some(ids) = component.ids {
        glue.number(ids);
    }
    for service in &component.services {
        for param in &service.params {
            glue.number(param.ty);
        }
    }
    for port in &component.ports {
        glue.number(port.data);
    }
    for remote in &component.remotes {
        for param in &remote.params {
            glue.number(param.ty);
        }
    }
    for ty in &expected.spec.types {
        if let TypeKind::Exception { members } = &ty.kind {
            for &member in members {
                _ = glue.number(member);
            }
        }
    }
    let mut out = format!("#include \"{}\"\n\n{PRELUDE}", types_header(expected));
    if !glue.is_cxx() {
        out += PRELUDE_C;
    }
    out += &glue.types()?;
    out += &glue.ports()?;
    out += &glue.services()?;
    out += &glue.codels()?;
    out += &glue.entries();
    Ok(out)
}

struct Glue<'a, 'e> {
    mapper: Mapper<'a>,
    expected: &'e Expected<'a>,
    missing: &'e FxHashSet<Name>,
    /// Numbers of the types that are passed, by type without aliases.
    numbers: FxHashMap<TypeId, usize>,
    /// Those types, each before the types it contains.
    order: Vec<TypeId>,
}

impl<'a> Glue<'a, '_> {
    fn is_cxx(&self) -> bool {
        self.mapper.language == Language::Cxx
    }

    fn kind(&self, ty: TypeId) -> &'a TypeKind {
        self.mapper.final_kind(ty)
    }

    /// The number of a type, which also numbers the types it contains.
    fn number(&mut self, ty: TypeId) -> usize {
        let ty = self.expected.spec.resolve_alias(ty);
        if let Some(&known) = self.numbers.get(&ty) {
            return known;
        }
        let number = self.order.len();
        self.numbers.insert(ty, number);
        self.order.push(ty);
        match &self.expected.spec.ty(ty).kind {
            TypeKind::Struct { members } | TypeKind::Exception { members } => {
                for &member in members {
                    _ = self.number(member);
                }
            }
            TypeKind::Union { switch, members } => {
                self.number(*switch);
                for &member in members {
                    _ = self.number(member);
                }
            }
            TypeKind::Array { element, .. }
            | TypeKind::Sequence { element, .. }
            | TypeKind::Optional { element } => _ = self.number(*element),
            _ => {}
        }
        number
    }

    /// The number of a type that has one.
    fn known(&self, ty: TypeId) -> Result<usize, LangError> {
        let ty = self.expected.spec.resolve_alias(ty);
        let known = self.numbers.get(&ty).copied();
        known.ok_or_else(|| LangError::error("a type has no place in the glue"))
    }

    /// The object that a parameter of a codel refers to, as a variable.
    fn variable(&self, param: &Param) -> LangResult {
        let (base, _) = param_types(self.expected.spec, self.expected.component, param);
        let member = || self.mapper.member_path(base, &param.path);
        Ok(match param.source {
            ParamSource::Ids => format!("glue_ids{}", member()?),
            ParamSource::Local(Some(at)) => format!("glue_p->v{at}{}", member()?),
            ParamSource::Port(at) => format!("glue_port_{at}"),
            ParamSource::Remote(at) => format!("glue_remote_{at}"),
            ParamSource::Local(None) | ParamSource::Opaque => {
                let name = &param.name;
                let why = format!("`{name}` stands for something that is not declared");
                return Err(LangError::error(why));
            }
        })
    }
}
