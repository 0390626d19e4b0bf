//! Access to a member of a value.

use dotgen_analysis::model::{PathElement, TypeId, TypeKind};

use super::{LangError, LangResult, Language, Mapper};

impl Mapper<'_> {
    /// The text that accesses a member of a variable of the type. `path` holds member names and indexes.
    ///
    /// # Errors
    /// Fails for a member that does not exist, for a type without members, and in Tcl.
    pub fn member(&self, ty: TypeId, path: &[String]) -> LangResult {
        match self.language {
            Language::C | Language::Cxx => self.access(ty, path),
            Language::Tcl => self.unsupported("member"),
        }
    }

    /// [`Mapper::member`] for a path of the model.
    ///
    /// # Errors
    /// Fails like [`Mapper::member`].
    pub(crate) fn member_path(&self, ty: TypeId, path: &[PathElement]) -> LangResult {
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
        // Each iteration that does not consume an element goes one step down a chain of types.
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
}
