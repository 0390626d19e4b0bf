//! The work at the end of the input (language reference, sections 1 (item 4) and 8.1).

use crate::finding::role::Role;
use smol_str::SmolStr;
use std::sync::Arc;

use num_rational::Ratio;
use typed_index_collections::{TiSlice, TiVec};

use super::{Elaborated, context::Elaborator, property::to_f64};
use crate::finding::{Finding, names::NameProblem, values::ValueProblem};
use crate::model::{
    ComponentId, ComponentKind, Gap, Missing, Quantity, Seconds, Spec, Src, TypeId, TypeKind,
    VisitId, visit::TypeIds,
};
use crate::release::Change;
use crate::unit::is_standin;

impl Elaborator<'_> {
    /// Ends an elaboration: does all work that needs the complete input.
    pub(super) fn finish(mut self) -> Elaborated {
        self.settle();
        let order = std::mem::take(&mut self.type_order);
        let mut result = self.into_elaborated();
        order_types(&mut result, &order);
        result
    }

    /// Records the types and interfaces that stand-ins declare.
    fn note_stand_ins(&mut self) {
        let visits = self.visits;
        let is_standin: TiVec<VisitId, bool> =
            visits.iter().map(|visit| is_standin(visit.path.as_ref())).collect();
        if !is_standin.contains(&true) {
            return;
        }
        let invented = |at: Src| is_standin.get(at.visit) == Some(&true);
        let ids = self.spec.types.iter_enumerated();
        let open = ids.filter(|(_, ty)| ty.name.is_some() && invented(ty.src));
        self.spec.open = open.map(|(id, _)| id).collect();
        let components = self.spec.components.iter_enumerated();
        let stand_ins = components.filter(|(_, component)| invented(component.src));
        self.spec.stand_ins = stand_ins.map(|(index, _)| index).collect();
    }

    fn settle(&mut self) {
        self.note_stand_ins();
        self.check_forwards();
        self.apply_wcet_pragmas();
        for index in self.spec.components.keys() {
            if self.spec.components[index].kind == ComponentKind::Component {
                self.settle_clock_rate(index);
                if self.spec.components[index].lang.is_none()
                    && !self.spec.missing_interfaces(index).is_empty()
                {
                    self.spec.gaps.push(Gap { component: Some(index), missing: Missing::Language });
                }
                let component = &mut self.spec.components[index];
                component.lang.get_or_insert_with(|| "c".to_owned());
                component.version.get_or_insert_with(|| "0".to_owned());
                self.lint(index);
            } else if self.spec.release.has(Change::InterfaceDefaults) {
                let interface = &mut self.spec.components[index];
                interface.lang.get_or_insert_with(|| "c".to_owned());
                interface.version.get_or_insert_with(|| "0".to_owned());
            }
        }
        self.report_newer();
    }

    /// The lints of a component, as far as its declarations were resolved.
    fn lint(&mut self, c: ComponentId) {
        if !self.components[c].tasks.iter().any(|task| task.incomplete) {
            for lint in crate::check::lints(&self.spec.components[c]) {
                self.report(lint);
            }
        }
    }

    fn check_forwards(&mut self) {
        for forward in std::mem::take(&mut self.forwards) {
            let ty = self.spec.ty(forward.ty);
            let (keyword, undefined) = match ty.kind {
                TypeKind::ForwardStruct { definition } => ("struct", definition.is_none()),
                TypeKind::ForwardUnion { definition } => ("union", definition.is_none()),
                _ => continue,
            };
            if undefined && !forward.excused {
                let name = ty.name.clone().unwrap_or_default();

                let at = ty.src;
                self.error(at, NameProblem::NeverDefined { keyword, name });
            }
        }
    }

    fn apply_wcet_pragmas(&mut self) {
        for pragma in std::mem::take(&mut self.pragma_wcet) {
            let Some(def) = self.codel_def(&pragma.codel) else {
                let names = self.codels.keys().map(SmolStr::as_str);
                let near = self.near(pragma.name, &pragma.codel, names);

                self.unresolved(
                    pragma.at,
                    ValueProblem::PragmaUnknown { codel: pragma.codel.clone() },
                    near,
                );
                continue;
            };
            self.refer(pragma.name, def);
            let quantity = self.seconds(pragma.number, pragma.unit, pragma.at);
            let mut clause = None;
            for component in &mut self.spec.components {
                let tasks = component.tasks.iter_mut().map(|task| &mut task.codels);
                let services = component.services.iter_mut().map(|service| &mut service.codels);
                for codel in tasks.chain(services).flatten() {
                    if codel.name != pragma.codel {
                        continue;
                    }
                    match &codel.wcet {
                        Some(given) => clause = clause.or(Some(given.src)),
                        None => codel.wcet = Some(quantity.clone()),
                    }
                }
            }
            if let Some(clause) = clause {
                self.report(
                    Finding::new(
                        ValueProblem::PragmaAndClause { codel: pragma.codel.clone() },
                        pragma.at,
                    )
                    .related(clause, Role::Declaration),
                );
            }
        }
    }

    /// Compares a given clock-rate with the periods, or computes the default one.
    fn settle_clock_rate(&mut self, c: ComponentId) {
        let component = &self.spec.components[c];
        let Some(rate) = &component.clock_rate else {
            // A clock-rate that could not be evaluated is still given.
            if !self.components[c].given.contains_key("clock-rate") {
                self.default_clock_rate(c);
            }
            return;
        };
        let mut problems = Vec::new();
        for task in &component.tasks {
            let times = [("period", &task.period), ("delay", &task.delay)];
            for (word, time) in times {
                let Some(time) = time else { continue };
                if !is_multiple(time.value, rate.value) {
                    problems.push(
                        Finding::new(
                            ValueProblem::NoMultiple {
                                word,
                                task: task.name.clone(),
                                time: to_f64(time.value).to_string().into(),
                                rate: to_f64(rate.value).to_string().into(),
                            },
                            time.src,
                        )
                        .related(rate.src, Role::ClockRate),
                    );
                }
            }
        }
        for problem in problems {
            self.report(problem);
        }
    }

    fn default_clock_rate(&mut self, c: ComponentId) {
        let component = &self.spec.components[c];
        if component.tasks.iter().all(|task| task.period.is_none()) {
            return;
        }
        let times = component.tasks.iter().flat_map(|task| [&task.period, &task.delay]).flatten();
        let rate = times.fold(1_000_000, |rate, time| gcd(rate, microseconds(time)));
        let src = component.src;
        let rate = self.seconds(Ratio::new(rate, 1_000_000), None, src);
        self.spec.components[c].clock_rate = Some(rate);
    }
}

fn microseconds(time: &Quantity) -> i128 {
    (time.value * Ratio::from_integer(1_000_000)).round().to_integer()
}

/// The greatest common divisor; zero does not count.
fn gcd(mut a: i128, mut b: i128) -> i128 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Returns true if a time is a multiple of a clock-rate, to a millionth of a tick.
fn is_multiple(time: Seconds, rate: Seconds) -> bool {
    let zero = Ratio::from_integer(0);
    if rate == zero {
        return time == zero;
    }
    let ticks = time / rate;
    let off = ticks - ticks.round();
    let tolerance = Ratio::new(1, 1_000_000);
    off <= tolerance && -off <= tolerance
}

/// Puts the types in their order of creation.
///
/// Types are numbered in order of construction, so only the ids can be out of order: they move to the end
/// each time members are added.
fn order_types(result: &mut Elaborated, order: &TiSlice<TypeId, u32>) {
    if order.is_sorted() {
        return;
    }
    let mut by_order: Vec<TypeId> = order.keys().collect();
    by_order.sort_by_key(|ty| order[*ty]);
    let mut new_ids: TiVec<TypeId, TypeId> = order.keys().collect();
    for (new, old) in new_ids.keys().zip(&by_order) {
        new_ids[*old] = new;
    }
    let mut renumber = |id: &mut TypeId| {
        if let Some(new) = new_ids.get(*id) {
            *id = *new;
        }
    };
    let spec = Arc::make_mut(&mut result.spec);
    spec.for_each_type_id(&mut renumber);
    spec.open.sort_unstable();
    reorder(spec, &by_order);
    for definition in &mut result.definitions {
        definition.ty.iter_mut().for_each(&mut renumber);
    }
    for closing in &mut result.closings {
        if let Some(snapshot) = &mut closing.snapshot {
            snapshot.for_each_type_id(&mut renumber);
        }
    }
}

fn reorder(spec: &mut Spec, by_order: &[TypeId]) {
    let mut old: TiVec<TypeId, Option<_>> =
        std::mem::take(&mut spec.types).into_iter().map(Some).collect();
    spec.types = by_order.iter().filter_map(|id| old.get_mut(*id)?.take()).collect();
}
