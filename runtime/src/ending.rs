//! The orderly end of a run with executed codels: no new requests, then the shutdown of every component.
//! Activities are interrupted and execute their `stop` codels, then permanent activities do, and the port
//! data of these codels is published. Codels that have not ended within a bound are named.

use dotgen_timing::explore::Stepper;

use crate::end::End;
use crate::live::Live;
use crate::watch::RunObserver;

/// An end under way.
#[derive(Debug)]
pub(crate) struct Ending {
    reason: End,
    /// End of the bound, in nanoseconds on the clock of the hosts.
    until: u64,
    /// End of the bound in the model, in base units.
    until_in_model: u64,
    /// Components are being shut down.
    begun: bool,
}

impl Ending {
    /// Requests the end of a run: threads that execute cycles by themselves are recalled first.
    pub(crate) fn request(reason: End, stepper: &Stepper, live: &mut Live<'_>) -> Ending {
        live.begin_ending();
        let within = live.stop_within();
        let nanos = u64::try_from(within.as_nanos()).unwrap_or(u64::MAX);
        Ending {
            reason,
            until: live.hosts().now().saturating_add(nanos),
            until_in_model: stepper.now().saturating_add(live.base_units(within)),
            begun: false,
        }
    }

    /// Begins the shutdown if nothing is in its way. Returns the reason of the end once everything has ended,
    /// or when the bound is over.
    pub(crate) fn proceed(
        &mut self,
        stepper: &mut Stepper,
        watch: &mut dyn RunObserver,
        live: &mut Live<'_>,
    ) -> Option<End> {
        if !self.begun && !live.has_delegations() {
            watch.on_ending(stepper, self.reason);
            stepper.shut_down();
            self.begun = true;
        } else if self.begun && stepper.is_stuck() {
            watch.on_ending(stepper, self.reason);
            stepper.shut_down();
        }
        let ended = self.begun && live.has_ended(stepper);
        let over = live.hosts().now() >= self.until || stepper.now() >= self.until_in_model;
        let late = over || live.hosts().is_over();
        if late && !ended {
            live.note_unfinished(stepper);
        }
        (ended || late).then_some(self.reason)
    }

    /// The time that is left in the model, in base units.
    pub(crate) fn left(&self, stepper: &Stepper) -> u64 {
        self.until_in_model.saturating_sub(stepper.now())
    }
}
