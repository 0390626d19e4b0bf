//! The plan of the runs that the options ask for.

use camino::Utf8PathBuf;
use dotgen_runtime::decide;
use dotgen_runtime::simulation::Plan;
use dotgen_runtime::weights::{BadLine, Weights};
use dotgen_timing::verify::Prepared;
use dotgen_views::verification::Problem;
use dotgen_views::verification::problem::weights;
use num_rational::Ratio;

use super::{Arguments, Clock, DurationsName, OnViolation};
use crate::outputs::PERFETTO;
use crate::{report, session};

impl Arguments {
    /// Reads the weights of yields, and names the lines that the system does not have.
    pub(super) fn read_weights(
        &self,
        prepared: &Prepared,
        problem: &Problem,
    ) -> anyhow::Result<Option<Weights>> {
        let named =
            || weights(&problem.scenario, &problem.path).map(|path| session::display(&path));
        let Some(path) = self.weights.clone().or_else(|| named().map(Utf8PathBuf::from)) else {
            return Ok(None);
        };
        let text = session::text(&path, 1)?;
        let at = |bad: &BadLine| format!("{path}:{}: {}", bad.line, bad.what);
        let (weights, unknown) = Weights::parse(&text, &prepared.built.system)
            .map_err(|bad| anyhow::anyhow!("{}", at(&bad)))?;
        for bad in &unknown {
            report::note(&format!("{} of these components: ignored", at(bad)));
        }
        Ok(Some(weights))
    }

    /// Returns the plan of the runs.
    pub(super) fn plan<'w>(&self, prepared: &Prepared, weights: Option<&'w Weights>) -> Plan<'w> {
        let ten_seconds = Ratio::from_integer(10);
        self.shard.plan(&Plan {
            until: match (self.until, self.clock) {
                (Some(ratio), _) => prepared.ticks(ratio),
                (None, Clock::Virtual) => prepared.ticks(ten_seconds),
                (None, Clock::Real) => u64::MAX,
            },
            runs: self.all_runs(),
            seed: self.seed,
            weights,
            durations: match self.durations {
                DurationsName::Worst => decide::Durations::Worst,
                DurationsName::Random => decide::Durations::Random,
                DurationsName::Best => decide::Durations::Best,
            },
            stop_at_violation: self.on_violation == OnViolation::Stop,
            record: (self.trace.as_ref()).is_some_and(|trace| trace.extension() != Some(PERFETTO)),
        })
    }
}
