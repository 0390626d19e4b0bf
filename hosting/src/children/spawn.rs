//! Starts the processes of hosts.

use std::io::BufReader;
use std::path::PathBuf;
use std::time::Duration;

use dotgen_codegen::process::{Channels, Processes as _, Program, Resources};
use dotgen_platform::process::System;
use dotgen_timing::system::ComponentId;
use rustix::fs::OFlags;

use super::inbox::EngineEvent;
use super::{Children, HostedComponent, HostedTask};
use crate::executing::Executing;
use crate::host::{COMMAND, HostOptions, HostThread};
use crate::realtime;
use crate::wire::HostMessage;

/// Time between the last `stop` codel of a host without an engine and the end of the process.
const END_MARGIN: Duration = Duration::from_secs(1);

impl Children {
    /// Starts the host of a component, if it has a shared object.
    ///
    /// # Errors
    ///
    /// A message that names the component.
    pub(super) fn spawn(&mut self, component: ComponentId) -> Result<(), String> {
        let Some(library) = self.children[component].library.clone() else {
            return Ok(());
        };
        let HostedComponent { name, priority } = &self.components[component];
        let tasks = (0..).zip(&self.tasks);
        let tasks = tasks.filter(|(_, task)| task.component == component);
        let thread =
            |task: &HostedTask| HostThread { name: task.name.clone(), priority: task.priority };
        let wrong = |error: std::io::Error| format!("cannot start a host for `{name}`: {error}");
        let executing = Executing::new(self.tasks.len()).map_err(wrong)?;
        let manner = HostOptions {
            component: name.clone(),
            executing: executing.path(),
            lanes: self.tasks.len(),
            tasks: tasks.map(|(lane, task)| (lane, thread(task))).collect(),
            control_priority: *priority,
            real_time: self.real,
            raised: self.raised,
            debug: self.debug.is_some(),
            // Under a debugger, or without a clock, the engine may stand still for any time.
            engine_within: if self.real && self.debug.is_none() {
                self.engine_within
            } else {
                Duration::ZERO
            },
            stop_within: self.stop_within,
        };
        let manner = serde_json::to_string(&manner).map_err(|error| wrong(error.into()))?;
        let program = Program {
            path: own(),
            arguments: vec![COMMAND.into(), manner.into(), library.as_std_path().into()],
            directory: PathBuf::new(),
            channels: Channels::PipesBut,
            resources: Resources::default(),
            access: None,
            outlives: self.stop_within + END_MARGIN,
        };
        let mut process = System.start(&program).map_err(wrong)?;
        let output = process.child.stdout.take();
        let output = output.ok_or_else(|| format!("the host of `{name}` has no output"))?;
        // The engine never waits for a host that does not read.
        if let Some(input) = &process.child.stdin {
            let flags = rustix::fs::fcntl_getfl(input).map_err(|error| wrong(error.into()))?;
            rustix::fs::fcntl_setfl(input, flags | OFlags::NONBLOCK)
                .map_err(|error| wrong(error.into()))?;
        }
        let (sender, started, raised) = (self.sender.clone(), self.started, self.raised);
        std::thread::spawn(move || {
            if raised {
                realtime::raise_priority(realtime::ENGINE_PRIORITY);
            }
            let mut output = BufReader::new(output);
            while let Ok(Some(reply)) = HostMessage::receive(&mut output) {
                if sender.send(EngineEvent::HostMessage(component, started, reply)).is_err() {
                    return;
                }
            }
            let _ = sender.send(EngineEvent::Closed(component, started));
        });
        let child = &mut self.children[component];
        child.process = Some(process);
        child.executing = Some(executing);
        child.exited = None;
        Ok(())
    }
}

/// The path by which this program can be started again.
fn own() -> PathBuf {
    let own = PathBuf::from("/proc/self/exe");
    if own.exists() { own } else { std::env::current_exe().unwrap_or(own) }
}
