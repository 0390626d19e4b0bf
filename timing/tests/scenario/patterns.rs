//! The table of patterns of the manual: for each row a check that holds and one that fails.

use super::*;

#[test]
fn each_pattern_has_a_check_that_holds_and_one_that_fails() {
    let unit = load(include_str!("patterns.gen"));
    let parsed = parse(include_str!("patterns.scn"));
    assert_eq!(parsed.errors, []);
    let input = SystemInput { specs: vec![&unit.spec] };
    let report = verify(&input, &parsed.scenario, &Options::default(), &Cancel::default());
    // An interval of time is two checks of one name, of which one fails.
    let mut verdicts: BTreeMap<&str, Vec<Verdict>> = BTreeMap::new();
    for check in &report.checks {
        let name = check.name.as_deref().expect("each check has a name");
        verdicts.entry(name).or_default().push(check.verdict);
        let run = check.counterexample.len();
        assert_eq!(
            run > 0,
            check.verdict == Verdict::Refuted && name != "fails_reachable",
            "{name}: {run}"
        );
    }
    for (name, verdicts) in verdicts {
        let holds = verdicts.iter().all(|verdict| *verdict == Verdict::Proved);
        let fails = verdicts.contains(&Verdict::Refuted);
        assert_eq!(
            (holds, fails),
            (name.starts_with("holds_"), name.starts_with("fails_")),
            "{name}"
        );
    }
}
