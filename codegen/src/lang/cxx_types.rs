//! C++: the text of type definitions and codel prototypes.

use dotgen_analysis::model::{
    ComponentId, PortDir, PortId, RemoteId, ScopeKind, TypeId, TypeKind, Value,
};

use super::c_types::{literal, mentions_sized_integer};
use super::cxx::declarator;
use super::text::cxx_name;
use super::{LangError, LangResult, MapObject, Mapper, PassingMode, port_calls};

const EVENT_HEADER: &str = "\n#include \"genom3/c++/event.h\"";

pub(super) fn mapping(m: &Mapper<'_>, objects: &[MapObject], locations: bool) -> LangResult {
    let writer = Writer { m, locations };
    let mut body = String::new();
    for object in objects {
        match *object {
            MapObject::Type(ty) => {
                // A nested type is defined by the type around it.
                let mut outer = ty;
                while let Some(parent) = m.spec.ty(outer).parent {
                    outer = parent;
                }
                body += &writer.definition(outer)?;
            }
            MapObject::Codel(component, at) => {
                let codel = m.spec.components[component].codel(at);
                body += &format!("\n{};", m.signature(component, codel, " ", locations)?);
            }
        }
    }
    let mut out = String::new();
    for (needed, include) in [
        (mentions_sized_integer(&body), "<cstdint>"),
        (body.contains("std::string"), "<string>"),
        (body.contains("std::vector<"), "<vector>"),
        (body.contains("genom::bounded_sequence<"), "<genom3/c++/idlsequence.h>"),
        (body.contains("genom::optional<"), "<genom3/c++/idloptional.h>"),
    ] {
        if needed {
            out += &format!("\n#include {include}");
        }
    }
    Ok(out + &body)
}

struct Writer<'a, 'b> {
    m: &'b Mapper<'a>,
    locations: bool,
}

impl Writer<'_, '_> {
    fn definition(&self, ty: TypeId) -> LangResult {
        match self.m.kind(ty) {
            TypeKind::Const { ty: of, value } => self.constant(ty, *of, value),
            TypeKind::Enum { .. } | TypeKind::Struct { .. } | TypeKind::Union { .. } => {
                self.constructed(ty)
            }
            TypeKind::Typedef { ty: of } => {
                let name = self.name(ty)?;
                let body =
                    format!("{}\ntypedef {};", self.mark(ty), declarator(self.m, *of, &name)?);
                self.wrapped(&body, ty)
            }
            TypeKind::Exception { members } => self.exception(ty, members),
            TypeKind::ForwardStruct { .. } | TypeKind::ForwardUnion { .. } | TypeKind::Native => {
                let body = format!("{}\nstruct {};", self.mark(ty), self.name(ty)?);
                self.wrapped(&body, ty)
            }
            TypeKind::Event | TypeKind::PauseEvent => {
                let body = format!(
                    "{}\nconst char genom_extern_weak {}[] = \"{}\";",
                    self.mark(ty),
                    self.name(ty)?,
                    self.m.full_name(ty)?
                );
                Ok(EVENT_HEADER.to_owned() + &self.wrapped(&body, ty)?)
            }
            TypeKind::Port { component, port } => self.port(ty, *component, *port),
            TypeKind::Remote { component, remote } => self.remote(ty, *component, *remote),
            _ => Ok(String::new()),
        }
    }

    /// Struct, union or enum; also used for those nested in another type.
    fn constructed(&self, ty: TypeId) -> LangResult {
        match self.m.kind(ty) {
            TypeKind::Enum { enumerators } => self.enumeration(ty, enumerators),
            TypeKind::Struct { members } => self.structure(ty, members),
            TypeKind::Union { switch, members } => self.union(ty, *switch, members),
            _ => Ok(String::new()),
        }
    }

    fn mark(&self, ty: TypeId) -> String {
        self.m.type_mark(ty, self.locations)
    }

    fn name(&self, ty: TypeId) -> LangResult {
        Ok(cxx_name(self.m.short_name(ty)?))
    }

    /// The namespaces and the guard around a definition.
    fn wrapped(&self, body: &str, ty: TypeId) -> LangResult {
        Ok(guard(&self.in_namespaces(body, ty), &self.m.type_cname(ty)?))
    }

    /// A type nested in another one is in the scope of that one and needs no namespace.
    fn in_namespaces(&self, body: &str, ty: TypeId) -> String {
        let scope = &self.m.spec.ty(ty).scope;
        if scope.iter().any(|scope| scope.kind != ScopeKind::Module) {
            return body.to_owned();
        }
        let open: String =
            scope.iter().map(|scope| format!("\nnamespace {} {{", scope.name)).collect();
        open + body + &"\n}".repeat(scope.len())
    }

    fn constant(&self, ty: TypeId, of: TypeId, value: &Value) -> LangResult {
        if self.m.spec.ty(ty).name.is_none() {
            return Ok(String::new());
        }
        let body = format!(
            "\nconst {} = {};",
            declarator(self.m, of, &self.name(ty)?)?,
            literal(self.m, value)?
        );
        let body = self.mark(ty) + &self.in_namespaces(&body, ty);
        Ok(guard(&body, &self.m.type_cname(ty)?))
    }

    fn enumeration(&self, ty: TypeId, enumerators: &[TypeId]) -> LangResult {
        let mut body = format!("{}\nenum {} {{", self.mark(ty), self.name(ty)?);
        for (number, enumerator) in enumerators.iter().enumerate() {
            body += &self.mark(*enumerator);
            body += &format!("\n  {} =\t{number},", self.name(*enumerator)?);
        }
        // Makes the enum as wide as the integer of the C mapping.
        body += &format!("\n  genom_max_{} =\t0xffffffff\n}};", self.m.short_name(ty)?);
        self.wrapped(&body, ty)
    }

    fn nested(&self, ty: TypeId) -> LangResult {
        let mut out = String::new();
        for inner in self.m.nested(ty) {
            out += &self.constructed(inner)?;
        }
        Ok(out)
    }

    fn member(&self, member: TypeId, indent: &str) -> LangResult {
        let name = self.m.short_name(member)?;
        Ok(format!("{}\n{indent}{};", self.mark(member), declarator(self.m, member, name)?))
    }

    fn structure(&self, ty: TypeId, members: &[TypeId]) -> LangResult {
        let mut body = format!("\nstruct {} {{", self.name(ty)?);
        body += &self.nested(ty)?;
        for member in members {
            body += &self.member(*member, " ")?;
        }
        body += "\n};";
        self.wrapped(&body, ty)
    }

    fn union(&self, ty: TypeId, switch: TypeId, members: &[TypeId]) -> LangResult {
        let mut body = format!("\nstruct {} {{", self.name(ty)?);
        body += &self.nested(ty)?;
        body += &self.mark(switch);
        body += &format!("\n {} _d;\n union {{", declarator(self.m, switch, "")?);
        for member in members {
            body += &self.member(*member, "  ")?;
            if !self.has_trivial_constructor(*member, self.m.spec.types.len()) {
                return Err(self.not_allowed(*member)?);
            }
        }
        body += "\n } _u;\n};";
        self.wrapped(&body, ty)
    }

    fn not_allowed(&self, member: TypeId) -> Result<LangError, LangError> {
        let place = self.m.type_place(member);
        let place = place.map(|place| {
            let file = place.file.rsplit('/').next().unwrap_or_default();
            format!("{file}:{}: ", place.line)
        });
        Ok(LangError::fatal(format!(
            "{}member '{}' of type {} not allowed in C++",
            place.unwrap_or_default(),
            self.m.short_name(member)?,
            self.m.kind(self.m.inner_or_error(member)?).word()
        )))
    }

    fn has_trivial_constructor(&self, ty: TypeId, depth: usize) -> bool {
        let Some(depth) = depth.checked_sub(1) else {
            return true;
        };
        let trivial = |ty: &TypeId| self.has_trivial_constructor(*ty, depth);
        match self.m.kind(ty) {
            TypeKind::Sequence { .. } | TypeKind::Optional { .. } | TypeKind::String { .. } => {
                false
            }
            TypeKind::ForwardStruct { .. }
            | TypeKind::ForwardUnion { .. }
            | TypeKind::StructMember { .. }
            | TypeKind::UnionMember { .. }
            | TypeKind::Array { .. }
            | TypeKind::Typedef { .. } => self.m.inner(ty).as_ref().is_none_or(trivial),
            TypeKind::Struct { members } | TypeKind::Union { members, .. } => {
                members.iter().all(trivial)
            }
            _ => true,
        }
    }

    fn exception(&self, ty: TypeId, members: &[TypeId]) -> LangResult {
        let n = self.name(ty)?;
        let mark = self.mark(ty);
        let mut body = format!(
            "{mark}\nconst char genom_extern_weak {n}_id[] = \"{}\";{mark}\
             \nstruct {n} : public genom::exception {{",
            self.m.full_name(ty)?
        );
        if members.is_empty() {
            body += "\n typedef void detail;";
        } else {
            body += &self.nested(ty)?;
            body += "\n struct detail {";
            for member in members {
                body += &self.member(*member, "  ")?;
            }
            body += "\n } detail;";
        }
        body += &format!("\n const char *what() {{ return {n}_id; }};\n}};");
        Ok(EVENT_HEADER.to_owned() + &self.wrapped(&body, ty)?)
    }

    fn port(&self, ty: TypeId, component: ComponentId, port: PortId) -> LangResult {
        let port = &self.m.spec.components[component].ports[port];
        let data = self.m.return_value(port.data, PassingMode::Reference, "")?;
        let arguments = if port.multiple { "const char *id" } else { "void" };
        let constant = match port.dir {
            PortDir::In => "const ",
            PortDir::Out => "",
        };
        let mut body = format!(
            "{}\nstruct {} {{\n  virtual {constant}{data} data({arguments}) const = 0;",
            self.mark(ty),
            self.name(ty)?
        );
        for call in port_calls(port) {
            body += &format!("\n  virtual void {call}({arguments}) = 0;");
        }
        body += "\n};";
        Ok(EVENT_HEADER.to_owned() + &self.wrapped(&body, ty)?)
    }

    fn remote(&self, ty: TypeId, component: ComponentId, remote: RemoteId) -> LangResult {
        let remote = &self.m.spec.components[component].remotes[remote];
        let arguments = self.m.remote_arguments(remote)?;
        let body = format!(
            "{}\nstruct {} {{\n  virtual void call({}) = 0;\n}};",
            self.mark(ty),
            self.name(ty)?,
            arguments.join(", ")
        );
        Ok(EVENT_HEADER.to_owned() + &self.wrapped(&body, ty)?)
    }
}

fn guard(body: &str, name: &str) -> String {
    let name = name.replace("::", "_");
    format!(
        "\n#ifndef _{name}_cxx_type\n# define _{name}_cxx_type{body}\n#endif /* _{name}_cxx_type */\n"
    )
}
