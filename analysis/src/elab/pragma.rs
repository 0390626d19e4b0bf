//! Pragmas (language reference, section 17).

use smol_str::SmolStr;

use super::{ElabDiagnostic, context::Elaborator, property::union};
use crate::{
    item_tree::{Duration, Name, Path, Pragma, Ptr, Unit},
    model::{Name as Text, Seconds, Src},
};

/// `#pragma wcet`, kept until all codels are known.
#[derive(Debug)]
pub(super) struct PragmaWcet {
    pub(super) codel: Text,
    /// The name of the codel.
    pub(super) name: Src,
    /// The directive.
    pub(super) at: Src,
    pub(super) number: Seconds,
    pub(super) unit: Option<Unit>,
}

impl<'a> Elaborator<'a> {
    pub(super) fn pragma(&mut self, pragma: &'a Pragma) {
        match pragma {
            Pragma::Requires { arguments, .. } => {
                let added = arguments.iter().map(|(it, _)| it.to_string());
                union(&mut self.spec.pragma_requires, added);
            }
            Pragma::Provides { arguments, .. } => {
                for (name, ptr) in arguments {
                    let at = self.src(*ptr);
                    if name.starts_with("//") || name.starts_with("/*") {
                        self.error(
                            "pragma-provides-unknown",
                            at,
                            "in a pragma, comments are read as names of interfaces; write it on a \
                             line of its own",
                        );
                        break;
                    }
                    let found = self.interface(
                        name,
                        at,
                        "pragma-provides-unknown",
                        "pragma-provides-component",
                    );
                    union(&mut self.pragma_provides, found);
                }
            }
            Pragma::Masquerade { arguments, ty, ptr } => {
                self.masquerade(arguments, ty.as_ref(), *ptr);
            }
            Pragma::Wcet {
                codel,
                duration,
                ptr,
            } => self.pragma_wcet(codel.as_ref(), duration.as_ref(), *ptr),
        }
    }

    fn masquerade(&mut self, arguments: &[(SmolStr, Ptr)], ty: Option<&'a Path>, ptr: Ptr) {
        let at = self.src(ptr);
        let [(template, _), (name, _), (data, _)] = arguments else {
            let message = format!(
                "`#pragma masquerade` takes three arguments, a template, a type and a text, but \
                 there {} {}; put texts with blanks in quotes",
                if arguments.len() == 1 { "is" } else { "are" },
                arguments.len()
            );
            self.error("pragma-masquerade-syntax", at, message);
            return;
        };
        let Some(ty) = ty.and_then(|it| self.resolve_path(it)) else {
            let message = format!("there is no type `{name}` so far, so it cannot masquerade");
            self.error("pragma-masquerade-type", at, message);
            return;
        };
        let known = &mut self.spec.types[ty.0 as usize].masquerade;
        if known.iter().any(|(it, _)| it == template.as_str()) {
            let message = format!("`{name}` has a masquerade for template `{template}` already");
            self.error("pragma-masquerade-duplicate", at, message);
        } else {
            known.push((template.to_string(), data.to_string()));
        }
    }

    fn pragma_wcet(&mut self, codel: Option<&'a Name>, duration: Option<&'a Duration>, ptr: Ptr) {
        let at = self.src(ptr);
        let (Some(codel), Some(duration)) = (codel, duration) else {
            self.error(
                "wcet-pragma",
                at,
                "write `#pragma wcet CODEL DURATION UNIT`, for instance `#pragma wcet compute 2 ms`",
            );
            return;
        };
        if duration.unit.is_none() {
            self.error(
                "wcet-pragma",
                at,
                "the execution time needs a unit: `s`, `ms` or `us`",
            );
            return;
        }
        let Some((number, unit)) = self.execution_time(duration, "wcet-pragma", at) else {
            return;
        };
        let first = self.pragma_wcet.iter().find(|it| it.codel == codel.text);
        if let Some(first) = first {
            let message = format!(
                "codel `{}` is given an execution time twice; keep one of them",
                codel.text
            );
            let diagnostic =
                ElabDiagnostic::new("wcet-pragma", at, message).related(first.at, "the first one");
            self.report(diagnostic);
            return;
        }
        let name = self.src(codel.ptr);
        self.pragma_wcet.push(PragmaWcet {
            codel: codel.text.clone(),
            name,
            at,
            number,
            unit,
        });
    }
}
