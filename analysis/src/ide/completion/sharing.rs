//! Data shared by codels that run at the same time.

use smol_str::SmolStr;

use super::{codel::has_async, names::Names};
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
    pub(super) fn around(names: &Names<'_, '_>, context: &Context) -> Shared {
        let mut out = Shared {
            names: Vec::new(),
            any: false,
        };
        let Some(component) = names.component() else {
            return out;
        };
        let own = context
            .frames
            .len()
            .checked_sub(2)
            .map(|it| &context.frames[it]);
        let head = own.map_or(&[][..], |it| {
            &context.tokens[it.start.min(context.tokens.len())..]
        });
        let is_async = head.first().is_some_and(|it| it.is("async"));
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
            for it in &component.services {
                if it.kind == ServiceKind::Attribute {
                    out.add(&it.params);
                }
            }
        }
        out
    }

    fn add(&mut self, params: &[Param]) {
        for it in params {
            let source = match it.source {
                ParamSource::Port(_) => "port",
                ParamSource::Ids => "ids",
                _ => continue,
            };
            let first = match it.path.first() {
                Some(PathElement::Member(name)) if source == "ids" => name.clone(),
                _ => it.name.clone(),
            };
            self.names.push((source, first));
        }
    }

    pub(super) fn forbids(&self, source: &str, name: &str) -> bool {
        self.names.iter().any(|it| it.0 == source && it.1 == name)
    }
}
