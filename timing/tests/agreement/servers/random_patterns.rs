//! Random patterns of predicates in time.

use std::fmt::Write;

use super::{Dice, Known, predicate};

/// Adds a pattern of each form.
pub(super) fn add(dice: &mut Dice, known: &Known, out: &mut String) {
    for (i, form) in [
        "absent Q after P for T ms",
        "lasts P >= T ms",
        "P precedes Q",
        "before P never Q",
        "before P eventually Q",
        "after P never Q",
        "after P always Q",
        "between P and Q never R",
        "between P and Q always R",
        "between P and Q eventually R",
        "after P until Q never R",
        "after P until Q always R",
    ]
    .into_iter()
    .enumerate()
    {
        // A moment can begin something, and cannot be over for some time.
        let moments = known.periodic && !form.starts_with("lasts");
        let mut predicate = |place: usize| match dice.below(6) {
            0 if moments && place == 0 => {
                let tasks: Vec<&str> = known.tasks.iter().map(String::as_str).collect();
                format!("{}.tick", dice.pick(&tasks))
            }
            1 => format!("({} and {})", predicate(dice, known), predicate(dice, known)),
            _ => predicate(dice, known),
        };
        let [p, q, r] = std::array::from_fn(&mut predicate);
        let time = 1 + dice.below(9);
        let words = form.split(' ').map(|word| match word {
            "P" => p.clone(),
            "Q" => q.clone(),
            "R" => r.clone(),
            "T" => time.to_string(),
            word => word.to_owned(),
        });
        let _ = writeln!(out, " check p{i}: {};", words.collect::<Vec<_>>().join(" "));
    }
}
