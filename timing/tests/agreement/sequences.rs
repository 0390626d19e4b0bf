//! Sequences of responses: agreement of the explorer with brute force, which follows every obligation
//! separately.

use dotgen_timing::explore::{Watched, Within};
use dotgen_timing::property::Predicate;

use crate::agreement::systems::{self, Dice};
use crate::agreement::{all_agree, cases, compare_system, first, measured, walks};

fn responses(system: &dotgen_timing::system::TimedSystem, dice: &mut Dice) -> Vec<Predicate> {
    let more = 1 + dice.below(2);
    (0..more).map(|_| systems::predicate(system, dice)).collect()
}

#[test]
fn explorer_agrees_on_sequences() {
    all_agree(first(), cases() / 4, 3, |seed| {
        let mut dice = Dice::new(seed);
        let (system, within) = systems::random(&mut dice);
        let (trigger, response) = match within.into_iter().next() {
            Some(pair) => pair,
            None => {
                (systems::predicate(&system, &mut dice), systems::predicate(&system, &mut dice))
            }
        };
        let mut list = vec![response];
        list.extend(responses(&system, &mut dice));
        let within = [Within { trigger, responses: list, limit: None }];
        let measured = measured(seed, &system);
        compare_system(seed, &system, &within, &measured, 1)
    });
}

#[test]
fn a_walk_sees_when_sequences_are_answered() {
    all_agree(first(), cases() / 4, 1, |seed| {
        let mut dice = Dice::new(seed);
        let (system, within) = systems::random(&mut dice);
        let within: Vec<_> = (within.into_iter())
            .map(|(p, q)| {
                let mut list = vec![q];
                list.extend(responses(&system, &mut dice));
                (p, list)
            })
            .collect();
        let watched = Watched { within, ..Watched::default() };
        Some(walks::agrees(seed, &system, &watched, &mut dice))
    });
}
