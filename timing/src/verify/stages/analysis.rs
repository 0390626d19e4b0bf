//! Response-time analysis: checks of deadlines that bounds prove, and checks without a subject.

use crate::report::Report;
use crate::verify::part::Part;

pub(super) fn answer(part: &mut Part, report: &mut Report) {
    for (i, check) in part.open(report) {
        if let Some(missing) = part.group.nothing(check) {
            report.answer(i, missing);
        } else if let Some(bound) = part.analysed.deadline(check) {
            report.answer(i, part.group.meets_deadlines(check, bound, &part.analysed));
        } else if part.analysed.is_zero(check) {
            report.answer(i, part.group.takes_no_time(check));
        }
    }
}
