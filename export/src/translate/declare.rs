//! The declarations of integers, clocks and channels, and the values of the integers at time 0.

use dotgen_timing::system::ClientStep;

use crate::model::{Clock, Network, Update, Variable};

use super::layout::{Kind, Layout, Part, TaskPart, position, status, step};

impl Layout<'_> {
    /// Declares all integers and clocks, except those of checks.
    pub(super) fn declare(&self, network: &mut Network) {
        let mut declare = |name: String, size: Option<usize>, most: usize, comment: &str| {
            let comment = comment.to_owned();
            network.variables.push(Variable { name, size, most: most as i64, comment });
        };
        for part in self.parts.iter().filter(|_| !self.jobs) {
            self.declare_part(part, &mut declare);
        }
        if self.cores().is_some() {
            let tasks = self.system.tasks.len();
            declare("cores_used".into(), None, tasks, "number of cores in use");
            if self.queues_for_cores() {
                let what = "tasks that wait for a core, in order (numbers from 1); 0: none";
                declare("core_queue".into(), Some(tasks + 1), tasks, what);
                declare("core_waiting".into(), None, tasks, "number of tasks that wait for a core");
            }
        }
        let places = if self.jobs {
            self.system.automata.len()
        } else {
            self.parts.iter().map(|part| part.size).sum()
        };
        for (id, client) in self.system.clients.iter_enumerated() {
            let name = self.client_name(id);
            let what = "step of the client";
            declare(format!("step_{name}"), None, client.done() + 1, what);
            declare(format!("asks_{name}"), None, 1, "1: its last request is not answered");
            for tracker in 0..client.trackers {
                let what = "activity that it follows: 0 none, 1 not accepted yet, 2 failed, else a place + 3";
                declare(format!("follows_{name}_{tracker}"), None, places + 3, what);
            }
        }
        let mut clock =
            |name: String, comment: String| network.clocks.push(Clock { name, comment });
        for part in self.parts.iter().filter(|_| !self.jobs) {
            for task in &part.tasks {
                if task.period.is_some() {
                    clock(task.timer(), format!("time since the last tick of {}", task.name));
                }
                clock(task.clock(), format!("time of the codel that {} executes", task.name));
            }
            if part.has_control_codels() {
                clock(part.clock(), format!("time of the codel that {} executes", part.name));
            }
        }
        for id in self.system.clients.keys() {
            let name = self.client_name(id);
            clock(format!("x_{name}"), format!("time of the delay of {name}"));
        }
        let mut channel = |name: String, comment: &str| {
            network.channels.push((name, comment.to_owned()));
        };
        channel("step".into(), "an action has happened");
        if !self.system.clients.is_empty() {
            channel("proceed".into(), "a client proceeds");
        }
        if self.cores().is_some() {
            channel("ask".into(), "a task asks for a core");
            channel("grant".into(), "a task gets a core");
        }
        for (id, client) in self.system.clients.iter_enumerated() {
            let mut seen = Vec::new();
            for service in client.steps.iter().filter_map(ClientStep::requests) {
                if !seen.contains(&service) {
                    seen.push(service);
                    channel(
                        self.request(id, service).to_owned(),
                        "the control task takes a request",
                    );
                }
            }
        }
    }

    fn declare_part(
        &self,
        part: &Part,
        declare: &mut impl FnMut(String, Option<usize>, usize, &str),
    ) {
        let name = &part.name;
        let size = Some(part.size);
        let kinds: Vec<String> =
            part.kinds.iter().map(|kind| format!("{} {}", kind.number, kind.name)).collect();
        let what = "status of the activity in each place: 0 none, 1 accepted, 2 runs, 3 stops, 4 has \
            ended, 5 end of the places of a task";
        declare(format!("status_{name}"), size, status::LAST, what);
        let what = format!("activity in each place: {}", kinds.join(", "));
        declare(format!("kind_{name}"), size, part.kinds.len(), &what);
        let states = |kind: &Kind| self.machine(kind).map_or(1, |machine| machine.states.len());
        let most = part.kinds.iter().map(states).max().unwrap_or(0).max(1);
        declare(format!("state_{name}"), size, most, "codel state of the activity in each place");
        declare(format!("paused_{name}"), size, 1, "1: the activity is paused");
        let what = "1: the activity has ended without exception";
        declare(format!("success_{name}"), size, 1, what);
        declare(format!("permanent_{name}"), size, 1, "1: the permanent activity");
        if part.activities {
            declare(format!("released_{name}"), size, 1, "1: the activity may begin");
            declare(format!("interrupted_{name}"), size, 1, "1: interrupted, not noticed yet");
        }
        if part.starts() {
            let most = part.tasks.len();
            declare(format!("starting_{name}"), None, most, "task that is being started, from 0");
        }
        if part.queue {
            let most = part.tasks.len() + 1;
            let what = "executors in the lock queue, in order: tasks from 1, then the control task";
            declare(format!("queue_{name}"), Some(most + 1), most, what);
            declare(format!("queued_{name}"), None, most, "length of the lock queue");
        }
        for task in &part.tasks {
            self.declare_task(part, task, declare);
        }
        if !part.control {
            return;
        }
        let what = "step of the control task: 0 not started, 1 ready, 2 codels, 3 replies";
        declare(format!("control_{name}"), None, 3, what);
        declare(format!("ended_{name}"), None, 1, "1: an activity has ended, not handled yet");
        declare(
            format!("place_{name}"),
            None,
            part.size,
            "place given to the request + 1; 0: none",
        );
        declare(format!("refused_{name}"), None, 1, "1: the request is refused");
        declare(format!("at_{name}"), None, part.size, "place that the control task examines");
        declare(format!("other_{name}"), None, part.size, "place that may be interrupted");
        declare(format!("held_{name}"), None, 1, "1: something interrupted still runs");
        let clients = self.system.clients.len();
        declare(format!("sender_{name}"), None, clients, "client of the request, from 1");
        if part.has_control_codels() {
            let codels = self.system.codels.len();
            declare(format!("wants_{name}"), None, codels, "codel of the control task, from 1");
            declare(format!("codel_{name}"), None, codels, "codel that it executes; 0: none");
        }
        for &(service, _) in &part.services {
            if self.notes_success(service) {
                let what = "1: the service has succeeded";
                declare(format!("succeeded_{}", self.service_name(service)), None, 1, what);
            }
        }
    }

    fn declare_task(
        &self,
        part: &Part,
        task: &TaskPart,
        declare: &mut impl FnMut(String, Option<usize>, usize, &str),
    ) {
        let name = &task.name;
        let codels = self.system.codels.len();
        let what = "position: 0 not started, 1 between cycles, 2 waits for a core, 3 in a cycle";
        declare(format!("position_{name}"), None, 3, what);
        let what = match task.period {
            Some(_) => "1: a tick has come since the last cycle began",
            None => "1: paused activities must be resumed",
        };
        declare(format!("due_{name}"), None, 1, what);
        declare(format!("place_{name}"), None, part.size, "place of the pass");
        declare(format!("resumes_{name}"), None, 1, "1: the pass resumes paused activities");
        declare(format!("first_{name}"), None, 1, "1: the first cycle is not over");
        declare(format!("goes_on_{name}"), None, 1, "1: another pass follows");
        declare(format!("event_{name}"), None, 1, "1: there was an event in the pass");
        if part.control {
            declare(format!("ends_{name}"), None, 1, "1: an activity has ended in the pass");
        }
        if task.wakes {
            declare(format!("wakes_{name}"), None, 1, "1: the other tasks must be woken");
        }
        if task.needs_core {
            declare(format!("core_{name}"), None, 1, "1: the task holds a core");
        }
        declare(format!("wants_{name}"), None, codels, "codel of the turn, from 1; 0: none");
        declare(format!("codel_{name}"), None, codels, "codel that the task executes; 0: none");
    }

    /// Returns the updates that lead to the state at time 0.
    pub(super) fn beginning(&self) -> Vec<Update> {
        let mut out = Vec::new();
        for part in self.parts.iter().filter(|_| !self.jobs) {
            for task in &part.tasks {
                let kind =
                    part.kinds.iter().find(|kind| kind.service.is_none() && kind.task == task.id);
                out.push(part.status(task.base).set(status::ACCEPTED));
                out.push(part.kind(task.base).set(kind.map_or(0, |kind| kind.number)));
                out.push(part.permanent(task.base).set(1_usize));
                if part.activities {
                    out.push(part.released(task.base).set(1_usize));
                }
                out.push(part.status(task.base + task.count).set(status::LAST));
                out.push(task.first().set(1_usize));
                if task.period.is_none() {
                    out.push(task.due().set(1_usize));
                }
            }
            match part.tasks.first() {
                Some(first) => out.push(first.position().set(position::IDLE)),
                None if part.control => out.push(part.step().set(step::READY)),
                None => {}
            }
        }
        for (id, client) in self.system.clients.iter_enumerated() {
            out.push(self.client_step(id).set(client.done() + 1));
        }
        out
    }
}
