//! The effect of rounding to the unit of a scenario (section 20 of the timed semantics).

use crate::system::indexed::Built;
use crate::system::units;
use dotgen_analysis::quantity;

/// Number of codels named in the note; further codels are only counted.
const NAMED: usize = 4;

/// Returns a note about the rounded codels: their effect on the answers that were found with them. `None` if
/// no codel was rounded.
pub(super) fn note(built: &Built) -> Option<String> {
    let rounded = &built.rounded;
    if rounded.is_empty() {
        return None;
    }
    let names = rounded.iter().take(NAMED).map(|rounded| {
        let times = [rounded.exact, rounded.taken].map(quantity::time);
        format!("{} ({} taken as {})", rounded.codel, times[0], times[1])
    });
    let mut names = names.collect::<Vec<_>>().join(", ");
    if rounded.len() > NAMED {
        names += &format!(" and {} more", rounded.len() - NAMED);
    }
    let exact = match built.exact_unit.and_then(units::as_written) {
        Some(unit) => format!("`unit {unit};` gives exact values"),
        None => "without `unit`, values are exact".to_owned(),
    };
    Some(format!(
        "rounded to the unit of the scenario: {names}; what is proved holds for the exact times, and values are upper \
         bounds; {exact}"
    ))
}
