//! Declarations of codels for functions.

use camino::Utf8Path;
use dotgen_analysis::model::{CodelKind, CodelRef, Owner, ServiceKind, TypeKind};

use super::Repairs;
use super::specification::parameter_list;
use crate::codels::{
    edit::Edit,
    expected::cut_tag,
    source::{Function, Layer, Parameter, Value},
};
use crate::lang::Language;

impl Repairs<'_> {
    /// Declares a codel for a function, in the task or service that its comment or its file shows. `None` if
    /// that, a state or a parameter cannot be determined.
    pub(super) fn declare_codel(&self, function: &Function, path: &Utf8Path) -> Option<Edit> {
        let owner = self.owner_of(function, path)?;
        let text = self.declaration(function, owner)?;
        let (at, body) = self.body(owner)?;
        let mut edit = Edit::default();
        self.add_property(&at, body, &text, &mut edit);
        Some(edit)
    }

    /// The task or service whose braces contain an offset.
    pub fn owner_at(&self, path: &Utf8Path, offset: usize) -> Option<Owner> {
        let component = self.expected.component();
        component.owners().find(|task| {
            let found = self.body(*task);
            found.is_some_and(|(at, body)| {
                at.path == path && body.start <= offset && offset <= body.end
            })
        })
    }

    /// The parameters of a codel of a task or service for a function, as far as they can be determined.
    pub fn parameters_of(&self, function: &Function, owner: Owner) -> Vec<String> {
        let mut parameters = function.parameters.as_slice();
        if self.expected.language == Language::C {
            parameters = parameters.split_last().map_or(&[], |(_, rest)| rest);
        }
        parameters.iter().filter_map(|parameter| self.parameter(parameter, owner)).collect()
    }

    /// `codel<start> f(in x) yield ether;`
    pub fn declaration(&self, function: &Function, owner: Owner) -> Option<String> {
        let component = self.expected.component();
        let mut parameters = function.parameters.as_slice();
        if self.expected.language == Language::C {
            parameters = parameters.split_last()?.1;
        }
        let parameters: Option<Vec<String>> =
            parameters.iter().map(|parameter| self.parameter(parameter, owner)).collect();
        let parameters = parameters?.join(", ");
        let name = &function.name;
        let comment = function.comments.iter().find_map(|comment| comment.generated.as_ref());
        if comment.is_some_and(|comment| comment.validation) {
            return Some(format!("validate {name}({parameters});"));
        }
        let machine = match owner {
            Owner::Task(_) => true,
            Owner::Service(service) => component.services[service].kind == ServiceKind::Activity,
        };
        if !machine {
            return Some(format!("codel {name}({parameters});"));
        }
        let state = |event: &str| {
            let (paused, state) = cut_tag(event, &component.name);
            format!("{}{state}", if paused { "pause::" } else { "" })
        };
        let triggers = comment.and_then(|comment| comment.triggers.as_ref())?;
        let triggers: Vec<String> = triggers.iter().map(|trigger| state(trigger)).collect();
        let codels = component.codels_of(owner).iter();
        let mut handled =
            codels.filter(|codel| codel.kind == CodelKind::Fsm).flat_map(|codel| &codel.triggers);
        // A state has only one codel.
        if triggers.is_empty()
            || handled.any(|trigger| triggers.contains(&trigger.name.to_string()))
        {
            return None;
        }
        let mut yields: Vec<String> = Vec::new();
        let values = function.body.as_ref()?.returns.iter().flat_map(|result| &result.values);
        for value in values {
            if let Value::Name { name, .. } = value {
                let prefix = format!("{}{}", component.name, self.expected.separator());
                let text = state(name);
                if name.starts_with(&prefix) && !yields.contains(&text) {
                    yields.push(text);
                }
            }
        }
        if yields.is_empty() {
            return None;
        }
        Some(format!(
            "codel<{}> {name}({parameters})\n    yield {};",
            triggers.join(", "),
            yields.join(", ")
        ))
    }

    /// Gives a codel the parameters of its function. The text of a parameter stays if the function has one of
    /// its name with the same type. `None` if a parameter cannot be determined, or if nothing changes.
    pub(super) fn adapt_parameters(&self, at: CodelRef, function: &Function) -> Option<Edit> {
        let codel = self.expected.component().codel(at);
        let name = self.at(codel.src, &codel.name)?;
        let (list, items) = parameter_list(&name.text, name.range.end)?;
        let wanted = self.expected.function(&codel.name)?.shape.as_ref()?;
        let mut parameters = function.parameters.as_slice();
        if self.expected.language == Language::C {
            parameters = parameters.split_last()?.1;
        }
        let written = |parameter: &Parameter| {
            let index = codel
                .params
                .iter()
                .position(|known| Some(known.name.as_str()) == parameter.name.as_deref())?;
            let same = wanted.parameters.get(index)?.ty == parameter.ty;
            items.get(index).filter(|_| same).map(|item| name.text[item.clone()].to_owned())
        };
        let adapted: Option<Vec<String>> = parameters
            .iter()
            .map(|parameter| written(parameter).or_else(|| self.parameter(parameter, at.owner)))
            .collect();
        // Comments between parameters would be lost.
        let starts = items.iter().map(|item| item.start).chain([list.end]);
        let ends = [list.start].into_iter().chain(items.iter().map(|item| item.end));
        let gaps: Vec<&str> = ends.zip(starts).map(|(end, start)| &name.text[end..start]).collect();
        let blank = |c: char| c.is_whitespace() || c == ',';
        if items.len() != codel.params.len() || !gaps.iter().all(|gap| gap.chars().all(blank)) {
            return None;
        }
        let separator = gaps.get(1).filter(|_| items.len() > 1).copied().unwrap_or(", ");
        let adapted = format!("{}{}", gaps[0], adapted?.join(separator));
        let list = list.start..items.last().map_or(list.end, |item| item.end);
        if name.text[list.clone()] == adapted {
            return None;
        }
        let mut edit = Edit::default();
        edit.replace(&name.path, list, adapted);
        Some(edit)
    }

    fn owner_of(&self, function: &Function, path: &Utf8Path) -> Option<Owner> {
        let component = self.expected.component();
        let task = |name: &str| {
            let found = component.tasks.position(|task| task.name == name)?;
            Some(Owner::Task(found))
        };
        if let Some(comment) =
            function.comments.iter().find_map(|comment| comment.generated.as_ref())
        {
            if comment.owner_kind == "task" {
                return task(&comment.owner);
            }
            let found = component.services.position(|service| service.name == comment.owner)?;
            return Some(Owner::Service(found));
        }
        let stem = path.file_stem()?.strip_prefix(component.name.as_str())?;
        task(stem.strip_prefix('_')?.strip_suffix("_codels")?)
    }

    /// The most likely parameter in the specification for a function's parameter: `in x`, `port out p`, …
    fn parameter(&self, parameter: &Parameter, owner: Owner) -> Option<String> {
        let spec = self.expected.spec;
        let component = self.expected.component();
        let name = parameter.name.as_deref()?;
        let base = parameter.ty.base.as_str();
        if let Some(port) =
            component.ports.iter().find(|port| self.expected.spelling(port.ty) == base)
        {
            let dir = port.dir.word();
            return Some(named(&format!("port {dir}"), &port.name, name));
        }
        if let Some(remote) =
            component.remotes.iter().find(|remote| self.expected.spelling(remote.ty) == base)
        {
            return Some(named("remote in", &remote.name, name));
        }
        let written = !parameter.ty.constant
            && matches!(
                parameter.ty.layers.first(),
                Some(Layer::Pointer { .. } | Layer::Reference { .. } | Layer::Array { .. })
            );
        let dir = if written { "inout" } else { "in" };
        if let Owner::Service(service) = owner {
            let mut params = component.services[service].params.iter();
            if params.any(|param| param.name == name) {
                return Some(format!("{dir} {name}"));
            }
        }
        let ids = component.ids?;
        if self.expected.spelling(ids) == base {
            return Some(format!("ids {dir} ::{name}"));
        }
        let TypeKind::Struct { members } = &spec.ty(ids).kind else {
            return None;
        };
        let member = members.iter().find(|&&member| spec.ty(member).name.as_deref() == Some(name));
        member.map(|_| format!("ids {dir} {name}"))
    }
}

/// `port in p`, or `port in p::q` if the function uses another name.
fn named(kind: &str, name: &str, as_name: &str) -> String {
    if name == as_name { format!("{kind} {name}") } else { format!("{kind} {name}::{as_name}") }
}
