//! Requests that every component accepts (section 18).

use super::Interpreter;
use super::model::{Aborted, Builtin};
use super::state::{Control, Instance, Kill, Phase, Request, State, Status};

impl Interpreter<'_> {
    /// Performs such a request, after its last codel. Returns true if the request succeeded.
    pub(super) fn builtin(&self, s: &mut State, c: usize, request: Request, it: Builtin) -> bool {
        match it {
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
                let last = all.find(|it| match aborted {
                    Some(Aborted::Last(c, service)) => (it.0, it.1) == (*c, *service),
                    Some(Aborted::Labelled(label)) => {
                        client.nodes[it.2].label.as_ref() == Some(label)
                    }
                    None => false,
                });
                let Some((task, slot)) = last.and_then(|it| it.3) else {
                    return false;
                };
                if let Some(it) = &mut s.components[c].tasks[task].slots[slot] {
                    let begins = matches!(it.status, Status::Asked | Status::Init(_));
                    it.mark |= begins || it.status == Status::Run;
                }
                true
            }
        }
    }

    /// Returns true if the shutdown of a component can proceed.
    pub(super) fn dies(&self, s: &State, c: usize) -> bool {
        let it = &s.components[c];
        match it.kill {
            Kill::No | Kill::Over => false,
            Kill::Activities(t) => {
                let all = it.tasks[t].slots.iter().flatten();
                let mut all = all.filter(|it| it.service.is_some());
                let mut waits = false;
                let marks = all.any(|it| match it.status {
                    Status::Asked | Status::Init(_) | Status::Run => {
                        waits = true;
                        !it.mark
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
                let mut slots = it.tasks[t].slots.iter();
                slots.any(|it| it.as_ref().is_none_or(|it| it.service.is_none()))
            }
            Kill::Stopping(t) => {
                let mut slots = it.tasks[t].slots.iter().flatten();
                let permanent = slots.find(|it| it.service.is_none());
                permanent.is_none_or(|it| matches!(it.status, Status::Ended(_)))
            }
            Kill::Task(t) => it.tasks[t].phase == Phase::Idle && !it.tasks[t].wake,
            Kill::Control => it.control == Control::Ready,
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
                for it in all.filter(|it| it.service.is_some() && !it.mark) {
                    if matches!(it.status, Status::Asked | Status::Init(_) | Status::Run) {
                        it.mark = true;
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
                let of = |it: &Option<Instance>| it.as_ref().is_some_and(|it| it.service.is_none());
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
                    Some(it) if it.status == Status::Stop => {}
                    Some(it) if !matches!(it.status, Status::Ended(_)) => {
                        it.mark = true;
                        self.set_runnable(s, c, t);
                    }
                    it => {
                        *it = Some(again);
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
