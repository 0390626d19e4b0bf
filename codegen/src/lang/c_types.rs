//! C: the text of type definitions and codel prototypes.

use dotgen_analysis::model::{ComponentId, ParamDir, PortId, RemoteId, TypeId, TypeKind, Value};
use dotgen_analysis::release::Change;

use super::c::declarator;
use super::text::c_name;
use super::{LangResult, MapObject, Mapper, PassingMode, port_calls, value_text};

pub(super) fn mapping(m: &Mapper<'_>, objects: &[MapObject], locations: bool) -> LangResult {
    let writer = Writer { m, locations };
    let mut body = String::new();
    for object in objects {
        match *object {
            MapObject::Type(ty) => body += &writer.definition(ty)?,
            MapObject::Codel(component, at) => {
                let codel = m.spec.components[component].codel(at);
                body += "\n#ifdef __cplusplus\nextern \"C\" {\n#endif\n";
                body += &m.signature(component, codel, " ", locations)?;
                body += ";\n#ifdef __cplusplus\n}\n#endif";
            }
        }
    }
    let mut out = String::new();
    for (needed, include) in [
        (mentions_sized_integer(&body), "<stdint.h>"),
        (body.contains("bool"), "<stdbool.h>"),
        (body.contains("sequence"), "\"genom3/c/idlsequence.h\""),
        (body.contains("genom_context"), "\"genom3/c/context.h\""),
    ] {
        if needed {
            out += &format!("#include {include}\n");
        }
    }
    Ok(out + &body)
}

pub(super) fn mentions_sized_integer(text: &str) -> bool {
    ["int8_t", "int16_t", "int32_t", "int64_t"].iter().any(|word| text.contains(word))
}

/// Text of a constant in C and C++.
pub(super) fn literal(m: &Mapper<'_>, value: &Value) -> LangResult {
    Ok(match value {
        Value::Bool(b) => b.to_string(),
        Value::Char(text) => format!("'{text}'"),
        Value::String(text) => format!("\"{}\"", text.replace('"', "\\\"")),
        Value::Enum(_) => m.cname(&value_text(m.spec, value))?,
        other => value_text(m.spec, other),
    })
}

fn guard(body: &str, name: &str) -> String {
    format!(
        "\n#ifndef _{name}_c_type\n# define _{name}_c_type{body}\n#endif /* _{name}_c_type */\n"
    )
}

struct Writer<'a, 'b> {
    m: &'b Mapper<'a>,
    locations: bool,
}

impl Writer<'_, '_> {
    fn definition(&self, ty: TypeId) -> LangResult {
        match self.m.kind(ty) {
            TypeKind::Const { ty: of, value } => self.constant(ty, *of, value),
            TypeKind::Enum { enumerators } => self.enumeration(ty, enumerators),
            TypeKind::Struct { members } => self.structure(ty, members),
            TypeKind::Union { switch, members } => self.union(ty, *switch, members),
            TypeKind::Typedef { ty: of } => self.typedef(ty, *of),
            TypeKind::Sequence { .. } | TypeKind::Optional { .. } => self.anonymous(ty),
            TypeKind::Exception { members } => self.exception(ty, members),
            TypeKind::ForwardStruct { .. } | TypeKind::ForwardUnion { .. } | TypeKind::Native => {
                let n = self.m.type_cname(ty)?;
                let body = format!("{}\ntypedef struct {n} {n};", self.mark(ty));
                Ok(guard(&body, &n))
            }
            TypeKind::Event | TypeKind::PauseEvent => {
                let n = self.m.type_cname(ty)?;
                let body = format!(
                    "\n#include \"genom3/c/exception.h\"{}\nconst char genom_extern_weak {n}[] = \"{}\";",
                    self.mark(ty),
                    self.m.full_name(ty)?
                );
                Ok(guard(&body, &n))
            }
            TypeKind::Port { component, port } => self.port(ty, *component, *port),
            TypeKind::Remote { component, remote } => self.remote(ty, *component, *remote),
            _ => Ok(String::new()),
        }
    }

    fn mark(&self, ty: TypeId) -> String {
        self.m.type_mark(ty, self.locations)
    }

    fn constant(&self, ty: TypeId, of: TypeId, value: &Value) -> LangResult {
        let Some(name) = self.m.spec.full_name(ty) else {
            return Ok(String::new());
        };
        let n = c_name(&name);
        let body = format!(
            "{}\nstatic const {} {n} = {};",
            self.mark(ty),
            declarator(self.m, of, "")?,
            literal(self.m, value)?
        );
        Ok(guard(&body, &n))
    }

    fn enumeration(&self, ty: TypeId, enumerators: &[TypeId]) -> LangResult {
        let n = self.m.type_cname(ty)?;
        let mut body = format!("{}\ntypedef uint32_t {n};\nenum {{", self.mark(ty));
        for (number, enumerator) in enumerators.iter().enumerate() {
            if number > 0 {
                body.push(',');
            }
            body += &self.mark(*enumerator);
            body += &format!("\n  {} =\t{number}", self.m.type_cname(*enumerator)?);
        }
        body += "\n};";
        Ok(guard(&body, &n))
    }

    /// The definition of a sequence or optional, empty for other types.
    fn anonymous(&self, ty: TypeId) -> LangResult {
        match self.m.kind(ty) {
            TypeKind::Sequence { element, bound } => self.sequence(ty, *element, *bound),
            TypeKind::Optional { element } => {
                let n = declarator(self.m, ty, "")?;
                let needed = self.anonymous(*element)?;
                let body = format!(
                    "{}\ntypedef struct {n} {{\n  bool _present;\n  {};\n}} {n};",
                    self.mark(ty),
                    declarator(self.m, *element, "_value")?
                );
                Ok(needed + &guard(&body, &n))
            }
            _ => Ok(String::new()),
        }
    }

    fn sequence(&self, ty: TypeId, element: TypeId, bound: Option<u64>) -> LangResult {
        let n = declarator(self.m, ty, "")?;
        let needed = self.anonymous(element)?;
        let mut body = format!("{}\ntypedef struct {n} {{", self.mark(ty));
        match bound {
            None => {
                body += "\n  uint32_t _maximum, _length;";
                body += &format!("\n  {};", declarator(self.m, element, "*_buffer")?);
                body += "\n  void (*_release)(void *_buffer);";
            }
            Some(bound) if self.m.has(Change::MutableBoundedSequences) => {
                let buffer = declarator(self.m, element, &format!("_buffer[{bound}]"))?;
                body += &format!("\n  uint32_t _maximum, _length;\n  {buffer};");
            }
            Some(bound) => {
                let buffer = declarator(self.m, element, &format!("_buffer[{bound}]"))?;
                body += &format!(
                    "\n  const uint32_t _maximum;\n  uint32_t _length;\n  {buffer};\
                     \n# ifdef __cplusplus\n  {n}():_maximum({bound}) {{}}\
                     \n  {n} &operator=(const {n} &x) {{\
                     \n    _length = x._length;\
                     \n    for(unsigned i=0; i<_length; i++)"
                );
                // C++ does not assign arrays, and a bounded string is one.
                match self.m.kind(element) {
                    TypeKind::Array { length, .. } | TypeKind::String { bound: Some(length) } => {
                        body += &format!(
                            "\n      for(unsigned j=0; j<{length}; j++)\
                             \n        _buffer[i][j] = x._buffer[i][j];"
                        );
                    }
                    _ => body += "\n      _buffer[i] = x._buffer[i];",
                }
                body += "\n    return *this;\n  };\n# endif";
            }
        }
        body += &format!("\n}} {n};");
        Ok(needed + &guard(&body, &n))
    }

    /// Member declarations, each after its mark, and the anonymous types they need.
    fn members(&self, members: &[TypeId], indent: &str, body: &mut String) -> LangResult {
        let mut needed = String::new();
        for member in members {
            *body += &self.mark(*member);
            let name = c_name(self.m.short_name(*member)?);
            *body += &format!("\n{indent}{};", declarator(self.m, *member, &name)?);
            needed += &self.anonymous(self.m.inner_or_error(*member)?)?;
        }
        Ok(needed)
    }

    /// The definition of a structure. Its name comes first, so that sequences of the structure may be members
    /// of it.
    fn structure(&self, ty: TypeId, members: &[TypeId]) -> LangResult {
        let n = self.m.type_cname(ty)?;
        let head = format!("{}\ntypedef struct {n} {n};", self.mark(ty));
        let mut body = format!("\nstruct {n} {{");
        let needed = self.members(members, " ", &mut body)?;
        body += "\n};";
        Ok(guard(&head, &n) + &needed + &guard(&body, &format!("{n}_definition")))
    }

    fn union(&self, ty: TypeId, switch: TypeId, members: &[TypeId]) -> LangResult {
        let n = self.m.type_cname(ty)?;
        let head = format!("{}\ntypedef struct {n} {n};", self.mark(ty));
        let mut body = format!(
            "\nstruct {n} {{{}\n {} _d;\n union {{",
            self.mark(switch),
            declarator(self.m, switch, "")?
        );
        let needed = self.members(members, "  ", &mut body)?;
        body += "\n } _u;\n};";
        Ok(guard(&head, &n) + &needed + &guard(&body, &format!("{n}_definition")))
    }

    fn typedef(&self, ty: TypeId, of: TypeId) -> LangResult {
        let n = self.m.type_cname(ty)?;
        let needed = self.anonymous(of)?;
        let body = format!("{}\ntypedef {};", self.mark(ty), declarator(self.m, of, &n)?);
        Ok(needed + &guard(&body, &n))
    }

    fn exception(&self, ty: TypeId, members: &[TypeId]) -> LangResult {
        let n = self.m.type_cname(ty)?;
        let mark = self.mark(ty);
        let mut head = format!(
            "\n#include \"genom3/c/exception.h\"{mark}\
             \nconst char genom_extern_weak {n}_id[] = \"{}\";{mark}",
            self.m.full_name(ty)?
        );
        let mut body = String::new();
        let mut needed = String::new();
        if members.is_empty() {
            head += &format!("\ntypedef void {n}_detail;");
            body += &format!(
                "\nstatic inline genom_event\n{n}(genom_context self) {{\
                 \n return self->raise({n}_id, NULL, 0, self);\n}}"
            );
        } else {
            head += &format!("\ntypedef struct {n}_detail {n}_detail;");
            body += &format!("\nstruct {n}_detail {{");
            for member in members {
                body += &self.mark(*member);
                let name = self.m.short_name(*member)?;
                body += &format!("\n {};", declarator(self.m, *member, name)?);
                needed += &self.anonymous(self.m.inner_or_error(*member)?)?;
            }
            // Raising an exception copies its detail.
            let detail = if self.m.has(Change::ConstExceptionDetails) {
                format!("const {n}_detail")
            } else {
                format!("{n}_detail")
            };
            body += &format!(
                "\n}};\nstatic inline genom_event\n{n}({detail} *d, genom_context self) {{\
                 \n return self->raise({n}_id, d, sizeof(*d), self);\n}}"
            );
        }
        Ok(guard(&head, &n) + &needed + &guard(&body, &format!("{n}_definition")))
    }

    fn port(&self, ty: TypeId, component: ComponentId, port: PortId) -> LangResult {
        let n = declarator(self.m, ty, "")?;
        let port = &self.m.spec.components[component].ports[port];
        let needed = match self.m.kind(port.data) {
            TypeKind::Sequence { .. } => self.anonymous(port.data)?,
            _ => String::new(),
        };
        let data = self.m.return_value(port.data, PassingMode::Reference, "")?;
        let arguments =
            if port.multiple { "const char *id, genom_context self" } else { "genom_context self" };
        let mut body = format!(
            "\n#include \"genom3/c/exception.h\"{}\ntypedef struct {n} {{\n  {data} (*data)({arguments});",
            self.mark(ty)
        );
        for call in port_calls(port) {
            body += &format!("\n  genom_event (*{call})({arguments});");
        }
        body += &format!("\n}} {n};");
        Ok(needed + &guard(&body, &n))
    }

    fn remote(&self, ty: TypeId, component: ComponentId, remote: RemoteId) -> LangResult {
        let n = declarator(self.m, ty, "")?;
        let remote = &self.m.spec.components[component].remotes[remote];
        let arguments = self.m.remote_arguments(remote)?;
        let mut needed = String::new();
        for param in remote.params.iter().filter(|param| param.dir != ParamDir::Local) {
            if matches!(self.m.kind(param.ty), TypeKind::Sequence { .. }) {
                needed += &self.anonymous(param.ty)?;
            }
        }
        let body = format!(
            "\n#include \"genom3/c/exception.h\"{}\ntypedef struct {n} {{\
             \n  genom_event (*call)({});\n}} {n};",
            self.mark(ty),
            arguments.join(", ")
        );
        Ok(needed + &guard(&body, &n))
    }
}
