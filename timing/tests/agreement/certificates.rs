//! Agreement of certificates with their checker, with random runs, and with an enumeration of states.

mod enumeration;
mod follow;
mod mutate;

use std::sync::atomic::{AtomicUsize, Ordering};

use dotgen_check::{Outcome, check};
use dotgen_timing::invariants::certificate::{
    Certificate, FORMAT, ScenarioCertificate, SystemCertificate,
};
use dotgen_timing::property::Predicate;
use dotgen_timing::system::TimedSystem;
use serde_json::Value;

use crate::agreement::invariants::{excluded, system};
use crate::agreement::systems::Dice;
use crate::agreement::{all_agree, cases, first};

/// Number of mutations that change the meaning of a certificate.
const MUTATIONS: usize = 1000;

/// Returns the certificate of some predicates that hold in no state of a system.
fn certificate(system: &TimedSystem, never: Vec<Predicate>) -> Value {
    let claims: Vec<(String, Predicate)> = (never.into_iter().enumerate())
        .map(|(number, never)| (format!("claim {number}"), never))
        .collect();
    let certificate = Certificate {
        format: FORMAT,
        scenarios: vec![ScenarioCertificate {
            scenario: "random".to_owned(),
            systems: vec![SystemCertificate::new(system, &claims)],
            uncertified: Vec::new(),
        }],
    };
    serde_json::to_value(&certificate).expect("a certificate is JSON")
}

/// Returns the outcomes of the claims of a certificate; `None` if it is not a certificate.
fn outcomes(certificate: &Value) -> Option<Vec<Outcome>> {
    let answers = check(certificate.to_string().as_bytes()).ok()?;
    Some(answers.into_iter().map(|answer| answer.outcome).collect())
}

#[test]
fn certificates_of_what_invariants_exclude_are_accepted() {
    static ACCEPTED: AtomicUsize = AtomicUsize::new(0);
    all_agree(first(), cases(), 2, |seed| {
        let system = system(seed)?;
        let claims = excluded(seed, &system);
        let number = claims.len();
        let certificate = certificate(&system, claims);
        let found = outcomes(&certificate).unwrap_or_default();
        ACCEPTED.fetch_add(number, Ordering::Relaxed);
        let refused = found.iter().find(|outcome| !is_accepted(outcome));
        Some(match (refused, found.len() == number) {
            (None, true) => Ok(()),
            _ => Err(format!("seed {seed}: {refused:?}\n{certificate:#}")),
        })
    });
    let accepted = ACCEPTED.load(Ordering::Relaxed);
    eprintln!("{accepted} certified claims are accepted");
    assert!(accepted as u64 >= 2 * cases(), "claims are certified");
}

#[test]
fn parts_of_random_runs_follow_the_steps_of_certificates() {
    let (mut errors, mut followed) = (Vec::new(), 0);
    for seed in first()..first() + cases() {
        let Some(system) = system(seed) else {
            continue;
        };
        let atoms = follow::atoms(&system);
        let certificate = certificate(&system, atoms.clone());
        match follow::run(&system, &atoms, &certificate, &mut Dice::new(seed)) {
            Ok(()) => followed += 1,
            Err(error) => errors.push(format!("seed {seed}: {error}")),
        }
    }
    assert_eq!(errors, [""; 0]);
    assert!(2 * followed >= cases(), "runs are followed");
}

#[test]
fn mutated_certificates_are_refused() {
    let (mut changed, mut tried, mut by_kind) = (0, 0, [0; mutate::KINDS.len()]);
    for seed in first().. {
        if changed >= MUTATIONS {
            break;
        }
        let Some(system) = system(seed) else {
            continue;
        };
        let claims = excluded(seed, &system);
        let mut dice = Dice::new(seed);
        for claim in claims.into_iter().take(3) {
            let certificate = certificate(&system, vec![claim]);
            let found = outcomes(&certificate);
            assert!(found.is_some_and(|all| all.len() == 1 && is_accepted(&all[0])));
            assert_ne!(enumeration::is_possible(&certificate), Some(true));
            for (kind, number) in by_kind.iter_mut().enumerate() {
                let mut mutated = certificate.clone();
                if !mutate::mutate(&mut mutated, kind, &mut dice) || mutated == certificate {
                    continue;
                }
                tried += 1;
                let Some(true) = enumeration::is_possible(&mutated) else {
                    continue;
                };
                let found = outcomes(&mutated);
                let accepted = found.is_some_and(|all| all.iter().any(is_accepted));
                assert!(!accepted, "seed {seed}, {}: {mutated:#}", mutate::KINDS[kind]);
                changed += 1;
                *number += 1;
            }
        }
    }
    let by_kind: Vec<_> = mutate::KINDS.iter().zip(by_kind).collect();
    eprintln!("{changed} of {tried} mutations change the meaning, and are refused: {by_kind:?}");
    let missing = by_kind.iter().find(|(_, number)| *number == 0);
    assert_eq!(missing, None, "each kind of mutation is tried");
}

fn is_accepted(outcome: &Outcome) -> bool {
    matches!(outcome, Outcome::Accepted(_))
}
