//! The token of a chain: its place in a state, and what the bits there mean.

use crate::explore::state::State;
use crate::scn::ast::ChainKind;
use crate::system::chain::{Chain, DataPlace};
use crate::system::{CodelId, FOREVER, Ticks, TimedSystem};

/// Returns the greatest age, in base units, up to which invisible ages are counted. Greater ages would be
/// unbounded, or nearly so.
pub(in crate::explore) fn greatest_age(system: &TimedSystem) -> Ticks {
    let periods = system.tasks.iter().filter_map(|task| task.period);
    let uppers = (system.codels.iter())
        .map(|codel| if codel.upper == FOREVER { codel.lower } else { codel.upper });
    let sum = periods.chain(uppers).fold(16, Ticks::saturating_add);
    sum.saturating_mul(32)
}

/// The status of the token.
pub(super) mod status {
    /// No datum is marked yet.
    pub(in crate::explore) const IDLE: u16 = 0;
    /// The last write can be marked.
    pub(in crate::explore) const OFFERED: u16 = 1;
    /// Some datum is marked.
    pub(in crate::explore) const ALIVE: u16 = 2;
    /// The measurement has ended, or no marked datum is left.
    pub(in crate::explore) const OVER: u16 = 3;
}

/// Bits of a number of the discrete part.
pub(super) const BITS: usize = u16::BITS as usize;

/// The token of a chain.
#[derive(Debug)]
pub(crate) struct Token<'c> {
    pub(in crate::explore) chain: &'c Chain,
    /// Place of the token in the discrete part.
    pub(super) place: usize,
    /// Number of executors.
    pub(in crate::explore) executors: usize,
    pub(super) cap: Ticks,
}

impl Token<'_> {
    pub(in crate::explore) fn status(&self, s: &State) -> u16 {
        s.d[self.place]
    }

    /// Returns the place of a bit: executors that began in this step, executors with marked data, places with
    /// marked data.
    pub(in crate::explore) fn fresh(&self, executor: usize) -> (usize, u16) {
        self.bit(0, executor)
    }

    pub(in crate::explore) fn marked_executor(&self, executor: usize) -> (usize, u16) {
        self.bit(self.executors.div_ceil(BITS), executor)
    }

    pub(in crate::explore) fn marked_place(&self, place: DataPlace, holder: usize) -> (usize, u16) {
        let number = match place {
            DataPlace::Shared(index) => index,
            DataPlace::Local(local) => self.chain.shared + holder * self.chain.locals + local,
        };
        self.bit(2 * self.executors.div_ceil(BITS), number)
    }

    pub(in crate::explore) fn bit(&self, words: usize, number: usize) -> (usize, u16) {
        (self.place + 1 + words + number / BITS, 1 << (number % BITS))
    }

    pub(in crate::explore) fn reads_first(&self, codel: CodelId) -> bool {
        self.chain.reads[codel].contains(&DataPlace::Shared(self.chain.first))
    }

    pub(in crate::explore) fn offers_any_time(&self) -> bool {
        self.chain.external && self.chain.kind == ChainKind::Reaction
    }

    /// Performs the writes of a codel that ends. Returns true if the first datum is written.
    pub(in crate::explore) fn write(
        &self,
        s: &mut State,
        executor: usize,
        codel: CodelId,
        holder: usize,
    ) -> bool {
        let chain = self.chain;
        let marked = is_set(s, self.marked_executor(executor));
        set(s, self.marked_executor(executor), false);
        for &place in &chain.writes[codel] {
            let bit = self.marked_place(place, holder);
            // A new first datum is another datum, whatever it is made of.
            let is_first = place == DataPlace::Shared(chain.first);
            match chain.kind {
                ChainKind::Reaction if marked && place == DataPlace::Shared(chain.last) => {
                    s.d[self.place] = status::OVER;
                }
                ChainKind::Reaction if marked => set(s, bit, true),
                ChainKind::Reaction => {}
                ChainKind::Age => set(s, bit, marked && !is_first),
            }
        }
        chain.writes[codel].contains(&DataPlace::Shared(chain.first))
    }

    /// Returns true if no further event is of interest.
    pub(in crate::explore) fn is_over(&self, s: &State) -> bool {
        self.status(s) == status::OVER
    }
}

pub(in crate::explore) fn is_set(s: &State, (word, bit): (usize, u16)) -> bool {
    s.d[word] & bit != 0
}

pub(super) fn set(s: &mut State, (word, bit): (usize, u16), value: bool) {
    if value { s.d[word] |= bit } else { s.d[word] &= !bit }
}
