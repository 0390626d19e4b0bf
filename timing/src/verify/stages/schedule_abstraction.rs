//! Schedule abstraction: better bounds, and the checks of deadlines that they prove.

use super::analysis;
use crate::explore::Kind;
use crate::report::Report;
use crate::verify::part::Part;

pub(super) fn answer(part: &mut Part, report: &mut Report) {
    let Part { group, analysed, .. } = part;
    let wanted = part.of_group.iter().any(|&i| report.is_open(i) && part.checks[i].is_of_task());
    if !wanted || group.limits.without.contains(Kind::ScheduleAbstraction) {
        return;
    }
    let found = analysed.abstracted(group.limits.bytes, group.cancel);
    report.reductions.add_abstraction(found.as_ref().err().copied());
    let Ok(open) = found else {
        return;
    };
    let open = open.into_iter().map(|(task, why)| (analysed.path(task), why));
    report.reductions.left_open.extend(open);
    analysis::answer(part, report);
}
