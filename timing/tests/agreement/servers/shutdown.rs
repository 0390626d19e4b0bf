//! Requests that every component accepts (section 18).

use super::Interpreter;
use super::model::{Aborted, Builtin};
use super::state::{Control, Instance, Kill, Phase, Request, State, Status};

impl Interpreter<'_> {
    /// Performs such a request, after its last codel. Returns true if the request succeeded.
    pub(super) fn builtin(
        &self,
        s: &mut State,
        c: usize,
        request: Request,
        builtin: Builtin,
    ) -> bool {
        match builtin {
            Builtin::Connect => true,
            Builtin::Kill => {
                let kill = &mut s.components[c].kill;
                if *kill == Kill::No {
                    *kill = Kill::Activities(0);
                }
                true
            }
            Builtin::Abort => {
                let client = &self.system.clients[request.client];
                let aborted = client.nodes[request.node].aborts.as_ref();
                let mut all = s.clients[request.client].instances.iter().rev();
                let last = all.find(|instance| match aborted {
                    Some(Aborted::Last(c, service)) => (instance.0, instance.1) == (*c, *service),
                    Some(Aborted::Labelled(label)) => {
                        client.nodes[instance.2].label.as_ref() == Some(label)
                    }
                    None => false,
                });
                let Some((task, slot)) = last.and_then(|instance| instance.3) else {
                    return false;
                };
                if let Some(slot) = &mut s.components[c].tasks[task].slots[slot] {
                    let begins = matches!(slot.status, Status::Asked | Status::Init(_));
                    slot.mark |= begins || slot.status == Status::Run;
                }
                true
            }
        }
    }

    /// Returns true if the shutdown of a component can proceed.
    pub(super) fn dies(&self, s: &State, c: usize) -> bool {
        let component = &s.components[c];
        match component.kill {
            Kill::No | Kill::Over => false,
            Kill::Activities(t) => {
                let all = component.tasks[t].slots.iter().flatten();
                let mut all = all.filter(|slot| slot.service.is_some());
                let mut waits = false;
                let marks = all.any(|slot| match slot.status {
                    Status::Asked | Status::Init(_) | Status::Run => {
                        waits = true;
                        !slot.mark
                    }
                    Status::Stop => {
                        waits = true;
                        false
                    }
                    Status::Ended(_) => false,
                });
                marks || !waits
            }
            Kill::Permanent(t) => {
                let mut slots = component.tasks[t].slots.iter();
                slots.any(|slot| slot.as_ref().is_none_or(|instance| instance.service.is_none()))
            }
            Kill::Stopping(t) => {
                let mut slots = component.tasks[t].slots.iter().flatten();
                let permanent = slots.find(|slot| slot.service.is_none());
                permanent.is_none_or(|slot| matches!(slot.status, Status::Ended(_)))
            }
            Kill::Task(t) => component.tasks[t].phase == Phase::Idle && !component.tasks[t].wake,
            Kill::Control => component.control == Control::Ready,
        }
    }

    /// Performs one step of a shutdown.
    pub(super) fn die(&self, s: &mut State, c: usize) {
        let tasks = s.components[c].tasks.len();
        let next = match s.components[c].kill {
            Kill::No | Kill::Over => return,
            Kill::Activities(t) => {
                let mut marked = false;
                let all = s.components[c].tasks[t].slots.iter_mut().flatten();
                for slot in all.filter(|slot| slot.service.is_some() && !slot.mark) {
                    if matches!(slot.status, Status::Asked | Status::Init(_) | Status::Run) {
                        slot.mark = true;
                        marked = true;
                    }
                }
                if marked {
                    return self.set_runnable(s, c, t);
                }
                match t + 1 {
                    t if t < tasks => Kill::Activities(t),
                    _ => Kill::Permanent(tasks - 1),
                }
            }
            Kill::Permanent(t) => {
                let slots = &mut s.components[c].tasks[t].slots;
                let of = |instance: &Option<Instance>| {
                    instance.as_ref().is_some_and(|instance| instance.service.is_none())
                };
                let at = slots.iter().position(of);
                let at = at.or_else(|| slots.iter().position(Option::is_none));
                let Some(at) = at else { return };
                let again = Instance {
                    service: None,
                    status: Status::Init(false),
                    at: 0,
                    paused: false,
                    mark: true,
                };
                match &mut slots[at] {
                    Some(slot) if slot.status == Status::Stop => {}
                    Some(slot) if !matches!(slot.status, Status::Ended(_)) => {
                        slot.mark = true;
                        self.set_runnable(s, c, t);
                    }
                    slot => {
                        *slot = Some(again);
                        self.set_runnable(s, c, t);
                    }
                }
                Kill::Stopping(t)
            }
            Kill::Stopping(0) => Kill::Task(0),
            Kill::Stopping(t) => Kill::Permanent(t - 1),
            Kill::Task(t) => {
                let task = &mut s.components[c].tasks[t];
                (task.timer, task.flag, task.job) = (None, None, None);
                (task.runnable, task.gone) = (false, true);
                match t + 1 {
                    t if t < tasks => Kill::Task(t),
                    _ => Kill::Control,
                }
            }
            Kill::Control => {
                s.components[c].control = Control::Starting;
                Kill::Over
            }
        };
        s.components[c].kill = next;
    }
}
