//! Parameters of services and codels.

use super::*;

/// The kinds of parameter lists.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Params {
    /// Paths into the ids, with default values.
    Attribute,
    /// Typed, with default values.
    Service,
    /// Paths with a source.
    Codel,
}

pub(super) const DIRECTION: TokenSet = TokenSet::new(&[IN_KW, OUT_KW, INOUT_KW]);
const SOURCE: TokenSet = TokenSet::new(&[IDS_KW, LOCAL_KW, PORT_KW, REMOTE_KW]);

/// The tokens that end a list of parameters without its `)`.
const LIST_END: TokenSet = TokenSet::new(&[R_PAREN, L_CURLY, R_CURLY, SEMICOLON, EOF]);

/// `( … )`. A bad parameter is skipped up to the next `,` or `)`.
pub(super) fn param_list(p: &mut Parser<'_>, params: Params) {
    if !p.at(L_PAREN) {
        const FOLLOWERS: TokenSet = TokenSet::new(&[L_CURLY, SEMICOLON, YIELDS_KW]);
        if p.expected("`(`") && p.at_ts(FOLLOWERS) {
            p.insert_behind("()", false);
        }
        return;
    }
    let m = p.start();
    p.bump(L_PAREN);
    while !at_list_end(p, params) {
        param(p, params);
        if p.at(COMMA) {
            p.bump(COMMA);
            if at_list_end(p, params) && p.expected("a parameter") && p.at(R_PAREN) {
                let comma = p.position() - 1;
                p.replace(comma..comma + 1, "", true);
            }
            continue;
        }
        if at_list_end(p, params) {
            break;
        }
        let reported = p.expected("`,` or `)`");
        if reported && (p.at_ts(DIRECTION) || p.at_ts(SOURCE) && p.nth_at_ts(1, DIRECTION)) {
            p.insert_behind(",", true);
            continue;
        }
        skip_param(p, params);
        if !p.eat(COMMA) && !p.at(R_PAREN) {
            p.mark_reported();
        }
    }
    const FOLLOWERS: TokenSet = TokenSet::new(&[L_CURLY, SEMICOLON, YIELDS_KW, WCET_KW]);
    p.expect_before(R_PAREN, FOLLOWERS);
    m.complete(p, PARAM_LIST);
}

fn at_list_end(p: &Parser<'_>, params: Params) -> bool {
    p.at_ts(LIST_END)
        || params == Params::Codel && p.at(YIELDS_KW)
        || !p.at(PORT_KW) && spec::at_declaration(p)
        || property::at_certain_property(p)
}

/// Skips the rest of a bad parameter, up to `,` or the end of the list.
fn skip_param(p: &mut Parser<'_>, params: Params) {
    let m = p.start();
    let mut open = 0u32;
    loop {
        match p.current() {
            EOF | SEMICOLON | L_CURLY | R_CURLY => break,
            L_PAREN | L_BRACK => open += 1,
            R_PAREN | COMMA if open == 0 => break,
            R_PAREN | R_BRACK => open = open.saturating_sub(1),
            _ if open == 0 && at_list_end(p, params) => break,
            _ => {}
        }
        p.bump_any();
    }
    m.complete(p, ERROR);
}

fn param(p: &mut Parser<'_>, params: Params) {
    match params {
        Params::Service => typed_param(p),
        Params::Attribute | Params::Codel => path_param(p, params),
    }
}

// test typed_param
// component c { function f(in long a = 1 : "text", out t b[2], inout string<8> c = : "text"); };
fn typed_param(p: &mut Parser<'_>) {
    p.respell(DIRECTION, |p| p.nth_at_ts(1, types::TYPE_FIRST) && p.nth(2) != COMMA);
    if !p.at_ts(DIRECTION) && types::begins_param(p) {
        // A type before the name, as in C.
        if p.expected("the direction of a parameter, `in`, `out` or `inout`") {
            p.insert_before("in ", false);
        }
        let m = p.start();
        if types::type_spec(p, types::AllowedTypes::Constructed) && types::declarator(p) {
            default_value(p);
        }
        m.complete(p, ERROR);
        return;
    }
    if !p.at_ts(DIRECTION) {
        p.expected("the direction of a parameter, `in`, `out` or `inout`");
        return;
    }
    let m = p.start();
    p.bump_contextual();
    if types::type_spec(p, types::AllowedTypes::Constructed) && types::declarator(p) {
        default_value(p);
    }
    m.complete(p, TYPED_PARAM);
}

// test path_param
// component c {
//   attribute a(in x, out v.y[2]::z = 3, inout ::whole);
//   activity b() {
//     codel<start> f(in x, ids in v.y::z, local out t, port in p, remote inout r, ids in ::w)
//       yield ether;
//     codel<ether> g(in in, in port, port in local) yield ether;
//   };
// };
fn path_param(p: &mut Parser<'_>, params: Params) {
    if !p.at_ts(DIRECTION.union(SOURCE)) {
        const NAME: TokenSet = TokenSet::new(&[IDENT, COLON2]);
        let _ = p.respell(SOURCE, |p| p.nth_at_ts(1, DIRECTION) && p.nth(2) == IDENT)
            || p.respell(DIRECTION, |p| p.nth_at_ts(1, NAME));
    }
    let source = p.at_ts(SOURCE);
    if !source && !p.at_ts(DIRECTION) {
        p.expected("the direction of a parameter, `in`, `out` or `inout`");
        return;
    }
    let m = p.start();
    if source {
        if params == Params::Attribute {
            p.error_here(Parsing::AttributeSource);
        }
        p.bump_contextual();
        if !p.at_ts(DIRECTION) {
            p.respell(DIRECTION, |p| p.nth(1) == IDENT);
        }
        if !p.at_ts(DIRECTION) {
            p.expected("the direction of the parameter, `in`, `out` or `inout`, after its source");
            m.complete(p, ERROR);
            return;
        }
    }
    p.bump_contextual();
    let swapped = !source && p.at_ts(SOURCE) && p.nth(1) == IDENT;
    if p.at(IDENT) && !codel::at_codel(p) {
        param_path(p);
        if swapped {
            p.expected_because(
                "`,` or `)`",
                "the source stands before the direction: `port in NAME`",
            );
        }
    } else if !p.at(COLON2) {
        p.expected("the name of what the parameter gives access to");
    }
    if p.at(COLON2) {
        let rename = p.start();
        p.bump(COLON2);
        name(p);
        rename.complete(p, RENAME);
    }
    if params == Params::Attribute {
        default_value(p);
    } else if p.at(EQ) {
        p.error_here(Parsing::CodelDefault);
    }
    m.complete(p, PATH_PARAM);
}

fn param_path(p: &mut Parser<'_>) {
    let m = p.start();
    let first = p.start();
    name_ref(p);
    first.complete(p, MEMBER_STEP);
    loop {
        let step = p.start();
        if p.eat(DOT) || foreign::arrow(p) {
            name_ref(p);
            step.complete(p, MEMBER_STEP);
        } else if p.eat(L_BRACK) {
            expr::expr(p);
            p.expect_before(R_BRACK, AFTER_BRACKET);
            step.complete(p, INDEX_STEP);
        } else {
            step.abandon(p);
            break;
        }
    }
    m.complete(p, PARAM_PATH);
}

fn default_value(p: &mut Parser<'_>) {
    if p.eat(EQ) {
        initializer::initializer(p);
    } else if p.at(COLON) {
        p.expected_because("`,` or `)`", "write `= : \"…\"` for a documentation without a value");
    }
}
