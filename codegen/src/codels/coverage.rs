//! The compared part of the codels, and the missing declarations that the other codels need.

use std::fmt;

use dotgen_analysis::model::Name;
use serde::Serialize;

use super::expected::Expected;
use super::reliability::Reliability;

/// The compared part of the codels of some components.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Coverage {
    /// Functions that the specification names.
    pub codels: usize,
    /// Number of these functions that were compared in part: their existence, their return values and
    /// exceptions, the number of their parameters and the known types.
    pub judged: usize,
    /// Number of these functions with known types of all parameters. Unknown types agree with any.
    pub compared: usize,
    /// Number of functions whose declaration has errors; they were skipped.
    pub faulty: usize,
    /// The missing interfaces of the other functions.
    pub waiting: Vec<UncheckedCodels>,
    /// Unknown modules and types, which agree with any type of a parameter.
    pub assumed: Vec<Name>,
}

/// Codels with parameters from an unknown interface.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct UncheckedCodels {
    /// The unknown interface.
    #[serde(rename = "for")]
    pub missing: Name,
    /// Number of codels with a parameter from that interface.
    pub codels: usize,
}

impl Coverage {
    /// Adds the codels of a component.
    pub fn add(&mut self, expected: &Expected<'_>, trust: &Reliability) {
        for function in &expected.functions {
            self.codels += 1;
            if trust.is_faulty(expected, function) {
                self.faulty += 1;
                continue;
            }
            self.judged += 1;
            self.compared += usize::from(function.awaits.interfaces.is_empty());
            for name in &function.awaits.types {
                if !self.assumed.contains(name) {
                    self.assumed.push(name.clone());
                }
            }
            for name in &function.awaits.interfaces {
                match self.waiting.iter_mut().find(|codels| codels.missing == *name) {
                    Some(known) => known.codels += 1,
                    None => self.waiting.push(UncheckedCodels { missing: name.clone(), codels: 1 }),
                }
            }
        }
    }

    /// True if everything was compared.
    pub fn is_complete(&self) -> bool {
        self.compared == self.codels && self.assumed.is_empty()
    }
}

impl fmt::Display for Coverage {
    /// `17 of 21 codels compared; 4 wait for or_pose_estimator`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} codels compared", self.compared, self.codels)?;
        for codels in &self.waiting {
            let verb = if codels.codels == 1 { "waits" } else { "wait" };
            write!(f, "; {} {verb} for {}", codels.codels, codels.missing)?;
        }
        for (number, name) in self.assumed.iter().enumerate() {
            f.write_str(if number == 0 { "; unknown and taken for any type: " } else { ", " })?;
            f.write_str(name)?;
        }
        match self.faulty {
            0 => Ok(()),
            1 => f.write_str("; 1 has errors in its declaration"),
            n => write!(f, "; {n} have errors in their declarations"),
        }
    }
}
