//! Services with their parameters, and the calls of codels.

use dotgen_analysis::model::{
    Codel, CodelRef, Owner, ParamDir, ParamSource, ServiceKind, TypeId, TypeKind,
};
use std::fmt::Write as _;

use super::Glue;
use crate::lang::{LangResult, PassingMode, param_types};

impl Glue<'_, '_> {
    /// The ids, the parameters of each service, and the functions that make and end them.
    pub(super) fn services(&self) -> LangResult {
        let component = self.expected.component();
        let mut out = String::new();
        if let Some(ids) = component.ids {
            _ = writeln!(out, "\nstatic glue_t{} glue_ids;", self.known(ids)?);
        }
        out += "\nstruct glue_activity {\n  struct glue_activity *next;\n  uint32_t instance;\n\
                \x20 void *params;\n};\nstatic struct glue_activity *glue_activities;\n\n\
                static void **\nglue_params(uint32_t instance)\n{\n  struct glue_activity *it;\n\
                \x20 void **params = NULL;\n  pthread_mutex_lock(&glue_mutex);\n\
                \x20 for (it = glue_activities; it != NULL; it = it->next)\n\
                \x20   if (it->instance == instance) params = &it->params;\n\
                \x20 pthread_mutex_unlock(&glue_mutex);\n  return params;\n}\n";
        let (mut make, mut end) = (String::new(), String::new());
        for (at, service) in component.services.iter_enumerated() {
            _ = write!(out, "\nstruct glue_s{at} {{\n  char none;\n");
            let (mut load, mut save) = (String::new(), String::new());
            for (index, param) in service.params.iter().enumerate() {
                let ty = self.known(param.ty)?;
                _ = writeln!(out, "  glue_t{ty} v{index};");
                if matches!(param.dir, ParamDir::In | ParamDir::Inout) {
                    _ = writeln!(load, "    glue_load_{ty}(&r, &p->v{index});");
                }
                if matches!(param.dir, ParamDir::Out | ParamDir::Inout) {
                    _ = writeln!(save, "    glue_save_{ty}(b, &p->v{index});");
                }
            }
            out += "};\n";
            let new = if self.is_cxx() {
                format!("new glue_s{at}()")
            } else {
                format!("(struct glue_s{at} *)calloc(1, sizeof(struct glue_s{at}))")
            };
            _ = write!(
                make,
                "  case {at}: {{\n    struct glue_s{at} *p = {new};\n    if (p == NULL) abort();\n\
                 {load}    it->params = p;\n    break;\n  }}\n"
            );
            let delete = if self.is_cxx() { "delete p;" } else { "free(p);" };
            _ = write!(
                end,
                "  case {at}: {{\n    struct glue_s{at} *p = (struct glue_s{at} *)it->params;\n\
                 \x20   (void)b;\n{save}    {delete}\n    break;\n  }}\n"
            );
        }
        let (own, disown, forget) = if self.is_cxx() {
            ("", "", "")
        } else {
            (
                "  glue_owner = instance;\n",
                "  glue_owner = GLUE_NOBODY;\n",
                "    glue_forget(instance);\n",
            )
        };
        _ = write!(
            out,
            "\nGLUE_C GLUE_EXPORT int\n\
             dotgen_glue_make(uint32_t service, uint32_t instance, const void *data, size_t size)\n{{\n\
             \x20 struct glue_reader r = {{ (const unsigned char *)data, size, 0 }};\n\
             \x20 struct glue_activity *it = (struct glue_activity *)calloc(1, sizeof(*it));\n\
             \x20 if (it == NULL) abort();\n  it->instance = instance;\n\
             \x20 pthread_mutex_lock(&glue_mutex);\n{own}  switch (service) {{\n{make}  }}\n{disown}\
             \x20 it->next = glue_activities;\n  glue_activities = it;\n\
             \x20 pthread_mutex_unlock(&glue_mutex);\n  return r.bad || r.left > 0;\n}}\n\n\
             GLUE_C GLUE_EXPORT void\n\
             dotgen_glue_end(uint32_t service, uint32_t instance, struct glue_buffer *b)\n{{\n\
             \x20 struct glue_activity **at, *it;\n  pthread_mutex_lock(&glue_mutex);\n\
             \x20 for (at = &glue_activities; *at != NULL && (*at)->instance != instance;)\n\
             \x20   at = &(*at)->next;\n  it = *at;\n  if (it != NULL) {{\n    *at = it->next;\n\
             \x20   switch (service) {{\n{end}    }}\n{forget}    free(it);\n  }}\n\
             \x20 pthread_mutex_unlock(&glue_mutex);\n}}\n"
        );
        Ok(out)
    }

    /// The numbers of codels: in the order of
    /// [`Component::all_codels`](dotgen_analysis::model::Component::all_codels), then one for the copies of
    /// each attribute.
    pub(super) fn codels(&self) -> LangResult {
        let component = self.expected.component();
        let mut out = self.outcomes()?;
        let mut cases = String::new();
        let mut number = 0;
        for at in component.all_codels() {
            let codel = component.codel(at);
            if self.missing.contains(&codel.name) {
                number += 1;
                continue;
            }
            out += &self.codel(number, at, codel)?;
            _ = writeln!(cases, "  case {number}: glue_codel_{number}(instance, out); break;");
            number += 1;
        }
        for (at, service) in component.services.iter_enumerated() {
            if service.kind == ServiceKind::Attribute {
                let mut copies = String::new();
                for (index, param) in service.params.iter().enumerate() {
                    let ids = match param.source {
                        ParamSource::Ids => self.variable(param)?,
                        _ => continue,
                    };
                    let ty = self.known(param.ty)?;
                    let mine = format!("glue_p->v{index}");
                    let mut copy = |from: &str, to: &str| {
                        _ = write!(
                            copies,
                            "  glue_save_{ty}(&b, &{from});\n  r.bytes = b.bytes; r.left = b.size;\n\
                             \x20 pthread_mutex_lock(&glue_mutex);\n  glue_load_{ty}(&r, &{to});\n\
                             \x20 pthread_mutex_unlock(&glue_mutex);\n  b.size = 0;\n"
                        );
                    };
                    if matches!(param.dir, ParamDir::In | ParamDir::Inout) {
                        copy(&mine, &ids);
                    }
                    if matches!(param.dir, ParamDir::Out | ParamDir::Inout) {
                        copy(&ids, &mine);
                    }
                }
                _ = write!(
                    out,
                    "\nstatic void\nglue_codel_{number}(uint32_t instance, struct glue_buffer *out)\n{{\n\
                     \x20 void **glue_v = glue_params(instance);\n\
                     \x20 struct glue_s{at} *glue_p = glue_v ? (struct glue_s{at} *)*glue_v : NULL;\n\
                     \x20 struct glue_buffer b = {{ NULL, 0, 0 }};\n\
                     \x20 struct glue_reader r = {{ NULL, 0, 0 }};\n  (void)r;\n\
                     \x20 if (glue_p == NULL) return;\n{copies}  free(b.bytes);\n\
                     \x20 glue_put_number(out, GLUE_EVENT);\n  glue_put_text(out, \"\", 0);\n\
                     \x20 glue_put_number(out, 0);\n  glue_finish(out);\n}}\n"
                );
                _ = writeln!(cases, "  case {number}: glue_codel_{number}(instance, out); break;");
            }
            number += 1;
        }
        // Details raised by an earlier codel do not belong to this one.
        let forget = if self.is_cxx() {
            ""
        } else {
            "  free(glue_raised_detail);\n  glue_raised_detail = NULL;\n"
        };
        _ = write!(
            out,
            "\nGLUE_C GLUE_EXPORT void\n\
             dotgen_glue_run(uint32_t codel, uint32_t instance, struct glue_buffer *out)\n{{\n\
             \x20 (void)instance;\n  glue_written.size = 0;\n  glue_writes = 0;\n{forget}  switch (codel) {{\n\
             {cases}  }}\n}}\n"
        );
        Ok(out)
    }

    /// The names of all events that a codel of the component can return.
    fn outcomes(&self) -> LangResult {
        let spec = self.expected.spec;
        let ids = spec.types.keys();
        let mut events = String::new();
        let mut exceptions = String::new();
        for ty in ids {
            let kind = &spec.ty(ty).kind;
            let (Ok(name), Some(full)) = (self.mapper.type_cname(ty), spec.full_name(ty)) else {
                continue;
            };
            match kind {
                TypeKind::Event | TypeKind::PauseEvent => {
                    _ = writeln!(events, "  {{ {name}, \"{full}\" }},");
                }
                TypeKind::Exception { members } if !self.is_cxx() => {
                    self.exception(&name, members, &mut exceptions)?;
                }
                _ => {}
            }
        }
        if !self.is_cxx() {
            system_exceptions(&mut exceptions);
        }
        let event = if self.is_cxx() { "genom::event" } else { "genom_event" };
        Ok(format!(
            "\nstatic const struct {{ const char *event; const char *name; }} glue_events[] = {{\n\
             {events}  {{ NULL, \"\" }}\n}};\n\n\
             static void\nglue_finish(struct glue_buffer *out)\n{{\n\
             \x20 glue_put_number(out, glue_writes);\n\
             \x20 glue_put(out, glue_written.bytes, glue_written.size);\n}}\n\n\
             static void\nglue_tell_event({event} event, struct glue_buffer *out)\n{{\n\
             \x20 size_t i, from;\n  (void)from;\n\
             \x20 for (i = 0; i < sizeof(glue_events) / sizeof(glue_events[0]); i++)\n\
             \x20   if (glue_events[i].event == event) {{\n\
             \x20     glue_put_number(out, GLUE_EVENT);\n\
             \x20     glue_put_text(out, glue_events[i].name, strlen(glue_events[i].name));\n\
             \x20     glue_put_number(out, 0);\n      return;\n    }}\n{exceptions}\
             \x20 glue_put_number(out, GLUE_OTHER);\n  glue_put_text(out, \"\", 0);\n\
             \x20 glue_put_number(out, 0);\n}}\n"
        ))
    }

    /// Writes the code that passes an exception on, with its detail.
    fn exception(
        &self,
        name: &str,
        members: &[TypeId],
        exceptions: &mut String,
    ) -> Result<(), crate::lang::LangError> {
        let mut save = String::new();
        for &member in members {
            let of = self.known(member)?;
            let member = self.mapper.short_name(member)?;
            _ = writeln!(save, "      glue_save_{of}(out, &d->{member});");
        }
        let detail = if members.is_empty() {
            String::new()
        } else {
            format!(
                "    if (glue_raised_detail != NULL && glue_raised_id == event) {{\n\
             \x20     {name}_detail *d = ({name}_detail *)glue_raised_detail;\n{save}    }}\n"
            )
        };
        *exceptions += &passing_on(&format!("{name}_id"), &detail);
        Ok(())
    }

    fn codel(&self, number: usize, at: CodelRef, codel: &Codel) -> LangResult {
        let component = self.expected.component;
        let mut arguments = Vec::new();
        for param in &codel.params {
            let remote = matches!(param.source, ParamSource::Port(_) | ParamSource::Remote(_));
            let passing = match param.dir {
                _ if remote => PassingMode::Value,
                ParamDir::In => PassingMode::Value,
                ParamDir::Out | ParamDir::Inout => PassingMode::Reference,
                ParamDir::Local => continue,
            };
            let ty = param_types(self.expected.spec, component, param).1;
            let variable = self.variable(param)?;
            arguments.push(self.mapper.pass(ty, passing, &variable)?);
        }
        let params = match at.owner {
            Owner::Service(service) => format!(
                "  void **glue_v = glue_params(instance);\n\
                 \x20 struct glue_s{service} *glue_p = glue_v ? (struct glue_s{service} *)*glue_v : NULL;\n\
                 \x20 if (glue_p == NULL) return;\n"
            ),
            Owner::Task(_) => String::new(),
        };
        if !self.is_cxx() {
            arguments.push("&glue_context".into());
            let call = self.mapper.invoke(component, codel, &arguments)?;
            let keep = self.keep_written(codel)?;
            return Ok(format!(
                "\nstatic void\nglue_codel_{number}(uint32_t instance, struct glue_buffer *out)\n{{\n\
                 \x20 genom_event event;\n{params}  (void)instance;\n  event = {call};\n{keep}\
                 \x20 glue_tell_event(event, out);\n  glue_finish(out);\n}}\n"
            ));
        }
        let call = self.mapper.invoke(component, codel, &arguments)?;
        let mut catches = String::new();
        let spec = self.expected.spec;
        let syserr = "genom::syserr".to_owned();
        let mut known =
            vec![(syserr, "    glue_put(out, &e.detail, sizeof(e.detail));\n".to_owned())];
        known.push((
            "genom::unkex".to_owned(),
            "    glue_put(out, &e.detail, sizeof(e.detail));\n".to_owned(),
        ));
        for ty in spec.types.keys() {
            let TypeKind::Exception { members } = &spec.ty(ty).kind else {
                continue;
            };
            let mut save = String::new();
            for &member in members {
                let of = self.known(member)?;
                let member = self.mapper.short_name(member)?;
                _ = writeln!(save, "    glue_save_{of}(out, &e.detail.{member});");
            }
            known.push((self.mapper.type_cname(ty)?, save));
        }
        for (name, save) in known {
            _ = write!(
                catches,
                "  catch ({name} &e) {{\n    glue_put_number(out, GLUE_EXCEPTION);\n\
                 \x20   glue_put_text(out, e.what(), strlen(e.what()));\n\
                 \x20   size_t from = glue_begin_block(out);\n{save}    glue_end_block(out, from);\n  }}\n"
            );
        }
        Ok(format!(
            "\nstatic void\nglue_codel_{number}(uint32_t instance, struct glue_buffer *out)\n{{\n\
             {params}  (void)instance;\n  try {{\n\
             \x20   genom::event event = {call};\n    glue_tell_event(event, out);\n  }}\n{catches}\
             \x20 catch (genom::exception &e) {{\n    glue_put_number(out, GLUE_EXCEPTION);\n\
             \x20   glue_put_text(out, e.what(), strlen(e.what()));\n    glue_put_number(out, 0);\n  }}\n\
             \x20 catch (std::exception &e) {{\n    glue_put_number(out, GLUE_OTHER);\n\
             \x20   glue_put_text(out, e.what(), strlen(e.what()));\n    glue_put_number(out, 0);\n  }}\n\
             \x20 catch (...) {{\n    glue_put_number(out, GLUE_OTHER);\n    glue_put_text(out, \"\", 0);\n\
             \x20   glue_put_number(out, 0);\n  }}\n  glue_finish(out);\n}}\n"
        ))
    }

    /// The part that is the same for every component.
    pub(super) fn entries(&self) -> String {
        "\nGLUE_C GLUE_EXPORT void\ndotgen_glue_drop(struct glue_buffer *b)\n{\n  free(b->bytes);\n\
         \x20 b->bytes = NULL;\n  b->size = b->room = 0;\n}\n\n\
         GLUE_C GLUE_EXPORT void\n\
         dotgen_glue_asks(int (*asks)(uint32_t, const void *, size_t,\n\
         \x20                           void (*)(void *, const void *, size_t), void *))\n{\n\
         \x20 glue_asks = asks;\n}\n"
            .to_owned()
    }
}

/// Writes the code that passes the exceptions of GenoM3 itself on.
fn system_exceptions(exceptions: &mut String) {
    for (name, detail) in [("genom_syserr", true), ("genom_unkex", true), ("genom_fatal", false)] {
        let (id, detail) = if detail {
            (
                format!("{name}_id"),
                format!(
                    "    if (glue_raised_detail != NULL && glue_raised_id == event)\n\
                 \x20     glue_put(out, glue_raised_detail, sizeof({name}_detail));\n"
                ),
            )
        } else {
            (name.to_owned(), String::new())
        };
        *exceptions += &passing_on(&id, &detail);
    }
}

/// The code that passes an exception on.
fn passing_on(id: &str, detail: &str) -> String {
    format!(
        "  if (event == {id}) {{\n    glue_put_number(out, GLUE_EXCEPTION);\n\
         \x20   glue_put_text(out, event, strlen(event));\n\
         \x20   from = glue_begin_block(out);\n{detail}    glue_end_block(out, from);\n\
         \x20   return;\n  }}\n"
    )
}
