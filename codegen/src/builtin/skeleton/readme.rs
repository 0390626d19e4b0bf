//! `README.adoc`: the services, ports and types of a component, from its documentation.

use std::collections::BTreeSet;

use super::build::Job;
use super::fill::{Facts, TemplateWriter};
use crate::template::object::Object;

/// The file.
pub(super) fn write(job: &Job<'_>, mut walk: TemplateWriter) -> Option<String> {
    let facts = job.facts;
    walk.notice("//", job.notice);
    heading(job, &mut walk)?;
    walk.next();
    each_of(job, &mut walk, 8, "ports", |walk, port| {
        let name = facts.text(port, &["name"])?;
        let multiple = facts.text(port, &["kind"])? == "multiple";
        walk.next().put(&name).next().put(&name).next();
        walk.put(if multiple { "multiple " } else { "" });
        walk.put(&facts.text(port, &["dir"])?).next();
        let of = facts.object(port, &["datatype"])?;
        walk.put(&job.type_lines(&name, &of, &DefaultValue::default(), " *", &[])?);
        walk.next();
        documentation(facts, walk, port)
    })?;
    walk.next();
    each_of(job, &mut walk, 27, "services", |walk, object| service(job, walk, object))?;
    walk.next();
    each_of(job, &mut walk, 16, "tasks", |walk, object| task(job, walk, object))?;
    walk.next();
    walk.done()
}

/// Title, authors and versions, and the documentation of components.
fn heading(job: &Job<'_>, walk: &mut TemplateWriter) -> Option<()> {
    let facts = job.facts;
    walk.next().put(job.input()).next().put(facts.template);
    walk.next().put(job.input()).next();
    let mut titles = Vec::new();
    let mut authors = Vec::new();
    let mut versions = Vec::new();
    for &component in job.components {
        let name = job.name(component);
        let version = facts.component(component, &["version"]);
        authors.extend(facts.component(component, &["email"]));
        if job.newer {
            titles.push(format!("{name} {}", facts.component(component, &["class"])?));
            versions.extend(version);
        } else {
            titles.push(name.to_owned());
            versions.push(version?);
        }
    }
    walk.put(&titles.join(", "));
    if !job.newer {
        walk.next();
    }
    walk.when(1, job.newer || !authors.is_empty(), |walk| {
        walk.next().put(&authors.join(", "));
        Some(())
    })?;
    walk.next().put(&versions.join(", ")).next();
    walk.each(1, job.components, |walk, number| {
        if let Some(doc) = facts.component(*number, &["doc"]) {
            walk.next().put(&doc);
        }
        Some(())
    })?;
    walk.next();
    Some(())
}

/// `count` texts for each item of each component.
fn each_of(
    job: &Job<'_>,
    walk: &mut TemplateWriter,
    count: usize,
    question: &str,
    mut write: impl FnMut(&mut TemplateWriter, &Object) -> Option<()>,
) -> Option<()> {
    let mut things = Vec::new();
    for &component in job.components {
        things.extend(job.facts.objects(&Object::Component(component), &[question])?);
    }
    walk.each(count, &things, |walk, object| write(walk, object))
}

/// Three texts around the documentation of an object.
fn documentation(facts: &Facts<'_>, walk: &mut TemplateWriter, of: &Object) -> Option<()> {
    let doc = facts.text(of, &["doc"]);
    walk.when(2, doc.is_some(), |walk| {
        walk.next().put(doc.as_deref()?).next();
        Some(())
    })?;
    walk.next();
    Some(())
}

fn service(job: &Job<'_>, walk: &mut TemplateWriter, service: &Object) -> Option<()> {
    let facts = job.facts;
    let name = facts.text(service, &["name"])?;
    walk.next().put(&name).next().put(&name);
    walk.next().put(&facts.text(service, &["kind"])?).next();
    let parameters = facts.objects(service, &["parameter"])?;
    let throws = facts.objects(service, &["throws"])?;
    let task = facts.object(service, &["task"]);
    let interrupts = facts.objects(service, &["interrupts"])?;
    let context = task.is_some() || !interrupts.is_empty();
    let wanted = !parameters.is_empty() || !throws.is_empty() || context;
    walk.when(19, wanted, |walk| {
        walk.next();
        for directions in [["in", "inout"], ["inout", "out"]] {
            let question = ["parameter", directions[0], directions[1]];
            let some = facts.objects(service, &question)?;
            walk.when(2, !some.is_empty(), |walk| {
                walk.next();
                walk.each(1, &some, |walk, parameter| {
                    walk.next().put(&job.parameter_lines(parameter)?);
                    Some(())
                })
            })?;
        }
        thrown(job, walk, &throws)?;
        walk.when(11, context, |walk| {
            walk.next();
            walk.when(8, task.is_some(), |walk| {
                let task = task.as_ref()?;
                walk.next().put(&facts.text(task, &["name"])?).next();
                let frequency = frequency(facts, task)?;
                walk.when(2, frequency.is_some(), |walk| {
                    walk.next().put(frequency.as_deref()?).next();
                    Some(())
                })?;
                ports(facts, walk, service)
            })?;
            walk.each(2, &interrupts, |walk, object| {
                walk.next().put(&facts.text(object, &["name"])?).next();
                Some(())
            })
        })?;
        walk.next();
        Some(())
    })?;
    walk.next();
    documentation(facts, walk, service)
}

fn task(job: &Job<'_>, walk: &mut TemplateWriter, task: &Object) -> Option<()> {
    let facts = job.facts;
    let name = facts.text(task, &["name"])?;
    walk.next().put(&name).next().put(&name).next();
    let frequency = frequency(facts, task)?;
    walk.when(2, frequency.is_some(), |walk| {
        walk.next().put(frequency.as_deref()?).next();
        Some(())
    })?;
    walk.when(1, frequency.is_none(), |walk| {
        walk.next();
        Some(())
    })?;
    ports(facts, walk, task)?;
    let throws = facts.objects(task, &["throws"])?;
    thrown(job, walk, &throws)?;
    walk.next();
    documentation(facts, walk, task)
}

/// Two texts for exceptions.
fn thrown(job: &Job<'_>, walk: &mut TemplateWriter, throws: &[Object]) -> Option<()> {
    walk.when(2, !throws.is_empty(), |walk| {
        walk.next();
        walk.each(1, throws, |walk, object| {
            walk.next();
            walk.put(&job.type_lines("", object, &DefaultValue::default(), " *", &[])?);
            Some(())
        })
    })
}

/// Four texts: two for each port that codels write, two for each port that they read.
fn ports(facts: &Facts<'_>, walk: &mut TemplateWriter, owner: &Object) -> Option<()> {
    let mut used = BTreeSet::new();
    for codel in facts.objects(owner, &["codels"])? {
        for parameter in facts.objects(&codel, &["parameters", "port"])? {
            used.insert(facts.text(&parameter, &["port"])?);
        }
    }
    walk.each(4, &used, |walk, port| {
        let port = facts.object_of(port)?;
        let name = facts.text(&port, &["name"])?;
        let written = facts.text(&port, &["dir"])? == "out";
        for of_written in [true, false] {
            walk.when(2, written == of_written, |walk| {
                walk.next().put(&name).next();
                Some(())
            })?;
        }
        Some(())
    })
}

/// The inverse of a task's period, as Tcl prints it; the inner `None` without a period.
#[allow(clippy::option_option, reason = "no answer is not the same as no period")]
fn frequency(facts: &Facts<'_>, task: &Object) -> Option<Option<String>> {
    let Some(period) = facts.object(task, &["period"]) else {
        return Some(None);
    };
    let period = facts.text(&period, &["value"])?;
    if let Ok(whole) = period.parse::<i64>() {
        return Some(Some(1i64.checked_div(whole).filter(|_| whole > 0)?.to_string()));
    }
    let frequency = 1.0 / period.parse::<f64>().ok()?;
    // Tcl prints exponents in another form outside of this range.
    let plain = (1e-4..1e15).contains(&frequency);
    plain.then(|| Some(format!("{frequency:?}")))
}

/// A default value, as a tree.
#[derive(Default, Clone)]
struct DefaultValue {
    doc: Option<String>,
    value: Option<String>,
    /// Name of a member or index, and its default.
    items: Vec<(String, DefaultValue)>,
}

impl DefaultValue {
    fn of(facts: &Facts<'_>, object: &Object) -> Option<DefaultValue> {
        let mut out = DefaultValue { doc: facts.text(object, &["doc"]), ..DefaultValue::default() };
        match facts.text(object, &["kind"])?.as_str() {
            "void" => {}
            "compound" => {
                for part in facts.objects(object, &["value"])? {
                    let name = facts.text(&part, &["member"])?;
                    let item = DefaultValue::of(facts, &part)?;
                    match out.items.iter_mut().find(|entry| entry.0 == name) {
                        Some(known) => known.1 = item,
                        None => out.items.push((name, item)),
                    }
                }
            }
            _ => out.value = facts.text(object, &["value"]),
        }
        Some(out)
    }

    fn item(&self, name: &str) -> DefaultValue {
        let found = self.items.iter().find(|entry| entry.0 == name);
        found.map(|pair| pair.1.clone()).unwrap_or_default()
    }
}

impl Job<'_> {
    fn parameter_lines(&self, parameter: &Object) -> Option<String> {
        let facts = self.facts;
        let initial = facts.object(parameter, &["initializer"]);
        let initial =
            initial.and_then(|object| DefaultValue::of(facts, &object)).unwrap_or_default();
        let name = facts.text(parameter, &["name"])?;
        let of = facts.object(parameter, &["type"])?;
        self.type_lines(&name, &of, &initial, " *", &[])
    }

    /// A type as a nested list. `around`: the enclosing sequences and optionals, outermost first.
    fn type_lines(
        &self,
        name: &str,
        of: &Object,
        initial: &DefaultValue,
        prefix: &str,
        around: &[String],
    ) -> Option<String> {
        let facts = self.facts;
        let kind = facts.text(of, &["kind"])?;
        let inner = || facts.object(of, &["type"]);
        let deeper = format!("{prefix}*");
        // 2.99.39 drops the enclosing types if another type comes between.
        let kept = if self.newer { around } else { &[] };
        let items = |out: &mut String| {
            for (index, item) in &initial.items {
                *out += &self.type_lines(&format!("[{index}]"), &inner()?, item, &deeper, &[])?;
            }
            Some(())
        };
        match kind.as_str() {
            "typedef" => self.type_lines(name, &inner()?, initial, prefix, kept),
            "array" => {
                let name = format!("{name}[{}]", facts.text(of, &["length"])?);
                let mut out = self.type_lines(&name, &inner()?, initial, prefix, kept)?;
                items(&mut out)?;
                Some(out)
            }
            "sequence" => {
                let length = facts.text(of, &["length"]).unwrap_or_else(|| "-1".into());
                let around = [kept, &[length]].concat();
                let mut out = self.type_lines(name, &inner()?, initial, prefix, &around)?;
                items(&mut out)?;
                Some(out)
            }
            "optional" => self.type_lines(name, &inner()?, initial, prefix, &["0".into()]),
            "struct" | "exception" => {
                let mut out = format!("{prefix} `{}`", self.words(of, &kind, around)?);
                out += &label(name);
                if let Some(doc) = &initial.doc {
                    out += &format!(": {doc}");
                }
                out.push('\n');
                for member in facts.objects(of, &["members"])? {
                    let name = facts.text(&member, &["name"])?;
                    let of = facts.object(&member, &["type"])?;
                    out += &self.type_lines(&name, &of, &initial.item(&name), &deeper, &[])?;
                }
                Some(out)
            }
            _ => {
                let mut out = format!("{prefix} `{}`", self.words(of, &kind, around)?);
                out += &label(name);
                if let Some(value) = &initial.value {
                    out += &format!(" (default `\"{value}\"`)");
                }
                if let Some(doc) = &initial.doc {
                    out += &format!(" {doc}");
                }
                if kind == "enum" {
                    let members = facts.objects(of, &["members"])?;
                    let names = members.iter().map(|member| facts.text(member, &["name"]));
                    let names: Option<Vec<String>> =
                        names.map(|name| Some(format!("`{}`", name?))).collect();
                    out += &format!(" \u{2208} {{ {} }}", names?.join(", "));
                }
                out.push('\n');
                Some(out)
            }
        }
    }

    /// The words for a type that is not a sequence or optional: its kind, its name, and the enclosing types.
    fn words(&self, of: &Object, kind: &str, around: &[String]) -> Option<String> {
        let facts = self.facts;
        let mut out = kind.to_owned();
        if matches!(kind, "enum" | "struct" | "exception") {
            out += &format!(" {}", facts.text(of, &["fullname"])?);
        }
        if let Some(length) = facts.text(of, &["length"]) {
            out += &format!("<{length}>");
        }
        for length in around.iter().rev() {
            out = match length.as_str() {
                "0" => format!("optional< {out} >"),
                "-1" => format!("sequence< {out} >"),
                _ => format!("sequence< {out}, {length} >"),
            };
        }
        Some(out)
    }
}

fn label(name: &str) -> String {
    match name {
        "" => String::new(),
        _ => format!(" `{name}`"),
    }
}
