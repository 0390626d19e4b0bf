//! The certificate of a report: the claims of the checks that invariants answer.

use super::checks::expand;
use super::group::Group;
use super::part::{Parted, parted};
use super::{Options, SystemInput, settings};
use crate::cancel::Cancel;
use crate::invariants::certificate::{ScenarioCertificate, SystemCertificate, Uncertified};
use crate::property::Predicate;
use crate::report::{CheckReport, Layer, Report, TimeUnit, Verdict};
use crate::scn::ast::Scenario;
use crate::scn::names::Names;
use crate::system::build::build;

/// Returns the certificate of the checks in a report that invariants answer. The report is that of the same
/// input, scenario and options.
pub fn certificate(
    input: &SystemInput,
    scenario: &Scenario,
    options: &Options,
    report: &Report,
) -> ScenarioCertificate {
    let names = Names::new(&input.specs);
    let settings = settings(scenario, options);
    let whole = build(&names, &settings, &|_| true);
    let checks = expand(&names, &whole, &settings, &mut Vec::new());
    let answered = |check: usize| report.checks.get(check);
    let certified = |check: usize| answered(check).is_some_and(by_invariants);
    let mut systems = Vec::new();
    let mut claimed = Vec::new();
    for Parted { built, of_group } in parted(&names, &settings, &whole, &checks) {
        let group = Group {
            names: &names,
            built: &built,
            unit: TimeUnit::of(&settings),
            settings: &settings,
            limits: options.limits,
            until_failure: false,
            cancel: &Cancel::default(),
            tell: &|_| {},
        };
        let mut claims: Vec<(String, Predicate)> = Vec::new();
        for check in of_group.into_iter().filter(|&check| certified(check)) {
            if let (Some(answer), Some(never)) = (answered(check), group.excluded(&checks[check])) {
                claims.push((format!("{} ({})", words(answer), answer.verdict.word()), never));
                claimed.push(check);
            }
        }
        if !claims.is_empty() {
            systems.push(SystemCertificate::new(&built.system, &claims));
        }
    }
    ScenarioCertificate {
        scenario: report.scenario.clone(),
        systems,
        uncertified: (report.checks.iter().enumerate())
            .filter(|(number, _)| !claimed.contains(number))
            .map(|(_, check)| uncertified(check))
            .collect(),
    }
}

fn by_invariants(check: &CheckReport) -> bool {
    check.by == Some(Layer::Invariants)
        && matches!(check.verdict, Verdict::Proved | Verdict::Refuted)
}

/// Returns a check as a scenario writes it.
fn words(check: &CheckReport) -> String {
    let label = check.name.iter().map(|name| format!("{name}: "));
    let words = [check.kind.word(), &check.of].join(" ");
    label.collect::<String>() + words.trim_end()
}

fn uncertified(check: &CheckReport) -> Uncertified {
    let answered = check.verdict.holds() || check.verdict == Verdict::Refuted;
    let by = answered.then(|| check.by.map_or("exploration".to_owned(), |layer| layer.to_string()));
    Uncertified { check: words(check), verdict: check.verdict.word().to_owned(), by }
}
