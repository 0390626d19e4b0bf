//! Comparisons of data that codels write.

use dotgen_codegen::codels::value::Values;
use dotgen_timing::explore::{Action, Stepper};
use dotgen_timing::property::DataFact;

use super::Live;

impl<'p> Live<'p> {
    /// Sets the comparisons of port data in checks.
    pub(crate) fn compare(&mut self, facts: &'p [DataFact]) {
        self.facts = facts;
    }

    /// Returns true if a host executes the component whose data are compared.
    pub(crate) fn has_data(&self, fact: &DataFact) -> bool {
        self.parts.of(fact.component).is_some()
    }

    /// Evaluates the comparisons of the data that a codel has written, if an action ends the codel.
    pub(crate) fn set_facts(&self, action: Action, stepper: &mut Stepper) -> Option<()> {
        let Action::Finish { executor, .. } = action else { return None };
        if self.facts.is_empty() {
            return None;
        }
        let running = self.running.get(executor)?.as_ref()?;
        let component = self.system.codels[running.work.codel()?].component;
        let member = &self.parts.of(component)?.member;
        for write in &running.ran.as_ref()?.written {
            let ty = member.component.ports.get(write.port).map(|port| port.data);
            let (Some(ty), Some(data)) = (ty, &write.data) else { continue };
            let facts = self.facts.iter().enumerate();
            let of_port = |fact: &DataFact| (fact.component, fact.port) == (component, write.port);
            for (number, fact) in facts.filter(|(_, fact)| of_port(fact)) {
                if let Ok(value) = Values::new(member.spec).decode(ty, data) {
                    stepper.set_fact(number, fact.holds(&value));
                }
            }
        }
        Some(())
    }
}
