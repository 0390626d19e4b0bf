//! Data shared by codels that run at the same time.

use smol_str::SmolStr;

use super::{codel::has_async, names::VisibleNames};
use crate::{
    ide::context::Context,
    model::{Param, ParamSource, PathElement, ServiceKind},
};

/// Data that the codel at the cursor must not access, because an async codel runs at the same time, or
/// because it is async itself.
pub(super) struct Shared {
    /// Source and first name.
    names: Vec<(&'static str, SmolStr)>,
    /// True if the whole ids are included.
    pub(super) any: bool,
}

impl Shared {
    pub(super) fn around(names: &VisibleNames<'_, '_>, context: &Context) -> Shared {
        let mut out = Shared { names: Vec::new(), any: false };
        let Some(component) = names.component() else {
            return out;
        };
        let own = context.frames.len().checked_sub(2).map(|depth| &context.frames[depth]);
        let head =
            own.map_or(&[][..], |frame| &context.tokens[frame.start.min(context.tokens.len())..]);
        let is_async = head.first().is_some_and(|head| head.is("async"));
        if !is_async && !has_async(component) {
            return out;
        }
        out.any = true;
        for at in component.all_codels() {
            let codel = component.codel(at);
            if (is_async || codel.is_async) && !names.is_around(codel.node) {
                out.add(&codel.params);
            }
        }
        if is_async {
            for service in &component.services {
                if service.kind == ServiceKind::Attribute {
                    out.add(&service.params);
                }
            }
        }
        out
    }

    fn add(&mut self, params: &[Param]) {
        for param in params {
            let source = match param.source {
                ParamSource::Port(_) => "port",
                ParamSource::Ids => "ids",
                _ => continue,
            };
            let first = match param.path.first() {
                Some(PathElement::Member(name)) if source == "ids" => name.clone(),
                _ => param.name.clone(),
            };
            self.names.push((source, first));
        }
    }

    pub(super) fn forbids(&self, source: &str, name: &str) -> bool {
        self.names.iter().any(|candidate| candidate.0 == source && candidate.1 == name)
    }
}
