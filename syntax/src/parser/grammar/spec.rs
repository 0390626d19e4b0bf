//! Lists of items: files, modules, bodies.

use super::*;

/// Words that always begin a declaration.
const RESERVED_STARTS: TokenSet =
    TokenSet::new(&[MODULE_KW, CONST_KW, TYPEDEF_KW, STRUCT_KW, UNION_KW, ENUM_KW]);

/// Items until the end of the file, or of the body they are in.
pub(super) fn items(p: &mut Parser<'_>, fragment: Fragment, body: Option<braces::Body<'_>>) {
    loop {
        let before = p.position();
        match (p.current(), body) {
            (EOF, _) => break,
            (_, Some(body)) if leaves_body(p, fragment) || braces::is_left(p, body) => break,
            (R_CURLY, Some(_)) if !braces::is_stray(p, fragment) => break,
            (R_CURLY, _) => braces::spare_brace(p),
            _ => item(p, fragment),
        }
        debug_assert!(p.position() > before, "no progress");
        if p.position() == before {
            p.bump_any();
        }
    }
}

/// `{ … }` around items, where [`braces::at_body`].
// test body_with_every_item
// module m { const long a = 1; };
// component c { ids { long x; }; task t; version "1"; };
pub(super) fn body(p: &mut Parser<'_>, fragment: Fragment, may_be_empty: bool, owner: &str) {
    let m = p.start();
    let body = braces::open(p, fragment, owner);
    if p.at(R_CURLY) && !may_be_empty && !p.is_after_include() {
        p.error_here(Parsing::EmptyBody { owner: owner.into() });
    }
    items(p, fragment, Some(body));
    braces::close(p, body);
    m.complete(p, BODY);
}

/// One item of any kind; consumes at least one token.
fn item(p: &mut Parser<'_>, fragment: Fragment) {
    let start = p.position();
    let around = std::mem::replace(&mut p.item, start);
    respell_first(p, fragment);
    let done = match fragment {
        Fragment::Members => types::member(p),
        Fragment::Cases => types::case(p),
        Fragment::Properties => property::property(p),
        Fragment::Module => declaration(p),
        Fragment::Specification => component::component(p) || declaration(p),
        Fragment::Component if braces::at_headless_properties(p) => headless_properties(p),
        Fragment::Component => declaration(p) || component::export(p) || property::property(p),
    };
    if !done || p.position() == start {
        bad_item(p, fragment);
    }
    p.item = around;
}

/// Reads the first word of an item as the nearest keyword.
fn respell_first(p: &mut Parser<'_>, fragment: Fragment) {
    const TOP: TokenSet = TokenSet::new(&[
        COMPONENT_KW,
        INTERFACE_KW,
        MODULE_KW,
        CONST_KW,
        TYPEDEF_KW,
        NATIVE_KW,
        EXCEPTION_KW,
        STRUCT_KW,
        UNION_KW,
        ENUM_KW,
    ]);
    const IN_COMPONENT: TokenSet =
        TokenSet::new(&[IDS_KW, TASK_KW, PORT_KW, ATTRIBUTE_KW, FUNCTION_KW, ACTIVITY_KW]);
    let keywords = match fragment {
        Fragment::Specification | Fragment::Module => TOP,
        Fragment::Component => TOP.union(IN_COMPONENT).union(property::PROPERTY_FIRST),
        Fragment::Properties => property::PROPERTY_FIRST,
        // A type begins with a name.
        Fragment::Members | Fragment::Cases => return,
    };
    if p.at_ts(keywords) {
        return;
    }
    p.respell(keywords, |p| {
        let local = p.at(LOCAL_KW) && fragment == Fragment::Properties;
        at_item(p)
            || p.at_ts(RESERVED_STARTS)
            || p.at(CODEL_KW) && p.nth(1) == L_ANGLE
            || local && p.nth_at_ts(1, types::TYPE_FIRST)
    });
}

/// Modules, constants, types: the declarations that are allowed nearly everywhere.
fn declaration(p: &mut Parser<'_>) -> bool {
    match p.current_contextual() {
        MODULE_KW => module(p),
        CONST_KW => types::const_decl(p),
        TYPEDEF_KW => types::typedef_decl(p),
        NATIVE_KW => types::native_decl(p),
        EXCEPTION_KW => types::exception_decl(p),
        STRUCT_KW | UNION_KW | ENUM_KW => types::type_decl(p),
        _ => return false,
    }
    true
}

// test module
// module m { module n { typedef long t; }; };
// module empty { };
fn module(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(MODULE_KW);
    name(p);
    if braces::at_body(p, Fragment::Module) {
        if p.enter() {
            body(p, Fragment::Module, true, "this module");
            p.leave();
        }
    } else {
        p.expected_because("`{`", "a module has a body");
    }
    semicolon(p, "this module");
    m.complete(p, MODULE);
}

/// Returns true at a token that can only begin a declaration outside the current item. Words that are also
/// identifiers count if the tokens after them fit.
pub(super) fn at_declaration(p: &Parser<'_>) -> bool {
    if p.at_ts(RESERVED_STARTS) {
        return true;
    }
    let follows = |n: usize, kinds: TokenSet| p.nth_at_ts(n, kinds);
    const NAME: TokenSet = TokenSet::new(&[IDENT]);
    const AFTER_NAME: TokenSet = TokenSet::new(&[L_CURLY, SEMICOLON]);
    const BRACE: TokenSet = TokenSet::new(&[L_CURLY]);
    const SEMICOLON_ONLY: TokenSet = TokenSet::new(&[SEMICOLON]);
    const PAREN: TokenSet = TokenSet::new(&[L_PAREN]);
    const DIRECTION: TokenSet = TokenSet::new(&[IN_KW, OUT_KW, MULTIPLE_KW]);
    const IN_PARAMS: TokenSet = TokenSet::new(&[COMMA, R_PAREN, DOT]);
    match p.current_contextual() {
        COMPONENT_KW | INTERFACE_KW | TASK_KW => follows(1, NAME) && follows(2, AFTER_NAME),
        EXCEPTION_KW => follows(1, NAME),
        NATIVE_KW => follows(1, NAME) && follows(2, SEMICOLON_ONLY),
        IDS_KW => follows(1, BRACE),
        ATTRIBUTE_KW | FUNCTION_KW | ACTIVITY_KW => follows(1, NAME) && follows(2, PAREN),
        // `port in NAME,` is a parameter of a codel.
        PORT_KW => follows(1, DIRECTION) && !(follows(2, NAME) && follows(3, IN_PARAMS)),
        _ => false,
    }
}

/// Returns true if a declaration or property certainly begins here: broken text ends before it.
pub(super) fn at_item(p: &Parser<'_>) -> bool {
    at_declaration(p) || property::at_certain_property(p)
}

/// Returns true if the item that begins here cannot belong to the current body, so that its `}` must be
/// missing.
fn leaves_body(p: &Parser<'_>, fragment: Fragment) -> bool {
    const NAME: TokenSet = TokenSet::new(&[IDENT]);
    const NAMED_BLOCK: TokenSet = TokenSet::new(&[L_CURLY]);
    let component = p.at_ts(TokenSet::new(&[COMPONENT_KW, INTERFACE_KW]))
        && p.nth_at_ts(1, NAME)
        && p.nth_at_ts(2, NAMED_BLOCK);
    match fragment {
        Fragment::Specification => false,
        Fragment::Module | Fragment::Component => component,
        Fragment::Members => {
            component
                || p.at_ts(TokenSet::new(&[MODULE_KW, CONST_KW, TYPEDEF_KW]))
                || (at_declaration(p)
                    && !p.at_ts(RESERVED_STARTS)
                    && !p.nth_at_ts(2, TokenSet::new(&[SEMICOLON])))
        }
        Fragment::Cases => at_declaration(p),
        Fragment::Properties => {
            // `task t;` is the property of a service.
            at_declaration(p) && !(p.at(TASK_KW) && p.nth_at_ts(2, TokenSet::new(&[SEMICOLON])))
        }
    }
}

/// An item that is not allowed here. A declaration that belongs elsewhere is parsed, so that its content is
/// not reported as well.
fn bad_item(p: &mut Parser<'_>, fragment: Fragment) {
    let m = p.start();
    if p.at(SEMICOLON) {
        let at = p.position();
        p.error_here(Parsing::ExtraSemicolon);
        p.replace(at..at + 1, "", true);
        p.bump(SEMICOLON);
        m.complete(p, ERROR);
        return;
    }
    if foreign::line(p) {
        m.complete(p, ERROR);
        return;
    }
    let (what, help) = match fragment {
        Fragment::Specification => (
            "a component, interface, module, constant or type",
            "declarations begin with a keyword such as `component` or `typedef`",
        ),
        Fragment::Module => ("a module, constant or type", "components stand outside modules"),
        Fragment::Component => (
            "a declaration or property of a component",
            "such as `ids`, `task`, `port`, `function`, `activity` or `doc`",
        ),
        Fragment::Members => ("a member", "write `TYPE NAME;`"),
        Fragment::Cases => ("`case` or `default`", "write `case VALUE: TYPE NAME;`"),
        Fragment::Properties => ("a property", "such as `doc`, `period`, `codel` or `validate`"),
    };
    let known = at_declaration(p) || property::at_property(p);
    let outside = known && matches!(fragment, Fragment::Specification | Fragment::Module);
    let member = fragment == Fragment::Component && p.at_ts(types::TYPE_FIRST);
    if outside || member {
        // The line with the `{` of the body may be missing: this is reported once.
        if p.headless {
            p.mark_reported();
        } else {
            p.headless = fragment != Fragment::Module && braces::lacks_head(p);
        }
    }
    if outside {
        let word = p.current_text().into();
        p.error_here(if p.headless {
            Parsing::HeadlessComponent { word, expected: what }
        } else {
            Parsing::Outside { word, expected: what }
        });
        if !(component::component(p) || component::export(p) || property::property(p)) {
            skip_tokens(p);
        }
    } else {
        let help = if member && p.headless {
            "members stand in `ids`, a struct or an exception: is the line with its `{` missing?"
        } else {
            help
        };
        p.expected_because(what, help);
        skip_tokens(p);
    }
    m.complete(p, ERROR);
}

/// The properties of a task or service whose first line is missing, with their `}`.
fn headless_properties(p: &mut Parser<'_>) -> bool {
    let m = p.start();
    let word = p.current_text().into();
    p.error_here(Parsing::HeadlessProperties { word });
    body(p, Fragment::Properties, true, "this task or service");
    p.eat(SEMICOLON);
    m.complete(p, ERROR);
    true
}

/// Skips the rest of a broken declaration, with its `;`.
pub(super) fn skip_to_semicolon(p: &mut Parser<'_>) {
    let m = p.start();
    skip_tokens(p);
    m.complete(p, ERROR);
}

/// Skips at least one token, up to and including the next `;`, or up to a `}` or declaration. Blocks in
/// braces are skipped whole unless a component begins inside.
fn skip_tokens(p: &mut Parser<'_>) {
    let mut open = 0u32;
    let mut first = true;
    loop {
        const AFTER_TEXT: TokenSet =
            TokenSet::new(&[SEMICOLON, COMMA, COLON, R_PAREN, R_CURLY, STRING, EOF]);
        if !first && p.is_after_long_literal() && !p.at_ts(AFTER_TEXT) {
            p.mark_exchanged();
        }
        if !first && (open == 0 && at_item(p) || leaves_body(p, Fragment::Module)) {
            return;
        }
        match p.current() {
            EOF => return,
            L_CURLY => open += 1,
            R_CURLY if open == 0 => return,
            R_CURLY => open -= 1,
            SEMICOLON if open == 0 => {
                p.bump_any();
                return;
            }
            _ => {}
        }
        p.bump_any();
        first = false;
    }
}
