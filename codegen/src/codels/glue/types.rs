//! Types: a `typedef glue_tN` for each, and two functions, `glue_save_N` and `glue_load_N`.

use dotgen_analysis::model::{Label, TypeId, TypeKind, Value};
use std::fmt::Write as _;

use super::Glue;
use crate::lang::{LangResult, value_text};

impl Glue<'_, '_> {
    /// Definitions of all types that are passed.
    pub(super) fn types(&self) -> LangResult {
        let mut out = String::new();
        for (number, &ty) in self.order.iter().enumerate() {
            let declared = self.mapper.declarator(ty, &format!("glue_t{number}"))?;
            _ = writeln!(
                out,
                "\ntypedef {declared};\n\
                 static void glue_save_{number}(struct glue_buffer *b, glue_t{number} *x);\n\
                 static void glue_load_{number}(struct glue_reader *r, glue_t{number} *x);"
            );
        }
        let (prototypes, functions) = self.keep_functions()?;
        out += &prototypes;
        for (number, &ty) in self.order.iter().enumerate() {
            let (save, load) = self.copying(ty)?;
            _ = writeln!(
                out,
                "\nstatic void\n\
                 glue_save_{number}(struct glue_buffer *b, glue_t{number} *x)\n\
                 {{\n  (void)b; (void)x;\n{save}}}\n\n\
                 static void\n\
                 glue_load_{number}(struct glue_reader *r, glue_t{number} *x)\n\
                 {{\n  (void)r; (void)x;\n{load}}}"
            );
        }
        out += &functions;
        Ok(out)
    }

    /// The bodies of the functions that save and load a type.
    fn copying(&self, ty: TypeId) -> Result<(String, String), crate::lang::LangError> {
        Ok(match self.kind(ty) {
            TypeKind::Boolean => (
                "  uint8_t v = *x ? 1 : 0;\n  glue_put(b, &v, 1);\n".into(),
                "  uint8_t v;\n  glue_get(r, &v, 1);\n  *x = v != 0;\n".into(),
            ),
            _ if self.is_plain(ty) => {
                ("  glue_put(b, x, sizeof(*x));\n".into(), "  glue_get(r, x, sizeof(*x));\n".into())
            }
            TypeKind::Enum { .. } => {
                let number = self.known(ty)?;
                (
                    "  glue_put_number(b, (uint32_t)*x);\n".into(),
                    format!(
                        "  uint32_t v;\n  glue_get(r, &v, sizeof(v));\n  *x = (glue_t{number})v;\n"
                    ),
                )
            }
            TypeKind::String { bound } => copying_text(bound.is_some(), self.is_cxx()),
            TypeKind::Array { element, length } => {
                let element = self.known(*element)?;
                let text = |text: &str, verb: &str| {
                    format!(
                        "  uint32_t i;\n  for (i = 0; i < {length}u; i++) \
                         glue_{verb}_{element}({text}, &(*x)[i]);\n"
                    )
                };
                (text("b", "save"), text("r", "load"))
            }
            TypeKind::Sequence { element, bound } => self.sequence(*element, *bound)?,
            TypeKind::Optional { element } => {
                let element = self.known(*element)?;
                (
                    format!(
                        "  uint8_t v = x->_present ? 1 : 0;\n  glue_put(b, &v, 1);\n\
                         \x20 if (v) glue_save_{element}(b, &x->_value);\n"
                    ),
                    format!(
                        "  uint8_t v;\n  glue_get(r, &v, 1);\n  x->_present = v != 0;\n\
                         \x20 if (v) glue_load_{element}(r, &x->_value);\n"
                    ),
                )
            }
            TypeKind::Struct { members } => {
                let (mut save, mut load) = (String::new(), String::new());
                for &member in members {
                    let name = self.member_name(member)?;
                    let of = self.known(member)?;
                    _ = writeln!(save, "  glue_save_{of}(b, &x->{name});");
                    _ = writeln!(load, "  glue_load_{of}(r, &x->{name});");
                }
                (save, load)
            }
            TypeKind::Union { switch, members } => self.union(*switch, members)?,
            // Data behind a pointer that only the codels know is not copied.
            _ => (
                "  uint8_t v = 0;\n  glue_put(b, &v, 1);\n".into(),
                "  uint8_t v;\n  glue_get(r, &v, 1);\n".into(),
            ),
        })
    }

    /// Returns true if values of a type are copied byte by byte: numbers, and arrays of numbers.
    fn is_plain(&self, ty: TypeId) -> bool {
        match self.kind(ty) {
            TypeKind::Char | TypeKind::Float | TypeKind::Double => true,
            TypeKind::Array { element, .. } => self.is_plain(*element),
            kind => kind.integer().is_some(),
        }
    }

    pub(super) fn member_name(&self, member: TypeId) -> LangResult {
        let name = self.mapper.short_name(member)?;
        Ok(if self.is_cxx() { name.to_string() } else { crate::lang::text::c_name(name) })
    }

    fn sequence(
        &self,
        element: TypeId,
        bound: Option<u64>,
    ) -> Result<(String, String), crate::lang::LangError> {
        let of = self.known(element)?;
        let plain = self.is_plain(element);
        if !self.is_cxx() {
            let save = if plain {
                "glue_put(b, x->_buffer, x->_length * sizeof(x->_buffer[0]));".to_owned()
            } else {
                format!(
                    "for (uint32_t i = 0; i < x->_length; i++) glue_save_{of}(b, &x->_buffer[i]);"
                )
            };
            let save = format!("  glue_put_number(b, x->_length);\n  {save}\n");
            let room = match bound {
                Some(bound) => format!(
                    "  if (n > {bound}u) {{ r->bad = 1; n = 0; }}\n\
                     \x20 *(uint32_t *)&x->_maximum = {bound}u;\n"
                ),
                None => "  if (n > x->_maximum) {\n\
                         \x20   if (genom_sequence_reserve(x, n) != 0) abort();\n\
                         \x20   glue_add(x->_buffer);\n    x->_release = glue_free;\n  }\n\
                         \x20 if (n > x->_length)\n\
                         \x20   memset(&x->_buffer[x->_length], 0, \
                         (n - x->_length) * sizeof(x->_buffer[0]));\n"
                    .to_owned(),
            };
            let load = if plain {
                "if (n > 0) glue_get(r, x->_buffer, n * sizeof(x->_buffer[0]));".to_owned()
            } else {
                format!("for (uint32_t i = 0; i < n; i++) glue_load_{of}(r, &x->_buffer[i]);")
            };
            let load =
                format!("  uint32_t n = glue_get_length(r);\n{room}  x->_length = n;\n  {load}\n");
            return Ok((save, load));
        }
        let (head, resize) = match bound {
            Some(bound) => {
                (format!("  if (n > {bound}u) {{ r->bad = 1; n = 0; }}\n"), "  x->n = n;\n")
            }
            None => (String::new(), "  x->resize(n);\n"),
        };
        // The elements of a vector of booleans have no address.
        let bits = bound.is_none() && matches!(self.kind(element), TypeKind::Boolean);
        let (save, load) = if bits {
            (
                format!("{{ glue_t{of} v = (*x)[i]; glue_save_{of}(b, &v); }}"),
                format!("{{ glue_t{of} v; glue_load_{of}(r, &v); (*x)[i] = v; }}"),
            )
        } else {
            (format!("glue_save_{of}(b, &(*x)[i]);"), format!("glue_load_{of}(r, &(*x)[i]);"))
        };
        let (save, load) = if plain {
            (
                "if (x->size() > 0) glue_put(b, &(*x)[0], x->size() * sizeof((*x)[0]));".to_owned(),
                "if (n > 0) glue_get(r, &(*x)[0], n * sizeof((*x)[0]));".to_owned(),
            )
        } else {
            (
                format!("for (size_t i = 0; i < x->size(); i++) {save}"),
                format!("for (size_t i = 0; i < n; i++) {load}"),
            )
        };
        Ok((
            format!("  glue_put_number(b, (uint32_t)x->size());\n  {save}\n"),
            format!("  uint32_t n = glue_get_length(r);\n{head}{resize}  {load}\n"),
        ))
    }

    fn union(
        &self,
        switch: TypeId,
        members: &[TypeId],
    ) -> Result<(String, String), crate::lang::LangError> {
        let of = self.known(switch)?;
        let text = |verb: &str, to: &str| -> LangResult {
            let cases = self.cases(members, |member, name| {
                Ok(format!("    {verb}_{}({to}, &x->_u.{name});\n", self.known(member)?))
            })?;
            Ok(format!("  {verb}_{of}({to}, &x->_d);\n{cases}"))
        };
        Ok((text("glue_save", "b")?, text("glue_load", "r")?))
    }

    /// A `switch` over the members of the union `*x`; `each` writes the code for the member of a name.
    pub(super) fn cases(
        &self,
        members: &[TypeId],
        each: impl Fn(TypeId, &str) -> LangResult,
    ) -> LangResult {
        let mut cases = String::new();
        let mut has_default = false;
        for &member in members {
            let TypeKind::UnionMember { labels, .. } = &self.expected.spec.ty(member).kind else {
                continue;
            };
            for label in labels {
                match label {
                    Label::Default => {
                        has_default = true;
                        cases += "  default:\n";
                    }
                    Label::Case(value) => {
                        _ = writeln!(cases, "  case (long long)({}):", self.label(value)?);
                    }
                }
            }
            cases += &each(member, &self.member_name(member)?)?;
            cases += "    break;\n";
        }
        if !has_default {
            cases += "  default: break;\n";
        }
        Ok(format!("  switch ((long long)x->_d) {{\n{cases}  }}\n"))
    }

    fn label(&self, value: &Value) -> LangResult {
        let text = value_text(self.expected.spec, value);
        Ok(match value {
            Value::Enum(_) => self.mapper.cname(&text)?,
            Value::Char(_) => format!("'{text}'"),
            _ => text,
        })
    }
}

/// The bodies of the functions that save and load a string.
fn copying_text(bounded: bool, cxx: bool) -> (String, String) {
    if bounded {
        (
            "  glue_put_text(b, *x, strnlen(*x, sizeof(*x)));\n".into(),
            "  uint32_t n = glue_get_length(r);\n\
             \x20 memset(*x, 0, sizeof(*x));\n\
             \x20 if (n > sizeof(*x)) { r->bad = 1; return; }\n\
             \x20 glue_get(r, *x, n);\n"
                .into(),
        )
    } else if cxx {
        (
            "  glue_put_text(b, x->data(), x->size());\n".into(),
            "  uint32_t n = glue_get_length(r);\n\
             \x20 x->resize(n);\n\
             \x20 if (n > 0) glue_get(r, &(*x)[0], n);\n"
                .into(),
        )
    } else {
        (
            "  glue_put_text(b, *x != NULL ? *x : \"\", *x != NULL ? strlen(*x) : 0);\n".into(),
            "  char *old = *x;\n\
             \x20 *x = glue_string_make(r);\n\
             \x20 if (old != NULL) glue_free(old);\n"
                .into(),
        )
    }
}
