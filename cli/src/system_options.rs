//! Options that replace settings of a scenario.

use clap::{Args, ValueEnum};
use dotgen_timing::scn::ast::{Durations, Policy};
use dotgen_timing::scn::semantics::Preset;
use dotgen_timing::verify::Options;

/// The platform and the semantics of a system.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct SystemOptions {
    /// Number of cores, or `free` for one core per task
    #[arg(long, value_name = "N|free", value_parser = cores)]
    cores: Option<Cores>,

    /// Semantics of the model
    #[arg(long, value_enum)]
    semantics: Option<SemanticsName>,

    /// Order in which tasks get a core
    #[arg(long, value_enum)]
    policy: Option<PolicyName>,
}

impl SystemOptions {
    /// The options of a verification with these settings.
    pub(super) fn options(self) -> Options {
        Options {
            cores: self.cores.map(|core| core.0),
            policy: self.policy.map(PolicyName::policy),
            semantics: self.semantics.map(SemanticsName::preset),
            ..Options::default()
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Cores(Option<u32>);

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SemanticsName {
    /// The servers that GenoM3 generates
    Servers,
    /// The published formal models
    Published,
}

impl SemanticsName {
    fn preset(self) -> Preset {
        match self {
            SemanticsName::Servers => Preset::Servers,
            SemanticsName::Published => Preset::Published,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum PolicyName {
    /// First come, first served
    Fifo,
    /// Earliest deadline first
    Edf,
    /// Any ready task, without preemption
    Any,
    /// The ready tasks of highest priority, with preemption
    Priority,
    /// Any ready tasks, with preemption
    Fair,
}

impl PolicyName {
    fn policy(self) -> Policy {
        match self {
            PolicyName::Fifo => Policy::Fifo,
            PolicyName::Edf => Policy::Edf,
            PolicyName::Any => Policy::Any,
            PolicyName::Priority => Policy::Priority,
            PolicyName::Fair => Policy::Fair,
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum DurationsName {
    /// From 0, or the minimum in the scenario, to the WCET
    Interval,
    /// Always the WCET
    Fixed,
    /// Greater than 0, up to the WCET
    Open,
}

impl DurationsName {
    pub(super) fn durations(self) -> Durations {
        match self {
            DurationsName::Interval => Durations::Interval,
            DurationsName::Fixed => Durations::Fixed,
            DurationsName::Open => Durations::Open,
        }
    }
}

fn cores(text: &str) -> Result<Cores, String> {
    match text.parse::<u32>() {
        _ if text == "free" => Ok(Cores(None)),
        Ok(0) => Err("a system needs at least one core".to_owned()),
        Ok(n) => Ok(Cores(Some(n))),
        Err(_) => Err("give a number of cores, or `free`".to_owned()),
    }
}
