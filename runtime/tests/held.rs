//! What is seen along runs is what verification says can be seen, on random systems of all that the servers
//! do.

use std::sync::Arc;

use camino::Utf8Path;
use dotgen_analysis::diagnostic::Severity;
use dotgen_analysis::host::{
    AnalysisHost, BatchInput, FileContent, Input, Loader, PackageFlags, UnitResult,
};
use dotgen_runtime::decide::Durations;
use dotgen_runtime::engine::End;
use dotgen_runtime::judge::Verdict as Held;
use dotgen_runtime::simulation::{Plan, simulate};
use dotgen_timing::explore::Limits;
use dotgen_timing::report::{Value, Verdict};
use dotgen_timing::scn::parse;
use dotgen_timing::verify::{Cancel, Options, Question, SystemInput, prepare, verify};

#[allow(dead_code, reason = "shared with the tests of verification")]
#[path = "../../timing/tests/agreement/servers/random.rs"]
mod random;

/// What the random texts are made with.
mod systems {
    pub(crate) struct Dice(fastrand::Rng);

    impl Dice {
        pub(crate) fn new(seed: u64) -> Self {
            Dice(fastrand::Rng::with_seed(seed))
        }

        pub(crate) fn below(&mut self, n: u32) -> u32 {
            self.0.u32(..n)
        }

        pub(crate) fn in_ten(&mut self, n: u32) -> bool {
            self.below(10) < n
        }

        pub(crate) fn pick<T: Copy>(&mut self, from: &[T]) -> T {
            from[self.0.usize(..from.len())]
        }
    }
}

struct Nothing;

impl Loader for Nothing {
    fn read(&self, _: &Utf8Path) -> FileContent {
        FileContent::Missing
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

/// `None` if the specification has errors: machines are drawn at random.
fn load(host: &AnalysisHost, text: &str) -> Option<UnitResult> {
    let input = BatchInput {
        inputs: vec![Input::Text {
            name: "test.gen".into(),
            text: text.into(),
        }],
        ..BatchInput::default()
    };
    let unit = host.analysis().batch(&input).expect("nobody cancels");
    let mut errors = unit.diagnostics.iter();
    let error = errors.any(|it| it.severity == Severity::Error);
    (!error).then_some(unit)
}

/// How many checks were compared; `None` if the system is no legal one, or too large.
fn compare(seed: u64) -> Option<usize> {
    let texts = random::texts(&mut systems::Dice::new(seed));
    let host = AnalysisHost::new(Arc::new(Nothing));
    let units = texts.specifications.iter().map(|it| load(&host, it));
    let units: Vec<UnitResult> = units.collect::<Option<_>>()?;
    let input = SystemInput {
        specs: units.iter().map(|it| &*it.spec).collect(),
    };
    let shown = || {
        format!(
            "seed {seed}\n{}\n{}",
            texts.specifications.join("\n"),
            texts.scenario
        )
    };
    let scenario = parse(&texts.scenario).scenario;
    let options = Options {
        limits: Limits {
            states: 100_000,
            threads: 1,
            ..Limits::default()
        },
        ..Options::default()
    };
    let proved = verify(&input, &scenario, &options, &Cancel::default());
    if proved.has_errors() || proved.unknown() {
        return None;
    }
    let prepared = prepare(&input, &scenario, &options);
    assert_eq!(prepared.checks.len(), proved.checks.len(), "{}", shown());
    let tasks = prepared.built.system.tasks.len();
    for durations in [Durations::Worst, Durations::Random, Durations::Best] {
        let plan = Plan {
            until: 400,
            runs: 4,
            seed,
            durations,
            stop_at_violation: false,
            record: false,
        };
        let none: Option<&mut dotgen_runtime::profile::Profile<Vec<u8>>> = None;
        let outcome = simulate(&prepared, vec![None; tasks], &plan, none, None, &|| false);
        assert!(
            matches!(outcome.end, End::Done | End::NothingLeft | End::Standstill),
            "{:?}",
            outcome.end
        );
        for (i, check) in proved.checks.iter().enumerate() {
            let (asked, answer) = (&prepared.checks[i], &outcome.judge.answers[i]);
            let about = || {
                format!(
                    "{} {}: {answer:?}, {check:?}\n{}",
                    check.kind,
                    check.of,
                    shown()
                )
            };
            assert_eq!(asked.report.id, check.id, "{}", about());
            match asked.question {
                Question::Reachable(_) => {
                    let contradicts =
                        answer.verdict == Held::Seen && check.verdict == Verdict::Refuted;
                    assert!(!contradicts, "{}", about());
                }
                Question::Response(..) | Question::Within(..) => {
                    if let (Some(seen), Some(Value::Time(most))) = (answer.greatest, check.value) {
                        assert!(prepared.time(u64::from(seen)) <= most, "{}", about());
                    }
                }
                _ => {
                    let contradicts =
                        answer.verdict == Held::Violated && check.verdict == Verdict::Proved;
                    assert!(!contradicts, "{}", about());
                }
            }
        }
    }
    Some(proved.checks.len())
}

/// How many systems: `DOTGEN_RUN_SYSTEMS`, by default some dozens.
fn systems_to_compare() -> u64 {
    let given = std::env::var("DOTGEN_RUN_SYSTEMS").ok();
    given.and_then(|it| it.parse().ok()).unwrap_or(60)
}

#[test]
fn nothing_is_seen_that_verification_excludes() {
    let systems = systems_to_compare();
    let mut compared = 0;
    let mut seed = 0;
    while compared < systems {
        compared += u64::from(compare(seed).is_some_and(|it| it > 0));
        seed += 1;
        assert!(seed < 20 * systems + 100, "few systems are legal and small");
    }
}
