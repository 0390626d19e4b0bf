//! The execution of one system: on the virtual or the real clock, with or without its codels.

use std::io::{self, Write};

use camino::Utf8PathBuf;
use dotgen_analysis::model::PortDir;
use dotgen_recording::log::origins;
use dotgen_runtime::checker::RunChecker;
use dotgen_runtime::parts::simulate_in_parts;
use dotgen_runtime::port_writes::Port;
use dotgen_runtime::profile::{Profile, functions};
use dotgen_runtime::report::{RunReport, Violated, violation};
use dotgen_runtime::simulation::{Record, SimulationResult, ViolationReceiver, simulate_recorded};
use dotgen_timing::report::Event;
use dotgen_timing::scn::names::Names;
use dotgen_timing::system::{CodelId, ComponentId, Ticks, TimedSystem};
use dotgen_timing::verify::{Cancel, Interrupt, Options, Prepared, SystemInput};
use typed_index_collections::TiVec;

use super::bounds::{self, BoundVerification};
use super::record::Recording;
use super::recorder::{Files, Recorder, Runs};
use super::{Arguments, Clock, Simulate, text};
use crate::progress;
use crate::report;
use crate::session::Session;
use crate::verify::title;
use dotgen_platform::files::disk::AppendedFile;
use dotgen_views::verification::Problem;

/// The input of a run.
pub(super) struct Context<'c, 's> {
    pub(super) session: &'c Session,
    pub(super) problem: &'c Problem,
    pub(super) names: &'c Names<'s>,
    pub(super) options: &'c Options,
    /// Bounds on response times, in units of the system.
    pub(super) bounds: Vec<Option<Ticks>>,
    /// The verification that proves more bounds during the run.
    pub(super) proving: Option<&'c BoundVerification>,
    /// True if codels are executed on the real clock.
    pub(super) measured: bool,
    pub(super) interrupt: &'c Interrupt,
}

/// The results of a run.
pub(super) struct Run {
    pub(super) report: RunReport,
    /// Number of executed and of simulated codels.
    pub(super) executed: (usize, usize),
    /// Number of lines of the profile, or the first error of a write.
    pub(super) lines: io::Result<u64>,
    /// The recording, if one was requested.
    pub(super) messages: anyhow::Result<Option<RecordingResult>>,
    /// The events of the first run, if a trace was requested.
    pub(super) told: Option<RunEvents>,
}

/// A recording that has ended.
pub(super) struct RecordingResult {
    /// Number of messages of ports.
    pub(super) data: u64,
    pub(super) steps: u64,
    /// True if all of it was written. Otherwise the reason was reported.
    pub(super) whole: bool,
}

pub(super) struct RunEvents {
    pub(super) events: Vec<Event>,
    /// True if only the beginning is present.
    pub(super) left_out: bool,
}

/// The default of `--engine-within`.
const ENGINE_WITHIN: std::time::Duration = std::time::Duration::from_secs(1);

/// The default of `--host-within`.
const HOST_WITHIN: std::time::Duration = std::time::Duration::from_secs(2);

/// A note for a run that ended before the verification of its response times.
const NOT_PROVED: &str = "verification of response times cancelled: the run ended first; bounds are those \
     known before the run; `dotgen verify` may prove lower ones";

impl Context<'_, '_> {
    /// Runs the system, and proves bounds meanwhile. The end of the run cancels the verification.
    pub(super) fn run_while_proving(
        &self,
        arguments: &Arguments,
        prepared: Prepared,
        files: &mut Files<'_>,
    ) -> anyhow::Result<Option<Run>> {
        let cancel = Cancel::interrupted_by(self.interrupt);
        std::thread::scope(|scope| {
            if let Some(proving) = self.proving {
                proving.reset();
                let (problem, options, cancel) = (self.problem, self.options, &cancel);
                scope.spawn(move || {
                    #[cfg(unix)]
                    dotgen_hosting::realtime::lower_priority();
                    proving.prove(problem, options, bounds::STATES, cancel);
                });
            }
            let run = self.run(arguments, prepared, files);
            cancel.abandon();
            run
        })
    }

    /// Returns the text of the progress line.
    fn doing(&self) -> String {
        format!("running {} on the virtual clock", self.problem.scenario.name)
    }

    /// Returns the bounds that are known at the end of a run, and a note if some may be missing.
    fn final_bounds(&self, prepared: &Prepared) -> (Vec<Option<Ticks>>, Option<String>) {
        let mut bounds = self.bounds.clone();
        let proved = self.proving.is_none_or(|verification| verification.add_to(&mut bounds));
        bounds::without_times(&prepared.built.system, &mut bounds, self.measured);
        (bounds, (!proved).then(|| NOT_PROVED.to_owned()))
    }

    /// Runs the system. Returns `None` if it cannot run, which was reported, or was interrupted before the
    /// run.
    fn run(
        &self,
        arguments: &Arguments,
        prepared: Prepared,
        files: &mut Files<'_>,
    ) -> anyhow::Result<Option<Run>> {
        let real = arguments.clock == Clock::Real;
        if arguments.simulate == Simulate::All && !real {
            return self.simulated(arguments, &prepared, files).map(Some);
        }
        #[cfg(unix)]
        return self.executed(arguments, &prepared, files);
        #[cfg(not(unix))]
        anyhow::bail!("codels are executed on Unix systems only; use `--simulate all`");
    }

    fn simulated(
        &self,
        arguments: &Arguments,
        prepared: &Prepared,
        files: &mut Files<'_>,
    ) -> anyhow::Result<Run> {
        let weights = arguments.read_weights(prepared, self.problem)?;
        let plan = arguments.plan(prepared, weights.as_ref());
        let system = &prepared.built.system;
        let mut profile = self.profile(prepared, files.runs.as_mut(), None, None)?;
        let interrupted = || self.interrupt.is_raised();
        let bounds = self.bounds.clone();
        let mut recording = self.recording(files.recording.take(), prepared, false, &|_| false)?;
        // Files are written in the order of the runs, and a violation may end them.
        let in_parts = profile.is_none() && recording.is_none() && !plan.stop_at_violation;
        let mut parts = progress::during(None, &self.doing(), |_| {
            if in_parts {
                return simulate_in_parts(prepared, &bounds, &plan, &interrupted);
            }
            let result = simulate_recorded(
                prepared,
                bounds,
                &plan,
                profile.as_mut(),
                recording.as_mut().map(|recording| recording as &mut dyn Record),
                None,
                &interrupted,
            );
            vec![(plan, result)]
        });
        let (bounds, note) = self.final_bounds(prepared);
        let reports = parts.iter_mut().map(|(plan, result)| {
            result.judge.bound_late(&bounds);
            RunReport::new(prepared, plan, result, &bounds, &|_| false)
        });
        let mut report = RunReport::merge(reports.collect()).map_err(anyhow::Error::msg)?;
        report.notes.extend(note);
        Ok(Run {
            lines: lines(profile),
            messages: messages(recording),
            executed: (0, system.codels.len()),
            told: parts.first().and_then(|(_, first)| self.told(prepared, first)),
            report,
        })
    }

    /// Returns the writer of executions of codels, if one was requested. `measured`: the codels that are
    /// executed on the real clock.
    fn profile<'r, 'a>(
        &self,
        prepared: &'r Prepared,
        mut recorder: Option<&'r mut Recorder<'a>>,
        server: Option<&dotgen_hosting::server::Server>,
        measured: Option<&dyn Fn(CodelId) -> bool>,
    ) -> anyhow::Result<Option<Profile<'r, Runs<'r, 'a>>>> {
        if recorder.is_none() && server.is_none() {
            return Ok(None);
        }
        let system = &prepared.built.system;
        let codels = system.codels.iter_enumerated();
        let simulated = codels.filter(|(number, codel)| {
            codel.site.is_some() && measured.is_some_and(|is_executed| !is_executed(*number))
        });
        let simulated = simulated.map(|(_, codel)| &*codel.path);
        let origins = origins(measured.is_some(), simulated);
        if let Some(recorder) = &mut recorder {
            recorder.say(&origins)?;
        }
        let followers = server.map(|server| Box::new(server.followers(&origins)) as Box<dyn Write>);
        let runs = Runs { recorder, followers };
        let functions = functions(system, self.names);
        Ok(Some(Profile::new(system, functions, runs)))
    }

    /// Returns the recording, if one was requested.
    fn recording<'r>(
        &'r self,
        file: Option<AppendedFile>,
        prepared: &'r Prepared,
        real: bool,
        executed: &dyn Fn(CodelId) -> bool,
    ) -> anyhow::Result<Option<Recording<'r, 'r>>> {
        let Some(file) = file else {
            return Ok(None);
        };
        let scenario = title(self.problem);
        Recording::new(file, prepared, self.names, scenario, real, executed).map(Some)
    }

    fn told(&self, prepared: &Prepared, outcome: &SimulationResult<'_>) -> Option<RunEvents> {
        let run = outcome.recorded.as_ref()?;
        let input = SystemInput { specs: self.problem.specs() };
        Some(RunEvents { events: prepared.told(&input, run), left_out: run.left_out })
    }

    /// Output ports with their names, in order of these: `component/port`.
    #[cfg(unix)]
    fn ports(&self, prepared: &Prepared) -> Vec<(Port, String)> {
        let components = prepared.built.components.iter().flat_map(|(&name, &at)| {
            let component = self.names.components[name].component;
            let ports = component.ports.iter_enumerated();
            let ports = ports.filter(|(_, port)| port.dir == PortDir::Out);
            ports.map(move |(number, port)| {
                ((at, number), format!("{}/{}", component.name, port.name))
            })
        });
        let mut out: Vec<_> = components.collect();
        out.sort_by(|one, other| one.1.cmp(&other.1));
        out
    }

    /// Builds the executed components. Returns `None` if that fails, which is printed, or is interrupted.
    #[cfg(unix)]
    fn hosted(&self, arguments: &Arguments) -> anyhow::Result<Option<super::hosted::Hosted<'_>>> {
        use super::hosted;

        match arguments.simulate {
            Simulate::All => Ok(Some(hosted::Hosted::none(self.names))),
            Simulate::Missing => hosted::build(
                self.session,
                self.problem,
                self.names,
                arguments.debug,
                self.interrupt,
            ),
        }
    }

    /// Returns the hosts of the executed components.
    #[cfg(unix)]
    fn children(
        &self,
        arguments: &Arguments,
        libraries: TiVec<ComponentId, Option<Utf8PathBuf>>,
        system: &TimedSystem,
        real: bool,
    ) -> dotgen_hosting::children::Children {
        use dotgen_hosting::children::{Children, HostedComponent, HostedTask};

        let priorities = dotgen_hosting::realtime::priorities(&system.priorities());
        let (of_tasks, of_controls) = priorities.split_at(system.tasks.len());
        let components = system.components.iter().zip(of_controls);
        let components = components.map(|(component, &priority)| HostedComponent {
            name: component.name.clone(),
            priority,
        });
        let tasks = system.tasks.iter().zip(of_tasks);
        let tasks = tasks.map(|(task, &priority)| HostedTask {
            component: task.component,
            name: task.name.clone(),
            priority,
        });
        let (components, tasks) = (components.collect(), tasks.collect());
        let interrupt = (self.interrupt.clone(), arguments.stop_within);
        let mut children = Children::new(libraries, components, tasks, real, interrupt);
        children.watch_engine_within(arguments.engine_within.unwrap_or(ENGINE_WITHIN));
        if arguments.debug {
            children.debug(arguments.waiting());
        }
        children
    }

    #[cfg(unix)]
    fn executed(
        &self,
        arguments: &Arguments,
        prepared: &Prepared,
        files: &mut Files<'_>,
    ) -> anyhow::Result<Option<Run>> {
        use super::hosted;
        use dotgen_hosting::orphans::OrphanReaper;
        use dotgen_hosting::server::Server;
        use dotgen_runtime::engine::End;
        use dotgen_runtime::live::Live;
        use dotgen_runtime::progress::ProgressReceiver;
        use dotgen_runtime::real_clock::Pace;
        use dotgen_runtime::simulation::Execution;
        use dotgen_timing::verify::settings;

        let real = arguments.clock == Clock::Real;
        let inputs = hosted::inputs(&arguments.inputs, self.names)?;
        let Some(hosted) = self.hosted(arguments)? else {
            return Ok(None);
        };
        if hosted.is_empty() && !real {
            return self.simulated(arguments, prepared, files).map(Some);
        }
        let settings = settings(&self.problem.scenario, self.options);
        let parts = hosted.parts(prepared, self.names, &settings, &inputs);
        // Without a scenario, requests come only from outside.
        let default = !self.problem.is_written();
        let (opened, factor, first) = hosted::opened(prepared, &parts, real, default);
        let parts = match first {
            Some(first) => parts.with_outside(first),
            None => parts,
        };
        let system = &opened.built.system;
        // Dropped after the hosts.
        let _reaper = OrphanReaper::become_subreaper();
        let libraries = hosted.libraries(prepared);
        let mut children = self.children(arguments, libraries, system, real);
        let mut notes = hosted.notes.clone();
        notes.extend(parts.unlike.iter().cloned());
        let pace = real.then(|| Pace { nanos: hosted::nanos(&opened) });
        if real {
            if real_time() {
                children.raise_priorities();
            } else {
                notes.push(format!(
                "the system does not grant the real-time priority {}: times depend on what else runs",
                dotgen_hosting::realtime::ENGINE_PRIORITY
            ));
            }
        }
        let serving = if real {
            Some(super::serve::start(
                arguments,
                #[cfg(feature = "zenoh")]
                self.session,
                self.problem,
                self.names,
                &opened,
                &parts,
                &mut children,
            )?)
        } else {
            None
        };
        let server = serving.as_ref().map(|start| &start.server);
        let weights = arguments.read_weights(&opened, self.problem)?;
        let plan = arguments.plan(&opened, weights.as_ref());
        let grown = |ticks: &Option<Ticks>| ticks.map(|tick| tick.saturating_mul(factor));
        let bounds: Vec<_> = self.bounds.iter().map(grown).collect();
        let is_executed = |codel: CodelId| parts.codel(codel).is_some();
        let mut progress_subscribers = server.map(Server::progress_subscribers);
        let mut profile = self.profile(
            &opened,
            files.runs.as_mut(),
            server,
            real.then_some(&is_executed as &dyn Fn(CodelId) -> bool),
        )?;
        let watchdog = super::systemd::Watchdog::new();
        let interrupted = || {
            watchdog.report();
            self.interrupt.is_raised()
        };
        let stops_activities = arguments.on_violation == super::OnViolation::StopActivity;
        let mut live = Live::new(system, &parts, &mut children, !real, stops_activities);
        let violation_subscribers = server.map(Server::violation_subscribers);
        let violated = |judge: &RunChecker<'_>, number: usize, more: u64| {
            let violation = violation(&opened, &plan, judge, number);
            let unit = opened.report.unit;
            let what = match &violation.what {
                Violated::Check { check } => text::check_title(&opened.checks[*check].report),
                other => text::violated(other, unit),
            };
            if let Some(subscribers) = &violation_subscribers {
                subscribers.receive(number, &violation, unit, &what);
            }
            report::note(&match (violation.times == more, more) {
                (true, _) => format!("at {}: violated {what}", unit.show_value(violation.at.time)),
                (false, 1) => format!("again: violated {what}"),
                (false, _) => format!("again, {more} times: violated {what}"),
            });
        };
        live.set_stop_within(arguments.stop_within);
        live.set_host_within(arguments.host_within.unwrap_or(HOST_WITHIN));
        let execution = Execution {
            live: &mut live,
            pace,
            follow: progress_subscribers
                .as_mut()
                .map(|subscriber| subscriber as &mut dyn ProgressReceiver),
            violated: real.then_some(&violated as &ViolationReceiver<'_>),
        };
        let mut recording = self.recording(files.recording.take(), &opened, real, &is_executed)?;
        let run = || {
            simulate_recorded(
                &opened,
                bounds,
                &plan,
                profile.as_mut(),
                recording.as_mut().map(|recording| recording as &mut dyn Record),
                Some(execution),
                &interrupted,
            )
        };
        // Codels that are executed may print meanwhile.
        let mut outcome = run();
        if outcome.end == End::NotStarted && self.interrupt.is_raised() {
            return Ok(None);
        }
        if outcome.end == End::NotStarted {
            let why = live.fault().unwrap_or("a component could not be started");
            anyhow::bail!("{why}");
        }
        let (bounds, note) = self.final_bounds(prepared);
        let bounds: Vec<_> = bounds.iter().map(grown).collect();
        outcome.judge.bound_late(&bounds);
        let mut report = RunReport::new(&opened, &plan, &outcome, &bounds, &is_executed);
        // Without a scenario, the client of the model sends any request.
        if let Some(first) = first.filter(|_| !default) {
            report.count_outside_model(&outcome.tally, first);
        }
        notes.extend(note);
        let ports = self.ports(&opened).into_iter().filter(|((at, _), _)| parts.of(*at).is_some());
        report.count_writes(&opened, &outcome, ports);
        let told = self.told(&opened, &outcome);
        let (lines, messages) = (lines(profile), messages(recording));
        drop(outcome);
        let denied = children.denied().iter();
        notes.extend(denied.map(|text| format!("the system does not grant {text}")));
        report.notes.extend(notes);
        Ok(Some(Run { lines, messages, executed: parts.counts(system), told, report }))
    }
}

/// Gives the engine its real-time priority and locked memory; hosts report what they lack. Returns false if
/// the system does not grant the priority.
#[cfg(unix)]
fn real_time() -> bool {
    use dotgen_hosting::realtime;

    realtime::lock_memory(realtime::Pages::Present);
    realtime::raise_priority(realtime::ENGINE_PRIORITY)
}

/// Ends a recording.
fn messages(recording: Option<Recording<'_, '_>>) -> anyhow::Result<Option<RecordingResult>> {
    let Some(recording) = recording else {
        return Ok(None);
    };
    let (data, steps) = (recording.data, recording.steps);
    let whole = recording.finish()?;
    Ok(Some(RecordingResult { data, steps, whole }))
}

fn lines(profile: Option<Profile<'_, Runs<'_, '_>>>) -> io::Result<u64> {
    profile.map_or(Ok(0), |profile| profile.finish().map(|(_, lines)| lines))
}
