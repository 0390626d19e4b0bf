//! The passage of time.

use dotgen_timing::system::{AutomatonId, ClientId, ComponentId, FOREVER};

use super::state::{Doing, State, Status};
use super::{Brute, CAP};

impl Brute<'_> {
    /// Lets one unit of time pass.
    pub(super) fn pass(&self, s: &State) -> State {
        let mut n = s.clone();
        for task in &mut n.tasks {
            task.timer = task.timer.map(|timer| timer + 1);
            if task.status != Status::Idle {
                task.age = (task.age + 1).min(CAP);
            }
        }
        for e in 0..self.executors(s) {
            if let Doing::Executing(elapsed) = self.doing(s, e) {
                let (a, b) = self.bounds(s, e);
                let elapsed = if b == FOREVER { (elapsed + 1).min(a) } else { elapsed + 1 };
                let (na, nc) = (n.automata.len(), n.controls.len());
                if e < na {
                    n.automata[AutomatonId::from(e)].doing = Doing::Executing(elapsed);
                } else if e < na + nc {
                    n.controls[ComponentId::from(e - na)].doing = Doing::Executing(elapsed);
                } else {
                    n.clients[ClientId::from(e - na - nc)].clock = elapsed;
                }
            }
        }
        for obligation in &mut n.obligations {
            let older = |(stage, age)| (stage, u32::min(age + 1, CAP));
            *obligation = std::mem::take(obligation).into_iter().map(older).collect();
        }
        n
    }

    /// Returns true if no event can follow a state in which time passes.
    pub(super) fn dead(&self, s: &State) -> bool {
        s.tasks.iter().all(|task| task.timer.is_none())
            && (0..self.executors(s)).all(|e| !matches!(self.doing(s, e), Doing::Executing(_)))
    }
}
