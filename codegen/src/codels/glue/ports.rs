//! Ports: the `port` arguments of codels, and the places of their data. Remote services.

use dotgen_analysis::model::{Port, PortDir, PortId, Remote, RemoteId, TypeKind};
use std::fmt::Write as _;

use super::Glue;
use crate::codels::value::{is_input, is_output};
use crate::lang::{LangResult, PassingMode, port_calls, remote_passing};

impl Glue<'_, '_> {
    pub(super) fn ports(&self) -> LangResult {
        let component = self.expected.component();
        let mut out = String::new();
        for (at, port) in component.ports.iter_enumerated() {
            out += &self.port_data(at, port)?;
            out += &if self.is_cxx() { self.port_cxx(at, port)? } else { self.port_c(at, port)? };
        }
        for (at, remote) in component.remotes.iter_enumerated() {
            out += &self.remote(at, remote)?;
        }
        out += "\nGLUE_C GLUE_EXPORT const struct glue_board *\n\
                dotgen_glue_share(uint32_t port, const char *id, const struct glue_board *board)\n{\n\
                \x20 const struct glue_board *before = board;\n  (void)id;\n  pthread_mutex_lock(&glue_mutex);\n\
                \x20 switch (port) {\n";
        for (at, port) in component.ports.iter_enumerated() {
            if port.dir == PortDir::In {
                _ = writeln!(
                    out,
                    "  case {at}: before = glue_lead(&glue_find_{at}(id, 1)->shared, board); break;"
                );
            }
        }
        out += "  }\n  pthread_mutex_unlock(&glue_mutex);\n  return before;\n}\n";
        Ok(out)
    }

    /// The data of a port, and of each of its instances by name.
    fn port_data(&self, at: PortId, port: &Port) -> LangResult {
        let ty = self.known(port.data)?;
        let make = if self.is_cxx() {
            format!("new glue_inst_{at}()")
        } else {
            format!("(struct glue_inst_{at} *)calloc(1, sizeof(struct glue_inst_{at}))")
        };
        Ok(format!(
            "\nstruct glue_inst_{at} {{\n  struct glue_inst_{at} *next;\n  char *id;\n\
             \x20 glue_t{ty} value;\n  int known, closed;\n  struct glue_shared shared;\n  struct glue_buffer news;\n}};\n\
             static struct glue_inst_{at} *glue_first_{at};\n\n\
             static struct glue_inst_{at} *\nglue_find_{at}(const char *id, int make)\n{{\n\
             \x20 struct glue_inst_{at} *it;\n\
             \x20 for (it = glue_first_{at}; it != NULL; it = it->next)\n\
             \x20   if (!strcmp(it->id, id)) return it;\n\
             \x20 if (!make) return NULL;\n  it = {make};\n  if (it == NULL) abort();\n\
             \x20 it->id = strdup(id);\n  it->next = glue_first_{at};\n  glue_first_{at} = it;\n\
             \x20 return it;\n}}\n"
        ))
    }

    /// The function that reads the newest data of an input, or the one that reports the write of an output.
    fn moves(&self, at: PortId, port: &Port) -> LangResult {
        let ty = self.known(port.data)?;
        Ok(match port.dir {
            PortDir::In => format!(
                "\nstatic void\nglue_read_{at}(const char *id)\n{{\n\
                 \x20 struct glue_inst_{at} *it;\n  pthread_mutex_lock(&glue_mutex);\n\
                 \x20 it = glue_find_{at}(id, 0);\n  if (it != NULL && glue_look(&it->shared, &it->news)) {{\n\
                 \x20   struct glue_reader r = {{ it->news.bytes, it->news.size, 0 }};\n\
                 \x20   glue_load_{ty}(&r, &it->value);\n    it->known = 1;\n\
                 \x20 }}\n  pthread_mutex_unlock(&glue_mutex);\n}}\n"
            ),
            PortDir::Out => format!(
                "\nstatic int\nglue_write_{at}(const char *id)\n{{\n\
                 \x20 struct glue_inst_{at} *it;\n  size_t from;\n\
                 \x20 pthread_mutex_lock(&glue_mutex);\n  it = glue_find_{at}(id, {make});\n\
                 \x20 pthread_mutex_unlock(&glue_mutex);\n\
                 \x20 if (it == NULL || it->closed) return 0;\n\
                 \x20 glue_tell_port({at}, id, 0);\n\
                 \x20 from = glue_begin_block(&glue_written);\n\
                 \x20 glue_save_{ty}(&glue_written, &it->value);\n\
                 \x20 glue_end_block(&glue_written, from);\n  return 1;\n}}\n\n\
                 static inline void\nglue_open_{at}(const char *id)\n{{\n\
                 \x20 pthread_mutex_lock(&glue_mutex);\n  glue_find_{at}(id, 1)->closed = 0;\n\
                 \x20 pthread_mutex_unlock(&glue_mutex);\n  glue_tell_port({at}, id, 1);\n}}\n\n\
                 static inline int\nglue_close_{at}(const char *id)\n{{\n\
                 \x20 struct glue_inst_{at} *it;\n  pthread_mutex_lock(&glue_mutex);\n\
                 \x20 it = glue_find_{at}(id, 0);\n  pthread_mutex_unlock(&glue_mutex);\n\
                 \x20 if (it == NULL || it->closed) return 0;\n  it->closed = 1;\n\
                 \x20 glue_tell_port({at}, id, 2);\n  return 1;\n}}\n",
                make = u8::from(!port.multiple),
            ),
        })
    }

    fn port_c(&self, at: PortId, port: &Port) -> LangResult {
        let name = self.mapper.declarator(port.ty, "")?;
        let (arguments, id) = if port.multiple {
            ("const char *id, genom_context self", "id")
        } else {
            ("genom_context self", "\"\"")
        };
        let decays = matches!(
            self.kind(port.data),
            TypeKind::Array { .. } | TypeKind::String { bound: Some(_) }
        );
        let address = if decays { "it->value" } else { "&it->value" };
        // An output can be filled at once; an input has no data before it was read.
        let (make, seen) = match (port.dir, port.multiple) {
            (PortDir::Out, false) => (1, "it == NULL"),
            (PortDir::Out, true) => (0, "it == NULL || it->closed"),
            (PortDir::In, _) => (0, "it == NULL || !it->known"),
        };
        let result = if port.multiple {
            format!("__typeof__((({name} *)0)->data(NULL, NULL))")
        } else {
            format!("__typeof__((({name} *)0)->data(NULL))")
        };
        let mut out = self.moves(at, port)?;
        _ = write!(
            out,
            "\nstatic {result}\nglue_data_{at}({arguments})\n{{\n\
             \x20 struct glue_inst_{at} *it;\n  (void)self;\n  pthread_mutex_lock(&glue_mutex);\n\
             \x20 it = glue_find_{at}({id}, {make});\n  pthread_mutex_unlock(&glue_mutex);\n\
             \x20 if ({seen}) return NULL;\n  return {address};\n}}\n"
        );
        let fails = "{ genom_syserr_detail d = { ENOENT }; return genom_syserr(&d, self); }";
        let mut members = vec![format!("glue_data_{at}")];
        for call in port_calls(port) {
            let body = moved(call, at, port, fails);
            _ = write!(
                out,
                "\nstatic genom_event\nglue_c_{call}_{at}({arguments})\n{{\n  (void)self;\n  {body}\n\
                 \x20 return genom_ok;\n}}\n"
            );
            members.push(format!("glue_c_{call}_{at}"));
        }
        let members = members.join(", ");
        _ = writeln!(out, "static {name} glue_port_{at} = {{ {members} }};");
        Ok(out)
    }

    fn port_cxx(&self, at: PortId, port: &Port) -> LangResult {
        let name = self.mapper.type_cname(port.ty)?;
        let data = self.mapper.return_value(port.data, PassingMode::Reference, "")?;
        let (arguments, id) =
            if port.multiple { ("const char *id", "id") } else { ("void", "\"\"") };
        let constant = match port.dir {
            PortDir::In => "const ",
            PortDir::Out => "",
        };
        let missing = match (port.dir, port.multiple) {
            (PortDir::Out, true) => {
                "    if (it == NULL || it->closed) {\n\
                 \x20     genom::syserr e; e.detail.code = ENOENT; throw e;\n    }\n"
            }
            _ => "",
        };
        let make = u8::from(!(port.dir == PortDir::Out && port.multiple));
        let mut out = self.moves(at, port)?;
        _ = write!(
            out,
            "\nstruct glue_class_{at} : public {name} {{\n\
             \x20 {constant}{data} data({arguments}) const {{\n\
             \x20   pthread_mutex_lock(&glue_mutex);\n\
             \x20   glue_inst_{at} *it = glue_find_{at}({id}, {make});\n\
             \x20   pthread_mutex_unlock(&glue_mutex);\n{missing}    return it->value;\n  }}\n"
        );
        let fails = "{ genom::syserr e; e.detail.code = ENOENT; throw e; }";
        for call in port_calls(port) {
            let body = moved(call, at, port, fails);
            _ = writeln!(out, "  void {call}({arguments}) {{ {body} }}");
        }
        _ = writeln!(out, "}};\nstatic glue_class_{at} glue_port_{at};");
        Ok(out)
    }

    /// A call of a service of another component, which the engine forwards; the codel waits.
    fn remote(&self, at: RemoteId, remote: &Remote) -> LangResult {
        let name = self.mapper.declarator(remote.ty, "")?;
        let arguments = self.mapper.remote_arguments(remote)?.join(", ");
        let (mut save, mut load) = (String::new(), String::new());
        for param in &remote.params {
            let Some(passing) = remote_passing(param) else {
                continue;
            };
            let ty = self.known(param.ty)?;
            let is_array = matches!(
                self.kind(param.ty),
                TypeKind::Array { .. } | TypeKind::String { bound: Some(_) }
            );
            let value = self.mapper.dereference(param.ty, passing, &param.name)?;
            // Arrays are pointers in both languages.
            let place = if is_array {
                format!("(glue_t{ty} *)({value})")
            } else {
                format!("(glue_t{ty} *)&({value})")
            };
            if is_input(param) {
                _ = writeln!(save, "  glue_save_{ty}(&glue_in, {place});");
            }
            if is_output(param) {
                _ = writeln!(load, "    glue_load_{ty}(&glue_r, {place});");
            }
        }
        let body = format!(
            "  struct glue_buffer glue_in = {{ NULL, 0, 0 }}, glue_out = {{ NULL, 0, 0 }};\n\
             \x20 struct glue_reader glue_r = {{ NULL, 0, 0 }};\n  int glue_error;\n{save}\
             \x20 glue_error = glue_ask({at}, &glue_in, &glue_out);\n  free(glue_in.bytes);\n\
             \x20 glue_r.bytes = glue_out.bytes;\n  glue_r.left = glue_out.size;\n\
             \x20 if (glue_error == 0) {{\n    pthread_mutex_lock(&glue_mutex);\n{load}\
             \x20   pthread_mutex_unlock(&glue_mutex);\n    if (glue_r.bad) glue_error = EIO;\n  }}\n\
             \x20 free(glue_out.bytes);\n"
        );
        if self.is_cxx() {
            return Ok(format!(
                "\nstruct glue_remote_class_{at} : public {name} {{\n\
                 \x20 void call({arguments}) {{\n{body}\
                 \x20 if (glue_error) {{ genom::syserr e; e.detail.code = glue_error; throw e; }}\n  }}\n}};\n\
                 static glue_remote_class_{at} glue_remote_{at};\n"
            ));
        }
        Ok(format!(
            "\nstatic genom_event\nglue_call_{at}({arguments})\n{{\n{body}\
             \x20 if (glue_error) {{\n    genom_syserr_detail d = {{ glue_error }};\n\
             \x20   return genom_syserr(&d, self);\n  }}\n  return genom_ok;\n}}\n\
             static {name} glue_remote_{at} = {{ glue_call_{at} }};\n"
        ))
    }
}

/// The statement of a call of a port. `fails` ends a call with an instance that is not open.
fn moved(call: &str, at: PortId, port: &Port, fails: &str) -> String {
    let id = if port.multiple { "id" } else { "\"\"" };
    if port.multiple && matches!(call, "write" | "close") {
        format!("if (!glue_{call}_{at}({id})) {fails}")
    } else {
        format!("glue_{call}_{at}({id});")
    }
}
