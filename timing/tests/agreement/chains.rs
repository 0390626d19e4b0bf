//! Reaction and age of random chains: the explorer agrees with brute force.

use dotgen_timing::explore::{Bound, Span, Stop, explore_chain};
use dotgen_timing::system::chain::{Chain, ChainKind, DataPlace};
use dotgen_timing::system::{CodelId, TimedSystem};
use dotgen_timing::verify::Cancel;
use typed_index_collections::TiVec;

use crate::agreement::brute::{Brute, CAP};
use crate::agreement::systems::{self, Dice};
use crate::agreement::{all_agree, cases, first, limits};

/// Returns random data flow: the first place is the first datum, the second the last, others are between.
fn chain(system: &TimedSystem, dice: &mut Dice) -> Chain {
    let shared = 2 + dice.below(3) as usize;
    let locals = dice.below(2) as usize;
    let external = dice.in_ten(4);
    let places: Vec<DataPlace> =
        (0..shared).map(DataPlace::Shared).chain((0..locals).map(DataPlace::Local)).collect();
    let n = system.codels.len();
    let mut some = |share: u32, not: &[DataPlace]| -> TiVec<CodelId, Vec<DataPlace>> {
        let mut of_codel = || -> Vec<DataPlace> {
            let mut list = places.clone();
            list.retain(|place| dice.in_ten(share) && !not.contains(place));
            list
        };
        (0..n).map(|_| of_codel()).collect()
    };
    let reads = some(4, &[]);
    let writes = if external { some(4, &[DataPlace::Shared(0)]) } else { some(4, &[]) };
    Chain {
        kind: dice.pick(&[ChainKind::Reaction, ChainKind::Age]),
        shared,
        locals,
        reads,
        writes,
        carries: (0..n).map(|_| dice.in_ten(9)).collect(),
        first: 0,
        last: 1,
        external,
    }
}

/// Checks that the intervals of a late datum have no gaps, end with the run and exceed the limit by one unit.
fn adds_up(spans: &[Span], end: u64, limit: Option<u32>) -> Result<(), &'static str> {
    let spent: u64 = spans.iter().map(|span| span.until - span.from).sum();
    if spans.last().map(|span| span.until) != Some(end) {
        return Err("the intervals do not end with the run");
    }
    if spans.windows(2).any(|two| two[0].until != two[1].from) {
        return Err("the intervals have a gap");
    }
    match limit {
        Some(limit) if spent != u64::from(limit) + 1 => Err("the intervals do not add up"),
        _ => Ok(()),
    }
}

fn compare(seed: u64) -> Option<Result<(), String>> {
    let mut dice = Dice::new(seed);
    let (system, _) = systems::random(&mut dice);
    let chain = chain(&system, &mut dice);
    let brute = Brute { system: &system, within: &[], reach: &[] };
    let expected = brute.chain(&chain, 30_000)?;
    let limit = match (seed % 3, expected) {
        (0, Some(brute)) => Some(brute / 2),
        (1, Some(brute)) => Some(brute),
        _ => None,
    };
    let found = explore_chain(&system, &chain, limit, limits(seed), &Cancel::default());
    let failed = |why: String| Some(Err(format!("seed {seed}: {why}\n{chain:#?}\n{system:#?}")));
    let measured = found.within.first().and_then(Option::as_ref);
    let given_up = found.stopped.is_some_and(|stop| stop != Stop::Answered);
    let value = measured.map(|measurement| match measurement.bound {
        Bound::Unbounded => CAP,
        Bound::Finite(number) => number.min(CAP),
    });
    if value != expected || given_up {
        return failed(format!(
            "{:?}: brute {expected:?}, found {value:?}, stopped {:?}",
            chain.kind, found.stopped
        ));
    }
    let exceeded = measured.is_some_and(|measurement| measurement.excess.is_some());
    let unknown = limit >= Some(CAP);
    if !unknown && exceeded != limit.is_some_and(|limit| expected > Some(limit)) {
        return failed(format!("limit {limit:?}: exceeded {exceeded}, brute {expected:?}"));
    }
    if let Some(excess) = measured.and_then(|measurement| measurement.excess.as_ref())
        && let Err(why) = adds_up(&found.chain.late, excess.end, limit)
    {
        return failed(format!("{why}: {:?}", found.chain.late));
    }
    // Its runs are runs of the system.
    for excess in measured
        .iter()
        .flat_map(|measurement| std::iter::once(&measurement.longest).chain(&measurement.excess))
    {
        if let Err(why) = brute.replay(&excess.steps, excess.end) {
            return failed(format!("{why}: {excess:?}"));
        }
    }
    Some(Ok(()))
}

#[test]
fn explorer_agrees_on_chains() {
    all_agree(first(), cases(), 2, compare);
}
