//! The questions of templates about the model.

use std::rc::Rc;

use dotgen_analysis::release::{Change, Release};

use super::{Reply, TemplateRun};
use crate::frontend::ParseFailure;
use crate::lang::{LangError, Language, MapObject, Mapper, NoPlaces, PassingMode, text};
use crate::template::api::{self, Answer};
use crate::template::model::Model;
use crate::template::object::{Object, Registry};
use crate::template::{Failure, notice_of, readable_files, tcl};

impl TemplateRun<'_> {
    pub(super) fn query(
        &mut self,
        language: Language,
        what: &str,
        words: &[String],
        more: &mut String,
    ) -> Reply {
        match what {
            "object" => self.call_object(language, words, more),
            "dotgen" => self.dotgen(words),
            "language" => self.language(language, words),
            "objects" => self.objects(language, words),
            "text" => text_helper(language, words),
            other => Err(Failure::Error(format!("unknown question {other}"))),
        }
    }

    /// Runs `ask` with the current model and a function that evaluates lambdas.
    pub(super) fn with_model<T>(
        &mut self,
        language: Language,
        ask: impl FnOnce(&Model<'_>, &mut api::Lambda<'_>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let compiled = self.compiled.clone();
        let registry = Rc::clone(&self.registry);
        let template = self.run.name();
        let model = Model {
            spec: &compiled.spec,
            places: &*compiled.places,
            registry: &registry,
            template: &template,
            language,
        };
        ask(&model, &mut |lambda, handle| self.evaluate(&tcl::list(["apply", lambda, handle])))
    }

    fn call_object(&mut self, language: Language, words: &[String], more: &mut String) -> Reply {
        let Some(handle) = words.first() else {
            return Err(Failure::Error("missing object".into()));
        };
        let object = self.object(handle)?;
        self.with_model(language, |model, lambda| {
            let answer = model.call(&object, &words[1..], lambda);
            // Further questions about the object are likely: answering them now saves their round trips.
            let mut others = Vec::new();
            for method in Model::cheap_methods(&object) {
                let words = [(*method).to_owned()];
                let (good, text) = match model.call(&object, &words, lambda) {
                    Ok(answer) => ("1", answer.text),
                    Err(Failure::Error(message)) => ("0", message),
                    Err(_) => continue,
                };
                others.extend([(*method).to_owned(), good.to_owned(), text]);
            }
            *more = tcl::list(&others);
            answer
        })
    }

    pub(super) fn object(&self, handle: &str) -> Result<Object, Failure> {
        let found = self.registry.object(handle).cloned();
        found.ok_or_else(|| Failure::Error(format!("invalid command name \"{handle}\"")))
    }

    /// Evaluates a script at global level in the main interpreter.
    pub(super) fn evaluate(&mut self, script: &str) -> Result<String, Failure> {
        self.host.send(&[b"eval", script.as_bytes(), b"0", b""]).map_err(Failure::Stop)?;
        loop {
            let words = self.host.receive().map_err(Failure::Stop)?;
            if words.first().is_some_and(|word| word == b"return") {
                let text = |index: usize| words.get(index).map(|word| tcl::decode(word));
                let result = text(2).unwrap_or_default();
                return match text(1).as_deref() {
                    Some("0" | "2") => Ok(result),
                    _ => Err(Failure::Error(result)),
                };
            }
            self.answer(words).map_err(Failure::Stop)?;
        }
    }

    fn dotgen(&mut self, words: &[String]) -> Reply {
        let word = |index: usize| words.get(index).map_or("", String::as_str);
        let flag = |on: bool| Ok(Answer::pure(u8::from(on).to_string()));
        let run = self.run;
        match (word(0), word(1)) {
            ("genom", "program") => Ok(Answer::pure(run.program.clone())),
            ("genom", "cmdline") => Ok(Answer::pure(run.cmdline.clone())),
            ("genom", "version") => {
                Ok(Answer::pure(format!("genom {}", self.compiled.spec.release)))
            }
            ("genom", "templates") => Ok(Answer::pure(tcl::list(run.search.list(&*run.disk)))),
            ("genom", "debug") => flag(run.debug),
            ("genom", "verbose") => flag(run.verbose),
            ("template", "name") => Ok(Answer::pure(run.name())),
            ("template", "dir") => Ok(Answer::pure(run.dir.display().to_string())),
            ("template", "builtindir") => {
                let dir = run.search.builtin.as_ref();
                let dir = dir.map(|directory| directory.display().to_string());
                Ok(Answer::pure(dir.unwrap_or_default()))
            }
            ("template", "tmpdir") => Ok(Answer::pure(self.tmpdir.display().to_string())),
            ("input", "notice") => match &self.notice {
                Some(notice) => Ok(Answer::pure(notice.clone())),
                None => Err(Failure::Error("no notice found".into())),
            },
            ("input", "path") => Ok(Answer::pure(run.input_path.clone())),
            ("input", "deps") => Ok(Answer::pure(tcl::list(&self.compiled.deps))),
            (what @ ("types" | "components" | "interfaces"), _) => {
                if words.len() > 2 {
                    return Err(Failure::Error(format!(
                        "wrong # args: should be \"dotgen {what} ?pattern?\""
                    )));
                }
                Ok(self.listing(what, words.get(1)))
            }
            (what, _) => Err(Failure::Error(format!("unknown question {what}"))),
        }
    }

    fn listing(&self, what: &str, glob: Option<&String>) -> Answer {
        let spec = &self.compiled.spec;
        let objects: Vec<Object> = if what == "types" {
            let types = spec.types.keys();
            types
                .filter(|ty| {
                    glob.is_none_or(|glob| {
                        let name = spec.full_name(*ty);
                        name.is_some_and(|name| tcl::glob_match(glob, &name))
                    })
                })
                .map(Object::Type)
                .collect()
        } else {
            let components = spec.components.iter_enumerated();
            components
                .filter(|(_, component)| {
                    let interface =
                        component.kind == dotgen_analysis::model::ComponentKind::Interface;
                    interface == (what == "interfaces")
                        && glob.is_none_or(|glob| tcl::glob_match(glob, &component.name))
                })
                .map(|(index, _)| Object::Component(index))
                .collect()
        };
        Answer::pure(tcl::list(self.registry.handles(objects)))
    }

    fn objects(&mut self, language: Language, words: &[String]) -> Reply {
        let usage =
            |usage: &str| Failure::Error(format!("wrong # args: should be \"object {usage}\""));
        match words.first().map_or("", String::as_str) {
            "unique" => {
                let [_, list] = words else {
                    return Err(usage("unique list"));
                };
                let mut seen = Vec::new();
                for element in tcl::parse_list(list).map_err(Failure::Error)? {
                    if !seen.contains(&element) {
                        seen.push(element);
                    }
                }
                Ok(Answer::pure(tcl::list(&seen)))
            }
            what @ ("types" | "digest") => {
                let least = if what == "types" { 3 } else { 2 };
                if words.len() < least || words.len() > least + 1 {
                    return Err(usage(if what == "types" {
                        "types object visibility ?filter?"
                    } else {
                        "digest object ?filter?"
                    }));
                }
                let Ok(object) = self.object(&words[1]) else {
                    return Err(Failure::Error("not a genom object".into()));
                };
                self.with_model(language, |model, lambda| {
                    api::closure(model, what, &object, &words[2..], lambda)
                })
            }
            other => Err(Failure::Error(format!("unknown question {other}"))),
        }
    }

    /// `language PROCEDURE ARGUMENT...`.
    fn language(&mut self, language: Language, words: &[String]) -> Reply {
        let procedure = words.first().map_or("", String::as_str);
        let arguments = words.get(1..).unwrap_or_default();
        let (least, most, usage) = arity(procedure, self.compiled.spec.release);
        if arguments.len() < least || arguments.len() > most {
            return Err(Failure::Error(format!(
                "wrong # args: should be \"language {procedure} {usage}\""
            )));
        }
        let argument = |index: usize| arguments.get(index).map_or("", String::as_str);
        let compiled = self.compiled.clone();
        let mapper = Mapper::new(&compiled.spec, &*compiled.places, language);
        let ty = || match self.object(argument(0))? {
            Object::Type(ty) => Ok(ty),
            _ => Err(Failure::Error(format!("{} is not a type", argument(0)))),
        };
        let codel = || match self.object(argument(0))? {
            Object::Codel(component, at) => {
                let codel = compiled.spec.components[component].codel(at);
                Ok((component, codel))
            }
            _ => Err(Failure::Error(format!("{} is not a codel", argument(0)))),
        };
        let list = |index: usize| tcl::parse_list(argument(index)).map_err(Failure::Error);
        let text = match procedure {
            "address" => mapper.address(ty()?, argument(1))?,
            "argument" => {
                mapper.argument(ty()?, PassingMode::from_name(argument(1))?, argument(2))?
            }
            "dereference" if language == Language::Cxx => argument(2).to_owned(),
            "dereference" => {
                mapper.dereference(ty()?, PassingMode::from_name(argument(1))?, argument(2))?
            }
            "pass" => mapper.pass(ty()?, PassingMode::from_name(argument(1))?, argument(2))?,
            "cname" => match self.registry.object(argument(0)) {
                Some(Object::Type(ty)) => mapper.type_cname(*ty)?,
                Some(Object::Codel(..)) => mapper.cname(&codel()?.1.name)?,
                _ => mapper.cname(argument(0))?,
            },
            "declarator" => mapper.declarator(ty()?, argument(1))?,
            "invoke" => {
                let (component, codel) = codel()?;
                mapper.invoke(component, codel, &list(1)?)?
            }
            "mangle" => mapper.mangle(ty()?)?,
            "mapping" => self.mapping(&mapper, &list(0)?, arguments.get(1))?,
            "member" => mapper.member(ty()?, &list(1)?)?,
            "return-value" => mapper.return_value_by_name(ty()?, argument(1), argument(2))?,
            _ => {
                let separator = arguments.get(1).map_or(" ", String::as_str);
                let location = match arguments.get(2) {
                    Some(text) => api::boolean(text)?,
                    None => false,
                };
                let (component, codel) = codel()?;
                mapper.signature(component, codel, separator, location)?
            }
        };
        Ok(Answer::pure(text))
    }

    /// The declarations of objects, or of all types.
    fn mapping(
        &self,
        mapper: &Mapper<'_>,
        handles: &[String],
        locations: Option<&String>,
    ) -> Result<String, Failure> {
        let mut objects = Vec::new();
        for handle in handles {
            match api::map_object(&self.object(handle)?) {
                Some(object) => objects.push(object),
                None => {
                    return Err(Failure::Error(format!("{handle} has no mapping")));
                }
            }
        }
        if objects.is_empty() {
            let all = self.compiled.spec.types.keys().map(MapObject::Type);
            objects.extend(all);
        }
        let locations = match locations {
            Some(text) => api::boolean(text)?,
            None => true,
        };
        Ok(mapper.mapping(&objects, locations)?)
    }

    /// A confined template may read the specifications given to it, those of the folders it may write to, and
    /// its own.
    ///
    /// # Errors
    /// Fails for any other file.
    fn check_input(&self, file: &str) -> Result<(), Failure> {
        let path = self.run.base.join(file);
        let results = self.run.confined.map(|confinement| confinement.results.as_slice());
        if results.is_some_and(|paths| readable_files::is_below(&*self.run.disk, &path, paths)) {
            Ok(())
        } else {
            self.check_read(&path)
        }
    }

    pub(super) fn parse(&mut self, what: &str, inputs: &[String]) -> Reply {
        let words = ["file", "string"];
        let what = words[tcl::find_word(&words, what, "subcommand").map_err(Failure::Error)?];
        if what == "file" {
            for file in inputs {
                self.check_input(file)?;
            }
        }
        let console = &mut *self.console;
        let mut report = |line: &str| console.err(line);
        let result = if what == "file" {
            let folder = self.run.base.join(&self.run.input_path);
            if let Some(notice) = notice_of(&*self.run.disk, &folder, inputs) {
                self.notice.get_or_insert_default().push_str(&notice);
            }
            self.compiler.parse_files(inputs, &mut report)
        } else {
            self.compiler.parse_strings(inputs, &mut report)
        };
        self.compiled = self.compiler.compiled();
        let mut registry = std::mem::take(&mut self.registry);
        let created = if let Some(registry) = Rc::get_mut(&mut registry) {
            registry.update(&self.compiled.spec)
        } else {
            let mut copy = Registry::clone(&registry);
            let created = copy.update(&self.compiled.spec);
            registry = Rc::new(copy);
            created
        };
        self.registry = registry;
        match result {
            Ok(()) => {
                let mut created = created;
                created.append(&mut self.unannounced);
                Ok(Answer::volatile(tcl::list(&created)))
            }
            Err(failure) => {
                self.unannounced.extend(created);
                if let ParseFailure::Unreadable(reason) = &failure {
                    return Err(Failure::Error(reason.clone()));
                }
                Err(Failure::Error(failure.to_string()))
            }
        }
    }
}

/// `comment`, `fileext`, `---` and `wrap`.
fn text_helper(language: Language, words: &[String]) -> Reply {
    let name = words.first().map_or("", String::as_str);
    let mut arguments = words.get(1..).unwrap_or_default();
    let spec = dotgen_analysis::model::Spec::default();
    let mapper = Mapper::new(&spec, &NoPlaces, language);
    let option = arguments.first().and_then(|argument| argument.strip_prefix('-'));
    let answer = match name {
        "comment" => match option {
            Some(mark) => text::marked_comment(mark, &arguments[1..].join(" ")),
            None => mapper.comment(&arguments.join(" "))?,
        },
        "fileext" => {
            if arguments.len() > 1 {
                return Err(Failure::Error("wrong # args: should be \"fileext ?kind?\"".into()));
            }
            mapper.file_extension(arguments.first().is_some_and(|argument| argument == "header"))?
        }
        _ => {
            let mut column = 70;
            if let Some(digits) = option {
                let valid = digits.chars().all(|c| c.is_ascii_digit());
                column = digits
                    .parse()
                    .ok()
                    .filter(|_| valid)
                    .ok_or_else(|| LangError::fatal(format!("bad column \"-{digits}\"")))?;
                arguments = &arguments[1..];
            }
            if name == "---" {
                let filler = arguments.last().and_then(|argument| argument.chars().last());
                let words = arguments.split_last().map_or(&[][..], |(_, words)| words);
                text::rule(&words.join(" "), filler, column)
            } else {
                let argument = |index: usize| arguments.get(index).map_or("", String::as_str);
                let separator = arguments.get(2).map_or(" ", String::as_str);
                let column = usize::try_from(column).unwrap_or(70);
                text::wrap(argument(0), argument(1), separator, column)
            }
        }
    };
    Ok(Answer::volatile(answer))
}

/// The least and most arguments of a procedure of `language`, and its usage.
fn arity(procedure: &str, release: Release) -> (usize, usize, &'static str) {
    match procedure {
        "address" => (1, 2, "type ?var?"),
        "argument" | "dereference" | "pass" => (2, 3, "type kind ?var?"),
        "cname" => (1, 1, "object"),
        "declarator" => (1, 2, "type ?var?"),
        "invoke" => (2, 2, "codel params"),
        "mangle" => (1, 1, "type"),
        "mapping" => (0, 2, "?objects? ?locations?"),
        "member" => (2, 2, "type mlist"),
        "return-value" if !release.has(Change::ReturnValueVariables) => (2, 2, "type kind"),
        "return-value" => (2, 3, "type kind ?var?"),
        _ => (1, 3, "codel ?symchar? ?location?"),
    }
}
