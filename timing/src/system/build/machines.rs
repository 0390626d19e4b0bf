//! State machines, and codels in their places of use.

use dotgen_analysis::model::{
    self, Codel as ModelCodel, CodelKind, CodelRef, Owner, Seconds, ServiceId,
};

use super::Builder;
use super::times::TimeOf;
use crate::diagnostic::remark::Remark;
use crate::system::{
    Codel, CodelId, CodelName, CodelSet, ComponentId, FOREVER, Machine, MachineId, State, Yield,
};

impl Builder<'_> {
    /// Adds the state machine of a task or activity; returns `None` if it has no `start` codel.
    pub(super) fn machine(
        &mut self,
        c: usize,
        number: ComponentId,
        owner: Owner,
        path: &str,
    ) -> Option<MachineId> {
        let component = self.names.components[c].component;
        let codels = component.codels_of(owner);
        let mut names: Vec<(String, model::CodelId)> = Vec::new();
        for (index, codel) in codels.iter_enumerated() {
            if codel.kind == CodelKind::Fsm {
                names
                    .extend(codel.triggers.iter().map(|trigger| (trigger.name.to_string(), index)));
            }
        }
        let find = |name: &str| names.iter().position(|(text, _)| text == name);
        let start = find("start")?;
        let stop = find("stop");
        let states = names
            .iter()
            .map(|(name, index)| {
                let codel = &codels[*index];
                let mut yields: Vec<Yield> = Vec::new();
                for state in &codel.yields {
                    let to = match find(&state.name) {
                        Some(to) if state.paused => Yield::Pause(to),
                        // A codel attached to `ether` runs once, before the end.
                        Some(to) if state.name != "ether" || name != "ether" => Yield::Next(to),
                        _ => Yield::End,
                    };
                    if !yields.contains(&to) {
                        yields.push(to);
                    }
                }
                if yields.is_empty() {
                    yields.push(Yield::End);
                }
                let codel_id = self.codel(c, number, owner, *index, name, codel);
                // In the published models, an exception is an ordinary end.
                if !self.settings.semantics().fixed().throws
                    && self.out.system.codels[codel_id].throws
                    && !yields.contains(&Yield::End)
                {
                    yields.push(Yield::End);
                }
                State { name: name.clone(), codel: codel_id, yields, is_async: codel.is_async }
            })
            .collect();
        let id = self.out.system.machines.next_key();
        let (loop_limit, rule) = self.loop_limit(c, owner);
        self.loop_rules.extend(rule.map(|rule| (id, rule)));
        self.out.machines.insert((c, owner), id);
        self.out.system.machines.push(Machine {
            name: path.to_owned(),
            states,
            start,
            stop,
            loop_limit,
            rounds: false,
        });
        Some(id)
    }

    pub(super) fn codel(
        &mut self,
        c: usize,
        number: ComponentId,
        owner: Owner,
        index: model::CodelId,
        state: &str,
        codel: &ModelCodel,
    ) -> CodelId {
        let name = if state.is_empty() { codel.name.as_str() } else { state };
        let component = self.names.components[c].component;
        let path = CodelName::new(&component.name, component.owner_name(owner), name);
        let given = self
            .durations
            .get(&(c, owner, Some(index), state.to_owned()))
            .map(|&duration| self.settings.duration[duration].0.range());
        let of_file = self.given_by(c, codel).filter(|_| codel.wcet.is_none() && given.is_none());
        if let Some((_, file)) = of_file {
            *self.timed_by.entry(file).or_default() += 1;
        }
        let untimed = codel.wcet.is_none() && given.is_none() && of_file.is_none();
        if untimed {
            let remark = Remark::NoWcet { codel: codel.name.to_string(), path: path.to_string() };
            let place = self.place(c, codel.src, "no `wcet`");
            self.report(remark.warning(0..0, vec![place]));
        }
        let time_of = TimeOf {
            what: path.to_string(),
            range: given.unwrap_or_default(),
            place: self.place(c, codel.src, "this codel"),
        };
        let site = Some((c, CodelRef { owner, index }));
        self.note_rounding((c, owner, Some(index), state), Some(codel), &path);
        let times = self.duration(c, owner, Some(index), state, Some(codel));
        let throws = codel.kind != CodelKind::Validate && self.may_throw(c, owner);
        let id = self.push_codel(number, path, times, site, &time_of);
        self.untimed.extend(untimed.then_some(id));
        self.out.system.codels[id].throws = throws;
        id
    }

    pub(super) fn attribute(
        &mut self,
        c: usize,
        number: ComponentId,
        s: ServiceId,
        path: &str,
    ) -> CodelId {
        let service = &self.names.components[c].component.services[s];
        self.note_rounding((c, Owner::Service(s), None, ""), None, path);
        let times = self.duration(c, Owner::Service(s), None, "", None);
        let given = self
            .durations
            .get(&(c, Owner::Service(s), None, String::new()))
            .map(|&duration| self.settings.duration[duration].0.range());
        let time_of = TimeOf {
            what: path.to_owned(),
            range: given.unwrap_or_default(),
            place: self.place(c, service.src, "this attribute"),
        };
        let path = CodelName::of_service(&self.names.components[c].component.name, &service.name);
        self.push_codel(number, path, times, None, &time_of)
    }

    fn push_codel(
        &mut self,
        number: ComponentId,
        path: CodelName,
        (lower, upper): (Seconds, Option<Seconds>),
        site: Option<(usize, CodelRef)>,
        time_of: &TimeOf,
    ) -> CodelId {
        let lower = self.ticks(lower, time_of);
        let upper = upper.map_or(FOREVER, |ratio| self.ticks(ratio, time_of));
        self.out.system.codels.push_and_get_key(Codel {
            path,
            component: number,
            lower,
            upper,
            conflicts: CodelSet::default(),
            throws: false,
            site,
            src: Some(time_of.place.src),
        })
    }
}
