//! Memory of requests in C. The glue frees the memory of a request's inputs when the request ends, except
//! memory that a codel has assigned to the ids or a port. After each codel, `glue_keep_N` searches for such
//! memory while its locks are held. In C++ values own their memory.

use std::fmt::Write as _;

use dotgen_analysis::model::{Codel, Param, ParamDir, ParamSource, PortDir, TypeId, TypeKind};
use rustc_hash::FxHashSet;

use super::Glue;
use crate::lang::{LangError, LangResult};

impl Glue<'_, '_> {
    /// True if values of the type own memory: unbounded strings and sequences, and types that contain these.
    fn owns(&self, ty: TypeId) -> bool {
        self.owns_within(ty, &mut FxHashSet::default())
    }

    fn owns_within(&self, ty: TypeId, outer: &mut FxHashSet<TypeId>) -> bool {
        let ty = self.expected.spec.resolve_alias(ty);
        if self.is_cxx() || !outer.insert(ty) {
            return false;
        }
        match self.kind(ty) {
            TypeKind::String { bound: None } | TypeKind::Sequence { bound: None, .. } => true,
            TypeKind::Struct { members } | TypeKind::Union { members, .. } => {
                members.iter().any(|&member| self.owns_within(member, outer))
            }
            TypeKind::Array { element, .. }
            | TypeKind::Sequence { element, .. }
            | TypeKind::Optional { element } => self.owns_within(*element, outer),
            _ => false,
        }
    }

    /// The prototypes and the functions `glue_keep_N`.
    pub(super) fn keep_functions(&self) -> Result<(String, String), LangError> {
        let (mut prototypes, mut functions) = (String::new(), String::new());
        for (number, &ty) in self.order.iter().enumerate() {
            if self.owns(ty) {
                let head = format!("static inline void\nglue_keep_{number}(glue_t{number} *x)");
                _ = writeln!(prototypes, "{head};");
                _ = write!(functions, "\n{head}\n{{\n{}}}\n", self.keep(ty)?);
            }
        }
        Ok((prototypes, functions))
    }

    /// The body for a type that owns memory.
    fn keep(&self, ty: TypeId) -> LangResult {
        let of = |before: &str, ty: TypeId, value: &str| -> LangResult {
            Ok(if self.owns(ty) {
                format!("{before}glue_keep_{}({value});\n", self.known(ty)?)
            } else {
                String::new()
            })
        };
        Ok(match self.kind(ty) {
            TypeKind::String { .. } => "  glue_keep(*x);\n".to_owned(),
            TypeKind::Sequence { element, bound } => {
                let each = "  uint32_t i;\n  for (i = 0; i < x->_length; i++) ";
                let mut out = of(each, *element, "&x->_buffer[i]")?;
                if bound.is_none() {
                    out += "  glue_keep(x->_buffer);\n";
                }
                out
            }
            TypeKind::Array { element, length } => {
                let each = format!("  uint32_t i;\n  for (i = 0; i < {length}u; i++) ");
                of(&each, *element, "&(*x)[i]")?
            }
            TypeKind::Optional { element } => of("  if (x->_present) ", *element, "&x->_value")?,
            TypeKind::Struct { members } => {
                let mut out = String::new();
                for &member in members {
                    out += &of("  ", member, &format!("&x->{}", self.member_name(member)?))?;
                }
                out
            }
            TypeKind::Union { members, .. } => {
                self.cases(members, |member, name| of("    ", member, &format!("&x->_u.{name}")))?
            }
            _ => String::new(),
        })
    }

    /// The code after the call of a codel in C: it keeps memory that the codel may have assigned to the ids
    /// and to ports.
    pub(super) fn keep_written(&self, codel: &Codel) -> LangResult {
        let mut out = String::new();
        for param in &codel.params {
            out += &self.keep_param(param)?;
        }
        Ok(if out.is_empty() { out } else { format!("  if (glue_owned()) {{\n{out}  }}\n") })
    }

    fn keep_param(&self, param: &Param) -> LangResult {
        let written = matches!(param.dir, ParamDir::Out | ParamDir::Inout);
        match param.source {
            ParamSource::Ids if written && self.owns(param.ty) => {
                let (of, variable) = (self.known(param.ty)?, self.variable(param)?);
                Ok(format!("    glue_keep_{of}(&{variable});\n"))
            }
            ParamSource::Port(at) => {
                let port = &self.expected.component().ports[at];
                if port.dir != PortDir::Out || !self.owns(port.data) {
                    return Ok(String::new());
                }
                let of = self.known(port.data)?;
                Ok(format!(
                    "    {{\n      struct glue_inst_{at} *it;\n\
                     \x20     for (it = glue_first_{at}; it != NULL; it = it->next)\n\
                     \x20       glue_keep_{of}(&it->value);\n    }}\n"
                ))
            }
            _ => Ok(String::new()),
        }
    }
}
