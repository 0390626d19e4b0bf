//! Variations of a problem: other cores, another policy, other durations of single codels.

use std::collections::BTreeMap;

use dotgen_timing::advice::Change;
use dotgen_timing::scn::ast::{Durations, Interval, Item, Path, Policy, Spanned, Unit};
use dotgen_timing::verify::Options;
use serde::{Deserialize, Serialize};

use super::Problem;

/// The changes of a variation; the default has none.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "camelCase", default)]
pub struct WhatIf {
    /// Number of cores, or `"free"`.
    pub cores: Option<CoreCount>,
    /// `fifo`, `edf` or `any`.
    pub policy: Option<String>,
    /// `interval`, `fixed` or `open`.
    pub durations: Option<String>,
    /// Longest execution times in microseconds, by codel (`component.owner.state`).
    pub wcet: BTreeMap<String, f64>,
}

/// The number of cores.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CoreCount {
    Number(u32),
    /// `"free"`: as many cores as tasks.
    Word(String),
}

impl WhatIf {
    /// Returns the variation with a change; `None` if a variation cannot say it.
    pub fn of(change: &Change) -> Option<WhatIf> {
        let mut out = WhatIf::default();
        match change {
            Change::Wcet { codel, seconds, .. } => {
                let micros = seconds * num_rational::Ratio::from_integer(1_000_000);
                let micros = *micros.numer() as f64 / *micros.denom() as f64;
                out.wcet.insert(codel.to_string(), micros);
            }
            Change::Cores { needed, .. } => out.cores = Some(CoreCount::Number(*needed)),
            Change::Policy { needed, .. } => out.policy = Some(needed.name().to_owned()),
            Change::Period { .. } | Change::Delay { .. } | Change::Lock { .. } => return None,
        }
        Some(out)
    }

    /// True if there are no changes.
    pub fn is_nothing(&self) -> bool {
        *self == WhatIf::default()
    }

    /// The options for the verifier. The error names an impossible change.
    pub fn options(&self, options: Options) -> Result<Options, String> {
        let cores = match &self.cores {
            None => options.cores,
            Some(CoreCount::Number(0)) => return Err("a system needs at least one core".to_owned()),
            Some(CoreCount::Number(n)) => Some(Some(*n)),
            Some(CoreCount::Word(word)) if word == "free" => Some(None),
            Some(CoreCount::Word(word)) => {
                return Err(format!("`{word}` is no number of cores; write one, or `free`"));
            }
        };
        let modes = [Durations::Interval, Durations::Fixed, Durations::Open];
        Ok(Options {
            cores,
            policy: choose(self.policy.as_deref(), Policy::ALL)?.or(options.policy),
            durations: choose(self.durations.as_deref(), &modes.map(|mode| (mode.name(), mode)))?
                .or(options.durations),
            ..options
        })
    }

    /// The problem with other durations, as if the scenario had `duration` items.
    pub fn apply(&self, problem: &Problem) -> Result<Problem, String> {
        let mut out = problem.clone();
        for (codel, &micros) in &self.wcet {
            if !(micros.is_finite() && (0.0..=1e9).contains(&micros)) {
                return Err(format!("`{codel}` cannot take {micros} µs"));
            }
            let upper = micros.ceil() as u64;
            // A lower bound in the scenario remains, but at most the new upper bound.
            let mut lower = 0;
            out.scenario.items.retain(|item| match item {
                Item::Duration(path, interval, unit) if path.text() == *codel => {
                    let seconds = unit.seconds() * num_rational::Ratio::from_integer(1_000_000);
                    lower = (seconds
                        * num_rational::Ratio::from_integer(i128::from(interval.lower)))
                    .to_integer() as u64;
                    false
                }
                _ => true,
            });
            let name = |text: &str| Spanned { value: text.to_owned(), range: 0..0 };
            let path = Path { names: codel.split('.').map(name).collect() };
            let interval = Interval { lower: lower.min(upper), upper: Some(upper) };
            out.scenario.items.push(Item::Duration(path, interval, Unit::Microseconds));
        }
        Ok(out)
    }
}

fn choose<T: Copy>(word: Option<&str>, of: &[(&str, T)]) -> Result<Option<T>, String> {
    let Some(word) = word else { return Ok(None) };
    if let Some(pair) = of.iter().find(|entry| entry.0 == word) {
        Ok(Some(pair.1))
    } else {
        let words: Vec<&str> = of.iter().map(|(name, _)| *name).collect();
        Err(format!("`{word}` is none of {}", words.join(", ")))
    }
}
