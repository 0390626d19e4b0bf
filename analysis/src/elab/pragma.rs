//! Pragmas (language reference, section 17).

use crate::finding::role::Role;
use smol_str::SmolStr;

use super::{codel::TimePlace, context::Elaborator, property::union, state::PragmaWcet};
use crate::{
    finding::{Finding, names::NameProblem, values::ValueProblem},
    item_tree::{Duration, Name, Path, Pragma, Ptr},
};

impl<'a> Elaborator<'a> {
    pub(super) fn pragma(&mut self, pragma: &'a Pragma) {
        match pragma {
            Pragma::Requires { arguments, .. } => {
                let added = arguments.iter().map(|(text, _)| text.to_string());
                union(&mut self.spec.pragma_requires, added);
            }
            Pragma::Provides { arguments, .. } => {
                for (name, ptr) in arguments {
                    let at = self.src(*ptr);
                    if name.starts_with("//") || name.starts_with("/*") {
                        self.error(at, NameProblem::CommentInPragma);
                        break;
                    }
                    let found = self.interface(
                        name,
                        at,
                        |name| NameProblem::UnknownInPragma { name },
                        |name| NameProblem::ComponentInPragma { name },
                    );
                    if found.is_none() {
                        self.pragma_unknown.push(name.clone());
                    }
                    union(&mut self.pragma_provides, found);
                }
            }
            Pragma::Masquerade { arguments, ty, ptr } => {
                self.masquerade(arguments, ty.as_ref(), *ptr);
            }
            Pragma::Wcet { codel, duration, ptr } => {
                self.pragma_wcet(codel.as_ref(), duration.as_ref(), *ptr);
            }
        }
    }

    fn masquerade(&mut self, arguments: &[(SmolStr, Ptr)], ty: Option<&'a Path>, ptr: Ptr) {
        let at = self.src(ptr);
        let [(template, _), (name, _), (data, _)] = arguments else {
            self.error(
                at,
                NameProblem::MasqueradeArguments {
                    are: if arguments.len() == 1 { "is" } else { "are" },
                    count: arguments.len(),
                },
            );
            return;
        };
        let Some(ty) = ty.and_then(|ty| self.resolve_path(ty)) else {
            self.error(at, NameProblem::MasqueradeUnknown { name: name.clone() });
            return;
        };
        let known = &mut self.spec.types[ty].masquerade;
        if known.iter().any(|(name, _)| name == template.as_str()) {
            self.error(
                at,
                NameProblem::MasqueradeTwice { name: name.clone(), template: template.clone() },
            );
        } else {
            known.push((template.to_string(), data.to_string()));
        }
    }

    fn pragma_wcet(&mut self, codel: Option<&'a Name>, duration: Option<&'a Duration>, ptr: Ptr) {
        let at = self.src(ptr);
        let (Some(codel), Some(duration)) = (codel, duration) else {
            self.error(at, ValueProblem::PragmaForm);
            return;
        };
        if duration.unit.is_none() {
            self.error(at, ValueProblem::PragmaUnit);
            return;
        }
        let Some((number, unit)) = self.execution_time(duration, TimePlace::Pragma, at) else {
            return;
        };
        let first = self.pragma_wcet.iter().find(|wcet| wcet.codel == codel.text);
        if let Some(first) = first {
            let diagnostic =
                Finding::new(ValueProblem::PragmaTwice { codel: codel.text.clone() }, at)
                    .related(first.at, Role::First);
            self.report(diagnostic);
            return;
        }
        let name = self.src(codel.ptr);
        self.pragma_wcet.push(PragmaWcet { codel: codel.text.clone(), name, at, number, unit });
    }
}
