//! Missing and superfluous braces.
//!
//! A missing `{` or `}` cannot be recognised at its place: `task t` may lack its `;` or its `{`. The braces
//! of the rest of the file decide ([`Parser::has_spare_brace`], [`Parser::lacks_brace`]), and so does the
//! indentation. If all braces are paired, nothing here changes the reading of a text.

use super::*;

/// Maximum number of tokens searched for the end of a body without `{`; no body is longer.
pub(super) const LOOK_AHEAD: usize = 4096;

/// The tokens that begin items inside and outside of components.
const COMMON: TokenSet = TokenSet::new(&[
    MODULE_KW,
    CONST_KW,
    TYPEDEF_KW,
    NATIVE_KW,
    EXCEPTION_KW,
    STRUCT_KW,
    UNION_KW,
    ENUM_KW,
]);

/// Properties that only components have.
const OF_COMPONENTS: TokenSet = TokenSet::new(&[
    VERSION_KW,
    LANG_KW,
    EMAIL_KW,
    REQUIRES_KW,
    CODELS_REQUIRES_KW,
    CLOCK_RATE_KW,
    PROVIDES_KW,
    USES_KW,
    EXTENDS_KW,
]);

/// Properties that components have too.
const SHARED: TokenSet = TokenSet::new(&[DOC_KW, THROWS_KW]);

/// An open body.
#[derive(Clone, Copy)]
pub(super) struct Body<'a> {
    pub(super) fragment: Fragment,
    /// The owner, for messages.
    pub(super) owner: &'a str,
    /// The `{`, unless that is missing.
    brace: Option<usize>,
    /// First token of the declaration that it belongs to.
    item: usize,
    /// First token in it.
    first: usize,
}

/// Begins a body at its `{`, or, where [`at_body`] found one without, at its first item.
pub(super) fn open<'a>(p: &mut Parser<'_>, fragment: Fragment, owner: &'a str) -> Body<'a> {
    let brace = p.position();
    let found = p.eat(L_CURLY);
    if !found && !p.is_reported() {
        p.expected_because(&format!("`{{` to open the body of {owner}"), "add `{` before it");
        p.add_missing_brace("{");
        if p.starts_line() {
            p.show_behind();
        }
    }
    p.open += 1;
    Body { fragment, owner, brace: found.then_some(brace), item: p.item, first: p.position() }
}

/// Ends a body. A missing `}` is reported at the token in its place.
pub(super) fn close(p: &mut Parser<'_>, body: Body<'_>) {
    let closed = !is_left(p, body) && p.eat(R_CURLY);
    p.open -= 1;
    if closed {
        return;
    }
    let owner = body.owner;
    if !p.is_reported() {
        let (found, owner) = (p.describe_current().into(), owner.into());
        let (missing, kind) = match p.current() {
            EOF => ("};", Parsing::BodyNotClosedAtEnd { owner }),
            // The `;` that follows the `}` is there.
            SEMICOLON => {
                let found = "this `;`".into();
                ("}", Parsing::BodyNotClosedHere { owner, found })
            }
            IDENT if body.fragment == Fragment::Members && p.nth_at_ts(1, AFTER_DECLARATOR) => {
                ("}", Parsing::BodyNotClosedHere { owner, found })
            }
            _ => ("};", Parsing::BodyNotClosed { owner, found }),
        };
        p.error_here(kind);
        p.add_missing_brace(missing);
        if let Some(brace) = body.brace {
            p.explain(brace, "this `{` is not closed");
        }
    }
    p.unclosed += 1;
}

/// The tokens that may follow the name of a member.
const AFTER_DECLARATOR: TokenSet = TokenSet::new(&[SEMICOLON, COMMA, L_BRACK]);

/// Returns true at a body, with or without its `{`.
pub(super) fn at_body(p: &Parser<'_>, fragment: Fragment) -> bool {
    p.at(L_CURLY) || (!p.at_item_end() && lacks_open(p, fragment))
}

/// Like [`at_body`], for the names of an enum.
pub(super) fn at_enumerators(p: &Parser<'_>) -> bool {
    const AFTER: TokenSet = TokenSet::new(&[COMMA, R_CURLY]);
    p.at(L_CURLY) || (p.at(IDENT) && p.nth_at_ts(1, AFTER) && p.has_spare_brace())
}

fn lacks_open(p: &Parser<'_>, fragment: Fragment) -> bool {
    const COMPONENTS: TokenSet = TokenSet::new(&[COMPONENT_KW, INTERFACE_KW]);
    const TYPES: TokenSet = TokenSet::new(&[STRUCT_KW, UNION_KW, ENUM_KW]);
    match fragment {
        Fragment::Specification => false,
        Fragment::Module => p.at_ts(COMMON) && p.has_spare_brace(),
        // Items that belong only in components need a component around them.
        Fragment::Component if p.at_ts(COMPONENTS) => false,
        Fragment::Component => {
            (spec::at_item(p) && !p.at_ts(COMMON))
                || (p.at(IDENT) || p.at_ts(COMMON)) && p.has_spare_brace()
        }
        Fragment::Members if p.at_ts(TYPES) => p.has_spare_brace(),
        Fragment::Members if p.starts_line() && spec::at_item(p) => false,
        Fragment::Members if p.at(IDENT) || p.at(COLON2) => {
            types::at_member(p) || p.at(COLON2) && p.has_spare_brace()
        }
        Fragment::Members => p.at_ts(types::TYPE_FIRST),
        Fragment::Cases => p.at(CASE_KW) || p.at(DEFAULT_KW),
        Fragment::Properties => {
            property::at_property(p) && p.has_spare_brace() && only_properties_follow(p)
        }
    }
}

/// Returns true if, in a component, the properties of a task or service without its first line begin here, up
/// to its `}`.
pub(super) fn at_headless_properties(p: &Parser<'_>) -> bool {
    property::at_property(p)
        && !p.at_ts(OF_COMPONENTS)
        && p.has_spare_brace()
        && properties_follow(p).is_some_and(|held| held)
}

/// Returns true if only properties follow, up to the next `}`.
fn only_properties_follow(p: &Parser<'_>) -> bool {
    properties_follow(p).is_some()
}

/// If only properties follow, up to the next `}`: true if some of them belong only to tasks or services.
fn properties_follow(p: &Parser<'_>) -> Option<bool> {
    const HELD: TokenSet = TokenSet::new(&[
        PERIOD_KW,
        DELAY_KW,
        PRIORITY_KW,
        SCHEDULING_KW,
        STACK_KW,
        INTERRUPTS_KW,
        BEFORE_KW,
        AFTER_KW,
        VALIDATE_KW,
        LOCAL_KW,
        ASYNC_KW,
        CODEL_KW,
    ]);
    const DECLARATIONS: TokenSet = TokenSet::new(&[
        IDS_KW,
        PORT_KW,
        TASK_KW,
        ATTRIBUTE_KW,
        FUNCTION_KW,
        ACTIVITY_KW,
        COMPONENT_KW,
        INTERFACE_KW,
        EXCEPTION_KW,
    ]);
    let mut held = false;
    let ends = each_beginning(p, p.position(), |i| {
        let word = p.input.contextual(i);
        // `task t;` is the property of a service.
        let is_property = word == TASK_KW && p.input.kind(i + 2) == SEMICOLON;
        held |= HELD.contains(word);
        is_property || !DECLARATIONS.contains(word)
    });
    ends.then_some(held)
}

/// Visits each token that begins something, outside of braces that open here, up to the next `}` that closes
/// nothing opened here. Returns true if there is such a `}` and `goes_on` was true up to it.
fn each_beginning(p: &Parser<'_>, start: usize, mut goes_on: impl FnMut(usize) -> bool) -> bool {
    let (mut depth, mut begins) = (0u32, true);
    for i in start..start + LOOK_AHEAD {
        if begins && depth == 0 && !goes_on(i) {
            return false;
        }
        let kind = p.input.kind(i);
        match kind {
            EOF => return false,
            R_CURLY if depth == 0 => return true,
            R_CURLY => depth -= 1,
            L_CURLY => depth += 1,
            _ => {}
        }
        begins = matches!(kind, SEMICOLON | R_CURLY);
    }
    false
}

/// Returns true if a body ends here without its `}`: the current token is too far to the left to be in it.
pub(super) fn is_left(p: &Parser<'_>, body: Body<'_>) -> bool {
    if !p.lacks_brace() {
        return false;
    }
    let outer = p.input.indent(body.item);
    let here = p.input.indent(p.position());
    match p.current() {
        SEMICOLON => here.is_none() || here <= outer,
        IDENT if body.fragment == Fragment::Members && p.nth_at_ts(1, AFTER_DECLARATOR) => true,
        kind if kind == R_CURLY || may_follow(p, body.fragment) => {
            let is_first = body.first == p.position();
            let inner = if is_first { None } else { p.input.indent(body.first) };
            let is_inside = |here| here > outer || here == outer && kind == R_CURLY;
            outer.is_some()
                && (inner.is_none() || inner > outer)
                && here.is_some()
                && !is_inside(here)
        }
        _ => false,
    }
}

/// Returns true if the current token may follow a body of this kind, mostly in a component.
fn may_follow(p: &Parser<'_>, fragment: Fragment) -> bool {
    match fragment {
        // Few items follow components, and their content is not always indented.
        Fragment::Component => false,
        Fragment::Properties => {
            spec::at_declaration(p)
                || p.at_ts(OF_COMPONENTS.union(SHARED)) && property::at_certain_property(p)
        }
        _ => spec::at_item(p),
    }
}

/// Returns true if the `}` here does not end the body of the component: items that only components hold
/// follow, and another `}`.
pub(super) fn is_stray(p: &Parser<'_>, fragment: Fragment) -> bool {
    fragment == Fragment::Component
        && p.has_spare_brace()
        && holds_component_items(p, p.position() + 1) == Some(true)
}

/// Returns true if a `}` follows that ends a body without a first line, before another component begins.
pub(super) fn lacks_head(p: &Parser<'_>) -> bool {
    p.has_spare_brace() && holds_component_items(p, p.position()).is_some()
}

/// Returns true if items that only components hold are between a token and the next `}` that closes nothing
/// opened here; `None` if a component begins before that `}`.
fn holds_component_items(p: &Parser<'_>, start: usize) -> Option<bool> {
    const HELD: TokenSet =
        TokenSet::new(&[IDS_KW, PORT_KW, TASK_KW, ATTRIBUTE_KW, FUNCTION_KW, ACTIVITY_KW]);
    let mut found = false;
    let ends = each_beginning(p, start, |i| {
        let word = p.input.contextual(i);
        found |= HELD.contains(word);
        !(matches!(word, COMPONENT_KW | INTERFACE_KW) && p.input.kind(i + 1) == IDENT)
    });
    ends.then_some(found)
}

/// A `}` without a partner, with the `;` after it.
pub(super) fn spare_brace(p: &mut Parser<'_>) {
    let m = p.start();
    if p.unclosed > 0 {
        p.unclosed -= 1;
        p.mark_reported();
    } else if std::mem::take(&mut p.headless) {
        p.mark_reported();
    }
    p.error_here(Parsing::ExtraBrace);
    p.bump(R_CURLY);
    p.eat(SEMICOLON);
    m.complete(p, ERROR);
}
