//! Implicit facts as hints in the text: types from other declarations, implicit ends of machines, sums of
//! execution times, loads, defaults.

use std::ops::Range;

use dotgen_syntax::{
    SyntaxKind, TextSize,
    ast::{self, HasBody},
};
use rustc_hash::FxHashSet;

use super::{FileView, render};
use crate::{
    elab::DefKind,
    model::{
        CodelKind, Component, ComponentId, ComponentKind, Owner, Param, Seconds, ServiceKind, Src,
        TypeKind, fsm::Machine, turn::Turn,
    },
    quantity,
    source_map::{bytes, offset},
};

/// The types to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum InlayTypes {
    /// None.
    Off,
    /// Types of names that another component or interface declares.
    #[default]
    Inherited,
    /// Types of all parameters that name data.
    All,
}

/// The hints to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct InlayConfig {
    /// Types of parameters.
    pub types: InlayTypes,
    /// `stop → ether` where a machine has no codel for `stop`.
    pub implicit_ether: bool,
    /// Longest time from a state to the next pause.
    pub wcet: bool,
    /// Share of its period that a task uses.
    pub utilisation: bool,
    /// Default values of properties that are not given.
    pub defaults: bool,
}

impl Default for InlayConfig {
    fn default() -> InlayConfig {
        InlayConfig {
            types: InlayTypes::default(),
            implicit_ether: true,
            wcet: true,
            utilisation: true,
            defaults: true,
        }
    }
}

/// The kind of a hint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum InlayKind {
    Type,
    ImplicitEther,
    Wcet,
    Utilisation,
    Default,
}

/// A text shown inside the text of the author.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InlayHint {
    /// Byte offset.
    pub at: usize,
    /// The text.
    pub label: String,
    pub kind: InlayKind,
    /// An explanation, in Markdown.
    pub tooltip: String,
}

/// The hints that touch a range, by place.
pub(crate) fn inlay_hints(
    view: &FileView<'_>,
    range: &Range<usize>,
    config: &InlayConfig,
) -> Vec<InlayHint> {
    let mut hints = Hints { view, range, out: Vec::new() };
    let elaborated = view.elaborated();
    for (number, component) in elaborated.spec.components.iter_enumerated() {
        if config.types != InlayTypes::Off {
            hints.types(number, component, config.types == InlayTypes::All);
        }
        if component.kind == ComponentKind::Component {
            if config.defaults {
                hints.defaults(component);
            }
            for owner in component.owners() {
                hints.machine(component, owner, config);
            }
            if config.utilisation {
                hints.utilisation(component);
            }
        }
    }
    let mut out = hints.out;
    out.sort_by_key(|hint| (hint.at, hint.kind));
    let mut seen = FxHashSet::default();
    out.retain(|hint| seen.insert((hint.at, hint.kind)));
    out
}

struct Hints<'a, 'db> {
    view: &'a FileView<'db>,
    range: &'a Range<usize>,
    out: Vec<InlayHint>,
}

impl Hints<'_, '_> {
    /// The place of an item, if it is in this file and in the range.
    fn place(&self, src: Src) -> Option<Range<usize>> {
        let (file, range) = self.view.place(src)?;
        let range = bytes(range);
        let touches = range.start <= self.range.end && self.range.start <= range.end;
        (file == self.view.file && touches).then_some(range)
    }

    /// The place of a hint about a declaration: after the codel with its `;`, or after the `{` of a task or
    /// component. Hints there do not stand between the parts of a declaration.
    fn after_declaration(&self, at: usize) -> usize {
        let token = self.view.root().token_at_offset(offset(at)).right_biased();
        let nodes = token.into_iter().flat_map(|token| token.parent_ancestors());
        let mut ends = nodes.filter_map(|node| match node.kind() {
            SyntaxKind::CODEL_PROPERTY => Some(node.text_range().end()),
            SyntaxKind::BODY => Some(node.text_range().start() + TextSize::of('{')),
            SyntaxKind::TASK | SyntaxKind::COMPONENT => {
                let body = node.children().find(|child| child.kind() == SyntaxKind::BODY)?;
                Some(body.text_range().start() + TextSize::of('{'))
            }
            _ => None,
        });
        ends.next().map_or(at, usize::from)
    }

    /// Adds a hint at its place, if that is in the range.
    fn push(&mut self, at: usize, kind: InlayKind, label: String, tooltip: String) {
        if self.range.start <= at && at <= self.range.end {
            self.out.push(InlayHint { at, label, kind, tooltip });
        }
    }

    fn types(&mut self, number: ComponentId, component: &Component, all: bool) {
        let services = component.services.iter();
        let attributes = services.filter(|service| service.kind == ServiceKind::Attribute);
        let mut params: Vec<&Param> = attributes.flat_map(|attribute| &attribute.params).collect();
        for codel in component.all_codels() {
            params.extend(&component.codel(codel).params);
        }
        let inherited = if all { Vec::new() } else { self.inherited(number, component) };
        for param in params {
            let Some(place) = self.place(param.src) else {
                continue;
            };
            let within = |index: &usize| place.start <= *index && *index < place.end;
            if all || inherited.iter().any(within) {
                let spec = &self.view.elaborated().spec;
                let ty = render::type_text(spec, param.ty);
                let tooltip = match render::resolved_type_text(spec, param.ty) {
                    Some(resolved) if resolved != ty => format!("`{resolved}`"),
                    _ => String::new(),
                };
                if !matches!(spec.ty(param.ty).kind, TypeKind::Unknown) {
                    self.push(place.end, InlayKind::Type, format!(" ‹{ty}›"), tooltip);
                }
            }
        }
    }

    /// Mentions in a component of data that another declaration contains.
    fn inherited(&self, number: ComponentId, component: &Component) -> Vec<usize> {
        let elaborated = self.view.elaborated();
        let references = elaborated.references.iter();
        let foreign = references.filter(|reference| {
            let target = elaborated.definition(reference.target);
            let mut around = elaborated.containers(target);
            let home =
                around.find(|def| matches!(def.kind, DefKind::Component | DefKind::Interface));
            reference.component == Some(number)
                && matches!(
                    target.kind,
                    DefKind::IdsMember | DefKind::Port | DefKind::Parameter | DefKind::Local
                )
                && home.is_some_and(|home| home.name != component.name)
        });
        foreign.filter_map(|reference| Some(self.place(reference.at)?.start)).collect()
    }

    /// Implicit properties of a component.
    fn defaults(&mut self, component: &Component) {
        let Some(place) = self.place(component.src) else {
            return;
        };
        let given = |word: &str| self.has_property(component, word);
        let mut all = Vec::new();
        if let Some(rate) = &component.clock_rate
            && rate.src == component.src
        {
            all.push(format!("clock rate {}", quantity::time(rate.value)));
        }
        for (word, name, value, default) in [
            ("lang", "language", &component.lang, "c"),
            ("version", "version", &component.version, "0"),
        ] {
            if value.as_deref() == Some(default) && !given(word) {
                all.push(format!("{name} {default}"));
            }
        }
        if !all.is_empty() {
            let tooltip = "Values of properties that are not given.".to_owned();
            let at = self.after_declaration(place.start);
            self.push(at, InlayKind::Default, format!(" ‹default: {}›", all.join(", ")), tooltip);
        }
    }

    /// Returns true if a component of this file has a property.
    fn has_property(&self, component: &Component, word: &str) -> bool {
        let items = self.view.parse().tree().items();
        let components = items.filter_map(|item| match item {
            ast::Item::Component(component) => Some(component),
            _ => None,
        });
        let map = self.view.map();
        let named = components
            .filter(|other| other.name().is_some_and(|name| name.text(map) == component.name));
        let mut properties = named
            .flat_map(|component| component.items().collect::<Vec<_>>())
            .filter_map(|component| match component {
                ast::Item::Property(property) => property.keyword_token(),
                _ => None,
            });
        properties.any(|property| map.text(&property) == word)
    }

    fn machine(&mut self, component: &Component, owner: Owner, config: &InlayConfig) {
        let machine = Machine::new(component.codels_of(owner));
        if machine.is_empty() {
            return;
        }
        if config.implicit_ether
            && machine.codel("stop").is_none()
            && let Some((_, last)) = machine.codels.last()
            && let Some(end) = last.yields.last().and_then(|state| self.place(state.src))
        {
            let at = self.after_declaration(end.start);
            self.push(
                at,
                InlayKind::ImplicitEther,
                " ‹stop → ether›".to_owned(),
                "When interrupted, this machine ends at once: it has no codel for `stop`."
                    .to_owned(),
            );
        }
        if !config.wcet || !machine.codels.iter().any(|codel| codel.1.wcet.is_some()) {
            return;
        }
        for state in machine.turn_starts() {
            let Some((_, codel)) = machine.codel(state) else {
                continue;
            };
            let trigger = codel.triggers.iter().find(|trigger| trigger.name == state);
            let Some(place) = trigger.and_then(|trigger| self.place(trigger.src)) else {
                continue;
            };
            // An endless turn is a diagnostic.
            let Some(Turn::Bounded { sum, chain, incomplete }) = machine.longest_turn(state) else {
                continue;
            };
            // The same number as its own `wcet`, or no number at all.
            let is_own = chain.len() == 1 && codel.wcet.is_some();
            if is_own || sum == Seconds::from_integer(0) {
                continue;
            }
            let steps: Vec<&str> =
                chain.iter().map(|&chain| machine.at(chain).name.as_str()).collect();
            let mut tooltip = format!("Longest way to the next pause: {}.", steps.join(" → "));
            let bound = if incomplete {
                tooltip += " Some codel on the way has no `wcet` and counts as zero.";
                "≥"
            } else {
                "≤"
            };
            let label = format!(" ‹until pause {bound} {}›", quantity::time(sum));
            let at = self.after_declaration(place.start);
            self.push(at, InlayKind::Wcet, label, tooltip);
        }
    }

    fn utilisation(&mut self, component: &Component) {
        for (index, task) in component.tasks.iter_enumerated() {
            let Some(share) = component
                .utilisation(index)
                .filter(|utilisation| *utilisation > Seconds::from_integer(0))
            else {
                continue;
            };
            let Some(place) = self.place(task.src) else {
                continue;
            };
            let mut tooltip = "Longest turn of the permanent activity, by the period.".to_owned();
            for service in component.services.iter().filter(|service| service.task == Some(index)) {
                let machine = Machine::new(&service.codels);
                let turns = machine.turn_starts().into_iter();
                let longest = turns.filter_map(|turn| match machine.longest_turn(turn)? {
                    Turn::Bounded { sum, .. } => Some(sum),
                    Turn::Unbounded { .. } => None,
                });
                if let Some(longest) = longest.max().filter(|turn| *turn > Seconds::from_integer(0))
                {
                    tooltip += &format!(
                        "\n- activity `{}` adds at most {} a turn",
                        service.name,
                        quantity::time(longest)
                    );
                }
            }
            let at = self.after_declaration(place.start);
            self.push(
                at,
                InlayKind::Utilisation,
                format!(" ‹load {}›", quantity::load(share)),
                tooltip,
            );
        }
    }
}

/// Returns true if a codel is part of a machine.
pub(crate) fn is_machine(component: &Component, owner: Owner) -> bool {
    let codels = component.codels_of(owner);
    codels.iter().any(|codel| codel.kind == CodelKind::Fsm)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::Fixture;

    /// The text with the hints in brackets.
    fn shown(text: &str, config: InlayConfig) -> String {
        let fixture = Fixture::new(text);
        let path = camino::Utf8Path::new("/main.gen");
        let mut out = fixture.text("/main.gen");
        let hints = fixture.analysis().inlay_hints(path, 0..out.len(), &config).unwrap();
        for hint in hints.iter().rev() {
            out.insert_str(hint.at, &format!("[{}]", hint.label));
        }
        out
    }

    const NONE: InlayConfig = InlayConfig {
        types: InlayTypes::Off,
        implicit_ether: false,
        wcet: false,
        utilisation: false,
        defaults: false,
    };

    const TEXT: &str = "struct s { double x; };
interface i { port in s p; };
component c {
  provides i;
  ids { s v; };
  task t {
    period 10 ms;
    codel<start> f(port in p, ids in v.x) wcet 1 ms yield pause::go;
    codel<go> g(out ::ids) wcet 4 ms yield more, ether;
    codel<more> h() wcet 500 us yield pause::go;
  };
};
";

    #[test]
    fn each_kind_can_be_switched() {
        assert_eq!(shown(TEXT, NONE), TEXT);
        let types = shown(TEXT, InlayConfig { types: InlayTypes::Inherited, ..NONE });
        assert!(types.contains("f(port in p[ ‹s›], ids in v.x)"), "{types}");
        let types = shown(TEXT, InlayConfig { types: InlayTypes::All, ..NONE });
        assert!(types.contains("f(port in p[ ‹s›], ids in v.x[ ‹double›])"), "{types}");
        let wcet = shown(TEXT, InlayConfig { wcet: true, ..NONE });
        // A chain of one codel takes the time in its `wcet`.
        assert!(wcet.contains("codel<start>"), "{wcet}");
        assert!(wcet.contains("yield more, ether;[ ‹until pause ≤ 4.5 ms›]\n"), "{wcet}");
        let load = shown(TEXT, InlayConfig { utilisation: true, ..NONE });
        assert!(load.contains("task t {[ ‹load 45 %›]"), "{load}");
        let ether = shown(TEXT, InlayConfig { implicit_ether: true, ..NONE });
        assert!(ether.contains("yield pause::go;[ ‹stop → ether›]\n  };"), "{ether}");
        let defaults = shown(TEXT, InlayConfig { defaults: true, ..NONE });
        assert!(
            defaults.contains("component c {[ ‹default: clock rate 10 ms, language c, version 0›]"),
            "{defaults}"
        );
    }

    #[test]
    fn only_the_range_asked_for() {
        let fixture = Fixture::new(TEXT);
        let path = camino::Utf8Path::new("/main.gen");
        let all = InlayConfig::default();
        assert_eq!(fixture.analysis().inlay_hints(path, 0..10, &all).unwrap(), []);
    }

    #[test]
    fn a_machine_that_ends_on_stop_has_no_hint() {
        let text = "component c { task t { codel<start> f() yield ether; codel<stop> g() yield ether; }; };\n";
        assert_eq!(shown(text, InlayConfig { implicit_ether: true, ..NONE }), text);
    }

    #[test]
    fn an_endless_turn_has_no_hint() {
        let text = "component c { task t { codel<start> f() wcet 1 ms yield start, ether; }; };\n";
        let found = shown(text, InlayConfig { wcet: true, ..NONE });
        assert_eq!(found, text);
    }
}
