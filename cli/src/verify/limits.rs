//! `--sensitivity`: changes that repair a system, and its slack. Answers are printed when they are found.

use std::io::{IsTerminal, Write};

use dotgen_timing::advice::RepairProgress;
use dotgen_timing::derive::InterimResult;
use dotgen_timing::verify::Cancel;

use super::{Answer, Session, Slacks, text};
use crate::progress::{self, Activity};
use dotgen_views::verification::changes::{self, Repair};

/// Computes all answers, and prints each when it is found if `prints` is set.
pub(super) fn found(
    session: &Session,
    answer: &Answer,
    cancel: &Cancel,
    prints: bool,
) -> anyhow::Result<Slacks> {
    let lines = text::Limits::of(answer);
    let print = |text: &dyn Fn(&mut dyn Write) -> std::io::Result<()>| {
        if prints {
            let mut out = anstream::AutoStream::auto(std::io::stdout().lock());
            // If the reader has closed the output, the computation continues.
            let _ = text(&mut out).and_then(|()| out.flush());
        }
    };
    // Lines that are printed one by one show the progress themselves.
    let shows = prints && std::io::stdout().is_terminal();
    type Work<'a> = &'a mut dyn FnMut(&(dyn Fn(Activity) + Sync));
    let during = |doing: &str, work: Work<'_>| {
        if shows { work(&|_| {}) } else { progress::during(Some(cancel), doing, work) }
    };
    let (problem, options, report) = (&answer.problem, &answer.options, &answer.report);
    let mut repairs = changes::Repairs::default();
    during("looking for repairs", &mut |tell| {
        let trying = |progress: RepairProgress| {
            tell(Activity {
                what: format!("trying {}", progress.trying),
                how_far: format!("{} of {}", progress.done + 1, progress.of),
            });
        };
        let found = |repair: &Repair| print(&|out| lines.repair(out, repair));
        repairs = changes::repairs(problem, options, report, (cancel, None), (&trying, &found));
    });
    print(&|out| lines.repaired(out, &repairs));
    print(&|out| lines.heading(out));
    let mut sensitivity = None;
    during("looking for limits", &mut |tell| {
        let told = |interim_result: InterimResult| match interim_result {
            InterimResult::Asking(progress) => tell(Activity {
                what: format!("looking for {}", progress.asking),
                how_far: format!("{} of {}", progress.done + 1, progress.of),
            }),
            InterimResult::Cores(core) => print(&|out| lines.cores(out, core)),
            InterimResult::Wcet(wcet) => print(&|out| lines.extreme(out, "largest WCET", wcet)),
            InterimResult::Period(period) => {
                print(&|out| lines.extreme(out, "smallest period", period));
            }
        };
        // Errors of the scenario were reported.
        sensitivity = problem.sensitivity(options, cancel, &told).ok();
    });
    if let Some(sensitivity) = &sensitivity {
        print(&|out| lines.ending(out, sensitivity));
    }
    let edit = |repair: &Repair| {
        session.ask(&problem.path, |analysis| changes::edit(analysis, problem, &repair.change))
    };
    Ok(Slacks {
        edits: repairs.all.iter().map(edit).collect::<anyhow::Result<_>>()?,
        repairs,
        sensitivity,
    })
}
