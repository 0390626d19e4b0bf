//! Components, interfaces and the items that only they hold.

use super::*;

// test component
// component c;
// component c { };
// interface i { doc "an interface"; };
// component component { task task; port in port port; };
pub(super) fn component(p: &mut Parser<'_>) -> bool {
    if !p.at(COMPONENT_KW) && !p.at(INTERFACE_KW) {
        return false;
    }
    let m = p.start();
    let what = if p.at(INTERFACE_KW) { "this interface" } else { "this component" };
    p.bump_contextual();
    p.headless = false;
    let named = property::unless_item(p, name);
    if braces::at_body(p, Fragment::Component) {
        spec::body(p, Fragment::Component, true, what);
    } else if named && !p.at_item_end() {
        p.expected("`{` or `;`");
    }
    semicolon(p, what);
    m.complete(p, COMPONENT);
    true
}

/// Ids, tasks, ports and services.
pub(super) fn export(p: &mut Parser<'_>) -> bool {
    match p.current_contextual() {
        IDS_KW => ids(p),
        TASK_KW => task::task(p),
        PORT_KW => port(p),
        ATTRIBUTE_KW | FUNCTION_KW | ACTIVITY_KW => service::service(p),
        _ => return false,
    }
    true
}

// test ids
// component c { ids { long x; m::t y[3], z; }; };
fn ids(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(IDS_KW);
    if braces::at_body(p, Fragment::Members) {
        spec::body(p, Fragment::Members, false, "the ids");
    } else {
        p.expected("`{`");
    }
    semicolon(p, "the ids");
    m.complete(p, IDS);
}

// test port
// component c {
//   port in t p;
//   port multiple out m::t period { doc "text"; };
//   port out in in;
// };
fn port(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(PORT_KW);
    const MULTIPLE: TokenSet = TokenSet::new(&[MULTIPLE_KW]);
    const DIRECTION: TokenSet = TokenSet::new(&[IN_KW, OUT_KW]);
    if !p.at_ts(DIRECTION) {
        p.respell(MULTIPLE, |p| p.nth_at_ts(1, DIRECTION));
    }
    p.eat(MULTIPLE_KW);
    match p.current_text().as_str() {
        "input" => p.read_foreign(1, IN_KW),
        "output" => p.read_foreign(1, OUT_KW),
        _ if p.at_ts(DIRECTION) => {}
        _ => {
            p.respell(DIRECTION, |p| p.nth_at_ts(1, types::TYPE_FIRST) && !spec::at_item(p));
        }
    }
    if !p.eat(IN_KW) && !p.eat(OUT_KW) {
        p.expected("the direction of the port, `in` or `out`");
    } else {
        foreign::extra_word(p);
        if types::type_spec(p, types::AllowedTypes::Constructed) {
            types::declared_name(p);
        }
    }
    property::properties(p, "this port");
    semicolon(p, "this port");
    m.complete(p, PORT);
}
