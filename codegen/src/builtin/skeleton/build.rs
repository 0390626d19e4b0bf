//! The files that build a skeleton, for autotools and pkg-config.

use dotgen_analysis::model::ComponentKind;

use super::fill::{Facts, TemplateWriter};
use crate::codels::expected::Expected;
use crate::template::object::Object;
use crate::template::tcl;

/// The input of a generation.
pub(super) struct Job<'a> {
    pub(super) facts: &'a Facts<'a>,
    /// Indexes into the components of the specification.
    pub(super) components: &'a [u32],
    /// The codels that the components expect, in the same order.
    pub(super) expected: &'a [Expected<'a>],
    /// The language the codels are compiled as.
    pub(super) language: String,
    pub(super) terse: bool,
    /// True for release 2.99.41, which has files for chosen components and for interfaces.
    pub(super) newer: bool,
    pub(super) inputs: &'a [String],
    /// The general options that affect includes.
    pub(super) cmdline: &'a str,
    pub(super) notice: Option<&'a str>,
}

impl Job<'_> {
    pub(super) fn name(&self, component: u32) -> &str {
        &self.facts.spec().components[component as usize].name
    }

    /// Name of the first input, without its folder.
    pub(super) fn input(&self) -> &str {
        let first = self.inputs.first().map_or("", String::as_str);
        first.rsplit('/').next().unwrap_or(first)
    }

    fn is_component(&self, component: u32) -> bool {
        self.facts.spec().components[component as usize].kind == ComponentKind::Component
    }

    /// True if there is a component, not only interfaces.
    pub(super) fn has_component(&self) -> bool {
        self.components.iter().any(|component| self.is_component(*component))
    }

    fn packages(&self, component: u32, question: &str) -> Option<Vec<String>> {
        self.facts.list(&Object::Component(component), &[question])
    }

    /// The file for pkg-config, for the installed or the uninstalled component.
    pub(super) fn package(&self, mut walk: TemplateWriter, component: u32) -> Option<String> {
        let name = self.name(component);
        walk.next().put(name).next().put(name).next().put(name).next();
        let requires = self.packages(component, "require")?;
        walk.when(1, !requires.is_empty(), |walk| {
            walk.next().put(&requires.join(", "));
            Some(())
        })?;
        walk.next().put(name).next();
        let codels = self.packages(component, "codels-require")?;
        walk.when(1, !codels.is_empty(), |walk| {
            walk.next();
            Some(())
        })?;
        walk.next();
        walk.done()
    }

    /// `configure.ac`
    pub(super) fn configure(&self, mut walk: TemplateWriter) -> Option<String> {
        let &first = self.components.first()?;
        let name = self.name(first);
        walk.next().put(name).next();
        walk.notice("dnl", self.notice);
        let version = self.facts.component(first, &["version"]);
        let email = self.facts.component(first, &["email"]);
        walk.next().put(name);
        walk.next().put(version.as_deref().unwrap_or("0"));
        walk.next().put(email.as_deref().unwrap_or_default());
        walk.next().put(name).next();
        let mut languages = vec![self.language.clone()];
        for &component in self.components {
            languages.push(self.facts.component(component, &["language"])?);
        }
        languages.sort();
        languages.dedup();
        for language in languages {
            walk.put(match language.as_str() {
                "c" => "AC_PROG_CC\n",
                "c++" => "AC_PROG_CXX\n",
                _ => return None,
            });
        }
        walk.next();
        let (mut requires, mut of_codels) = (Vec::new(), Vec::new());
        for &component in self.components {
            requires.extend(self.packages(component, "require")?);
            of_codels.extend(self.packages(component, "codels-require")?);
        }
        walk.next();
        let has_genom = requires.iter().any(|requirement| requirement.starts_with("genom3 "));
        walk.when(1, !has_genom, |walk| {
            walk.next();
            Some(())
        })?;
        walk.when(1, !requires.is_empty(), |walk| {
            walk.next().put(&requires.join("\n  "));
            Some(())
        })?;
        walk.next();
        walk.when(2, !of_codels.is_empty(), |walk| {
            walk.next().put(&of_codels.join("\n  ")).next();
            Some(())
        })?;
        walk.next();
        if self.newer {
            walk.when(3, self.has_component(), |walk| {
                walk.next().put(self.cmdline);
                walk.next().put(&tcl::list(self.inputs)).next();
                Some(())
            })?;
            walk.next();
        } else {
            walk.put(self.cmdline).next().put(self.input()).next();
        }
        walk.when(1, !self.terse, |walk| {
            walk.next();
            Some(())
        })?;
        walk.next();
        walk.each(3, self.components, |walk, number| {
            let name = self.name(*number);
            walk.next().put(name).next().put(name).next();
            Some(())
        })?;
        walk.next();
        if self.newer {
            // The template uses only the last component.
            let last = self.components.last()?;
            walk.when(1, self.is_component(*last), |walk| {
                walk.next();
                Some(())
            })?;
            walk.next();
        }
        walk.done()
    }

    /// `Makefile.am`, with the read files that are below it.
    pub(super) fn makefile(&self, mut walk: TemplateWriter, idls: &[String]) -> Option<String> {
        walk.notice("#", self.notice);
        walk.next().put(self.name(*self.components.first()?));
        walk.next().put(&tcl::list(idls)).next();
        walk.each(1, self.components, |walk, number| {
            walk.next().put(self.name(*number)).put("-genom3.pc");
            Some(())
        })?;
        walk.next();
        if self.newer {
            walk.when(1, self.has_component(), |walk| {
                walk.next();
                Some(())
            })?;
            walk.next();
        }
        walk.put(self.cmdline).next();
        let terse = if self.terse { " -t" } else { "" };
        if self.newer {
            walk.put(&format!("-l '{}'{terse}", self.language)).next();
        } else {
            walk.put(terse).next().put(&self.language).next();
        }
        walk.put(self.input());
        walk.when(1, !self.terse, |walk| {
            walk.next();
            Some(())
        })?;
        walk.next();
        walk.done()
    }

    /// `codels/Makefile.am`
    pub(super) fn makefile_of_codels(&self, mut walk: TemplateWriter) -> Option<String> {
        let extension = if self.language == "c++" { ".cc" } else { ".c" };
        walk.notice("#", self.notice);
        if self.newer {
            walk.next();
        }
        let mut headers: Vec<(String, String)> = Vec::new();
        let count = if self.newer { 14 } else { 13 };
        walk.each(count, self.expected, |walk, expected| {
            let component = expected.component;
            let name = self.name(component);
            let language = self.facts.component(component, &["lang"])?;
            let header = format!("{name}_{language}_types.h");
            if self.newer {
                walk.next().put(name);
            }
            walk.next().put(name).next().put(name);
            walk.next().put(&header).next().put(name);
            walk.next().put(&format!("{name}_codels{extension}"));
            let tasks = (0u32..).zip(&expected.component().tasks);
            walk.each(2, tasks.filter(|task| expected.has_file(task.0)), |walk, (_, task)| {
                walk.next().put(name);
                walk.next().put(&format!("{name}_{}_codels{extension}", task.name));
                Some(())
            })?;
            for _ in 0..5 {
                walk.next().put(name);
            }
            walk.next();
            match headers.iter_mut().find(|candidate| candidate.0 == header) {
                Some(known) => known.1 = language,
                None => headers.push((header, language)),
            }
            Some(())
        })?;
        let names: Vec<&str> = headers.iter().map(|header| header.0.as_str()).collect();
        walk.next().put(&tcl::list(&names)).next();
        walk.each(6, &headers, |walk, (header, language)| {
            walk.next().put(header).next().put(self.input());
            walk.next().put(self.cmdline).next().put(language);
            walk.next().put(header).next();
            Some(())
        })?;
        walk.next();
        walk.done()
    }
}
