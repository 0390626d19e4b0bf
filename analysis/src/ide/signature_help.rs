//! The parameter list around the cursor, or the members initialized there.

use std::ops::Range;

use super::{
    FileView,
    completion::{initializer, names::VisibleNames, parameter_list},
    context::{Context, FrameKind, Surroundings, Word, surroundings},
    render,
};
use crate::model::{Codel, Param, ParamDir, ParamSource, Spec};

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignatureHelp {
    /// The whole text.
    pub label: String,
    /// The parameters: byte ranges of the label.
    pub parameters: Vec<Range<usize>>,
    /// The one at the cursor.
    pub active: Option<usize>,
    /// The documentation of the declaration.
    pub documentation: Option<String>,
}

pub(crate) fn signature_help(view: &FileView<'_>, at: usize) -> Option<SignatureHelp> {
    if at > view.text().len()
        || !view.text().is_char_boundary(at)
        || surroundings(view, at) == Surroundings::Dead
    {
        return None;
    }
    let context = Context::new(view, at);
    let names = VisibleNames::new(view, &context, at);
    let mut frame = context.frames.len() - 1;
    // Inside an index or an expression: use the enclosing list.
    while frame > 0
        && (context.frames[frame].kind == FrameKind::Bracket
            || context.frames[frame].kind == FrameKind::Paren
                && parameter_list::list_kind(&context, frame).is_none())
    {
        frame -= 1;
    }
    match context.frames[frame].kind {
        FrameKind::Initializers => members(&names, &context, frame),
        FrameKind::Paren => list(&names, &context, frame),
        _ => None,
    }
}

/// The members that braces initialize.
fn members(names: &VisibleNames<'_, '_>, context: &Context, frame: usize) -> Option<SignatureHelp> {
    let ty = initializer::compound_type(names, context, frame)?;
    let spec = names.spec();
    let place = &context.frames[frame];
    let words = &context.tokens[place.start.min(context.tokens.len())..];
    let mut out = Builder::new(format!("{} {{ ", render::type_text(spec, ty)));
    if let Some(element) = names.element(ty) {
        out.parameter(&format!("{}…", render::type_text(spec, element)));
        return Some(out.finish(" }", Some(0)));
    }
    let members = names.members(ty);
    for (name, member) in &members {
        out.parameter(&format!("{} {name}", render::type_text(spec, *member)));
    }
    let active = match words {
        [dot, name, ..] if dot.is(".") => members.iter().position(|member| member.0 == name.text),
        _ => Some(position(context, place.open, place.start, &members)),
    };
    (!members.is_empty()).then(|| out.finish(" }", active))
}

/// The member for an element without a designator: the one after the last initialized member.
fn position(
    context: &Context,
    open: usize,
    start: usize,
    members: &[(smol_str::SmolStr, crate::model::TypeId)],
) -> usize {
    let before = &context.tokens[open + 1..start.max(open + 1)];
    let mut depth = 0;
    let mut next = 0;
    let mut fresh = true;
    for pair in before.windows(2) {
        if fresh && depth == 0 && pair[0].is(".") {
            let named = members.iter().position(|member| member.0 == pair[1].text);
            next = named.unwrap_or(next);
        }
        fresh = false;
        match pair[0].text.as_str() {
            "{" | "(" | "[" => depth += 1,
            "}" | ")" | "]" => depth -= 1,
            "," if depth == 0 => {
                next += 1;
                fresh = true;
            }
            _ => {}
        }
    }
    next + usize::from(before.last().is_some_and(|token| token.is(",")))
}

fn list(names: &VisibleNames<'_, '_>, context: &Context, frame: usize) -> Option<SignatureHelp> {
    let place = &context.frames[frame];
    let head = context.head(place);
    let name = head.last().filter(|head| !head.is(">"))?;
    let kind = parameter_list::list_kind(context, frame)?;
    let spec = names.spec();
    let active = Some(place.commas);
    match kind {
        parameter_list::List::Codel { .. } => {
            let codel = known_codel(spec, name)?;
            let mut out = Builder::new(format!("{}(", name.text));
            for param in &codel.params {
                out.parameter(&parameter(spec, param, true));
            }
            let mut help = out.finish(")", active);
            let states = codel.yields.iter().map(|state| state.name.as_str());
            let states: Vec<&str> = states.collect();
            if !states.is_empty() {
                help.documentation = Some(format!("yields {}", states.join(", ")));
            }
            Some(help)
        }
        parameter_list::List::Attribute | parameter_list::List::Service => {
            // Declared before, here or in an interface: the parameters must be the same.
            let component = names.component()?;
            let service = component.services.iter().find(|service| service.name == name.text)?;
            let params: Vec<&Param> =
                service.params.iter().filter(|param| param.dir != ParamDir::Local).collect();
            if params.is_empty() {
                return None;
            }
            let mut out = Builder::new(format!("{}(", name.text));
            for param in params {
                out.parameter(&parameter(spec, param, false));
            }
            let mut help = out.finish(")", active);
            help.documentation.clone_from(&service.doc);
            Some(help)
        }
    }
}

/// The codel of a name with the most parameters: the others are being typed.
fn known_codel<'s>(spec: &'s Spec, name: &Word) -> Option<&'s Codel> {
    let all = spec.components.iter().flat_map(|component| {
        let codels = component.all_codels();
        codels.map(move |codel| component.codel(codel))
    });
    all.filter(|codel| codel.name == name.text && !codel.params.is_empty())
        .max_by_key(|codel| codel.params.len())
}

fn parameter(spec: &Spec, param: &Param, source: bool) -> String {
    let dir = param.dir.word();
    let source = match param.source {
        _ if !source => "",
        ParamSource::Ids => "ids ",
        ParamSource::Local(_) => "local ",
        ParamSource::Port(_) => "port ",
        ParamSource::Remote(_) => "remote ",
        ParamSource::Opaque => "",
    };
    let ty = match param.source {
        ParamSource::Remote(_) => String::new(),
        _ => format!("{} ", render::type_text(spec, param.ty)),
    };
    format!("{source}{dir} {ty}{}", param.name)
}

struct Builder {
    label: String,
    parameters: Vec<Range<usize>>,
}

impl Builder {
    fn new(label: String) -> Builder {
        Builder { label, parameters: Vec::new() }
    }

    fn parameter(&mut self, text: &str) {
        if !self.parameters.is_empty() {
            self.label += ", ";
        }
        let start = self.label.len();
        self.label += text;
        self.parameters.push(start..self.label.len());
    }

    fn finish(mut self, end: &str, active: Option<usize>) -> SignatureHelp {
        self.label += end;
        SignatureHelp {
            active: active.filter(|parameter| *parameter < self.parameters.len()),
            label: self.label,
            parameters: self.parameters,
            documentation: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::test_support::Fixture;

    /// Checks the label, with the active parameter in brackets.
    #[track_caller]
    fn check(text: &str, expected: &str) {
        let fixture = Fixture::new(text);
        let help = fixture.analysis().signature_help(&fixture.at()).unwrap();
        let found = help.map_or_else(String::new, |mut help| {
            if let Some(range) = help.active.map(|active| help.parameters[active].clone()) {
                help.label.insert(range.end, ']');
                help.label.insert(range.start, '[');
            }
            help.label
        });
        assert_eq!(found, expected);
    }

    const TEXT: &str = "struct s { double x; long y[2]; };
component c {
  ids { s v; };
  port out s p;
  task t { codel<start> f(in v.x, port out p) yield ether; };
  function g(in long a, in s b);
  HERE
};
";

    #[test]
    fn parameters() {
        let check = |here: &str, expected: &str| check(&TEXT.replace("HERE", here), expected);
        check("task u { codel<start> f($0", "f([ids in double x], port out s p)");
        check("task u { codel<start> f(in v.x, $0", "f(ids in double x, [port out s p])");
        check("function g(in long a, $0", "g(in long a, [in s b])");
        check("task u { codel<start> unknown($0", "");
        check("task u { $0", "");
    }

    #[test]
    fn initializers() {
        let check = |here: &str, expected: &str| check(&TEXT.replace("HERE", here), expected);
        check("function h(in s b = { $0", "s { [double x], long[2] y }");
        check("function h(in s b = { 1, $0", "s { double x, [long[2] y] }");
        check("function h(in s b = { .y = $0", "s { double x, [long[2] y] }");
        check("function h(in s b = { .x = (1 + $0", "s { [double x], long[2] y }");
        check("function h(in s b = { .y = { $0", "long[2] { [long…] }");
        check("attribute h(in v = { $0", "s { [double x], long[2] y }");
    }
}
