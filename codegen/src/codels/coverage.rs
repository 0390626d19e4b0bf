//! How much of the codels was compared, and what the rest waits for.

use std::fmt;

use dotgen_analysis::model::Name;
use serde::Serialize;

use super::expected::Expected;
use super::trust::Trust;

/// What was compared of the codels of some components.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Coverage {
    /// Functions that the specification names.
    pub codels: usize,
    /// Of these, the ones of which something was compared: whether they are there, what they return and
    /// raise, the number of their parameters and the types that are known.
    pub judged: usize,
    /// Of these, the ones of which it is known what each parameter is. Unknown types agree with any.
    pub compared: usize,
    /// Those whose declaration has errors: they were left out.
    pub faulty: usize,
    /// What the others wait for.
    pub waiting: Vec<Waiting>,
    /// Modules and types that are not known, and agree with any type of a parameter.
    pub assumed: Vec<Name>,
}

/// Codels that wait for something.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Waiting {
    /// An interface that is not known.
    #[serde(rename = "for")]
    pub missing: Name,
    /// Number of codels with a parameter from there.
    pub codels: usize,
}

impl Coverage {
    /// Adds the codels of a component.
    pub fn add(&mut self, expected: &Expected<'_>, trust: &Trust) {
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
                match self.waiting.iter_mut().find(|it| it.missing == *name) {
                    Some(known) => known.codels += 1,
                    None => self.waiting.push(Waiting {
                        missing: name.clone(),
                        codels: 1,
                    }),
                }
            }
        }
    }

    /// Everything was compared.
    pub fn is_complete(&self) -> bool {
        self.compared == self.codels && self.assumed.is_empty()
    }
}

impl fmt::Display for Coverage {
    /// `17 of 21 codels compared; 4 wait for or_pose_estimator`
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {} codels compared", self.compared, self.codels)?;
        for it in &self.waiting {
            let verb = if it.codels == 1 { "waits" } else { "wait" };
            write!(f, "; {} {verb} for {}", it.codels, it.missing)?;
        }
        for (number, name) in self.assumed.iter().enumerate() {
            f.write_str(if number == 0 {
                "; unknown and taken for any type: "
            } else {
                ", "
            })?;
            f.write_str(name)?;
        }
        match self.faulty {
            0 => Ok(()),
            1 => f.write_str("; 1 has errors in its declaration"),
            n => write!(f, "; {n} have errors in their declarations"),
        }
    }
}
