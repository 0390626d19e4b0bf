//! `--sensitivity`: changes that repair a system, and its slack. Answers are printed when they are found.

use std::io::{IsTerminal, Write};

use dotgen_timing::advice::RepairProgress;
use dotgen_timing::derive::InterimResult;
use dotgen_timing::verify::Cancel;

use super::progress::{self, Activity};
use super::{Answer, Session, Slacks, text};
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
    let during = |doing: &str, work: Work<'_>| match shows {
        true => work(&|_| {}),
        false => progress::during(cancel, doing, work),
    };
    let (problem, options, report) = (&answer.problem, &answer.options, &answer.report);
    let mut repairs = changes::Repairs::default();
    during("looking for repairs", &mut |tell| {
        let trying = |it: RepairProgress| {
            tell(Activity {
                what: format!("trying {}", it.trying),
                how_far: format!("{} of {}", it.done + 1, it.of),
            });
        };
        let found = |it: &Repair| print(&|out| lines.repair(out, it));
        repairs = changes::repairs(problem, options, report, (cancel, None), (&trying, &found));
    });
    print(&|out| lines.repaired(out, &repairs));
    print(&|out| lines.heading(out));
    let mut sensitivity = None;
    during("looking for limits", &mut |tell| {
        let told = |it: InterimResult| match it {
            InterimResult::Asking(it) => tell(Activity {
                what: format!("looking for {}", it.asking),
                how_far: format!("{} of {}", it.done + 1, it.of),
            }),
            InterimResult::Cores(it) => print(&|out| lines.cores(out, it)),
            InterimResult::Wcet(it) => print(&|out| lines.extreme(out, "largest WCET", it)),
            InterimResult::Period(it) => print(&|out| lines.extreme(out, "smallest period", it)),
        };
        // Errors of the scenario were reported.
        sensitivity = problem.sensitivity(options, cancel, &told).ok();
    });
    if let Some(it) = &sensitivity {
        print(&|out| lines.ending(out, it));
    }
    let edit = |it: &Repair| {
        session.ask(&problem.path, |analysis| {
            changes::edit(analysis, problem, &it.change)
        })
    };
    Ok(Slacks {
        edits: repairs
            .all
            .iter()
            .map(edit)
            .collect::<anyhow::Result<_>>()?,
        repairs,
        sensitivity,
    })
}
