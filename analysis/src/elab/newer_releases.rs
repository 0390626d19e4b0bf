//! Features that only newer releases of GenoM3 accept: reported if the specifications claim to work with
//! older ones.

use super::{context::Elaborator, state::NewerReleases};
use crate::finding::role::Role;
use crate::{
    finding::{Finding, Near, services::DeclarationProblem},
    item_tree::Expr,
    model::Src,
    release::{Change, Release},
};

impl<'a> Elaborator<'a> {
    /// Records a use of a feature that only releases with a change accept.
    pub(super) fn newer(&mut self, change: Change, what: &'static str, at: Src) {
        // For an imported interface, this was reported in the interface.
        let known = self.newer.uses.iter().any(|usage| usage.0 == change && usage.2 == at);
        if !known {
            self.newer.uses.push((change, what, at));
        }
    }

    /// Records the use if the release in force accepts it; otherwise reports the given error.
    pub(super) fn newer_or(
        &mut self,
        change: Change,
        what: &'static str,
        at: Src,
        otherwise: Finding,
    ) {
        if self.spec.release.has(change) {
            self.newer(change, what, at);
        } else {
            self.report(otherwise);
        }
    }

    /// Records the releases in a `requires`.
    pub(super) fn note_requirements(&mut self, list: &'a [Expr]) {
        for expr in list {
            let bound = super::property::text(expr).and_then(|text| Release::lower_bound(&text));
            if let Some(bound) = bound {
                let at = self.src(expr.ptr);
                self.newer.requirements.push((bound, at));
            }
        }
    }

    /// Reports features that not all releases claimed by the specifications accept.
    pub(super) fn report_newer(&mut self) {
        let NewerReleases { uses, requirements } = std::mem::take(&mut self.newer);
        let all = self.spec.components.iter().flat_map(|component| &component.requires);
        let all = all.chain(&self.spec.pragma_requires);
        let bound = all.filter_map(|requirement| Release::lower_bound(requirement)).max();
        let greatest = requirements.iter().max_by_key(|requirement| requirement.0).copied();
        for (change, what, at) in uses {
            let since = change.since();
            if bound >= Some(since) {
                continue;
            }
            let kind = match bound {
                Some(bound) => DeclarationProblem::NewerThanRequired { what, since, bound },
                None => DeclarationProblem::NewerThanAny { what, since },
            };
            let mut finding = Finding::new(kind, at);
            if let Some((_, place)) = greatest {
                let required = format!("genom3 >= {since}");
                finding = finding.related(place, Role::Requirement).near(Some(Near {
                    at: place,
                    plain: false,
                    text: format!("\"{required}\"").into(),
                    name: required.into(),
                }));
            }
            self.report(finding);
        }
    }
}
