//! Codels: functions of the implementation, with the states they serve.

use super::*;

/// The forms of codels that a place allows.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// Without states.
    Simple,
    /// With or without states.
    Any,
}

/// The rest of a codel after the word `codel` or `validate`. Returns the tokens that could also follow it,
/// for the message about a missing `;`.
// test codel
// component c {
//   activity a() {
//     validate v(in x) wcet 3 us;
//     codel simple();
//     codel<start, step> f(in x) yield pause::step, ether;
//     codel<ether> g() wcet N * 2 ms yields ether;
//     codel<stop> h() yield wcet wcet 1.5 ms;
//     async codel<other> i() yield ether wcet 26us;
//   };
// };
pub(super) fn codel(p: &mut Parser<'_>, form: Form) -> &'static str {
    let m = p.start();
    // `codel start f()`
    let lacks_angles = p.at(IDENT) && p.nth(1) == IDENT && p.nth(2) == L_PAREN;
    let has_triggers =
        p.at(L_ANGLE) || p.at(L_BRACK) && p.nth(1) == IDENT || (lacks_angles && form == Form::Any);
    if has_triggers {
        if form == Form::Simple {
            p.error_here(Parsing::ValidateWithStates);
        }
        triggers(p);
    }
    let name_at = p.position();
    if !property::unless_item(p, name) {
        m.complete_unless_empty(p, has_triggers, CODEL);
        return "";
    }
    param::param_list(p, param::Params::Codel);
    wcet(p);
    const AFTER_STATE: TokenSet = TokenSet::new(&[COMMA, SEMICOLON, WCET_KW]);
    const YIELD: TokenSet = TokenSet::new(&[YIELDS_KW]);
    p.respell(YIELD, |p| p.nth(1) == IDENT);
    let mut others = "";
    if p.at(YIELDS_KW) && !has_triggers {
        let extra = p.start();
        if p.error_here(Parsing::YieldWithoutStates) && form == Form::Any {
            let name = p.nth_text_at(name_at);
            p.replace(name_at..name_at + 1, &format!("<start> {name}"), false);
        }
        yields(p);
        extra.complete(p, ERROR);
    } else if p.at(YIELDS_KW) {
        others = yields(p);
    } else if has_triggers && form == Form::Any && !p.is_reported() {
        let found = p.describe_current().into();
        let lists = p.at(IDENT) && p.nth_at_ts(1, AFTER_STATE) && !spec::at_item(p);
        p.push_error(if lists { p.position() } else { name_at }, Parsing::NoYield { found });
        if p.at(SEMICOLON) {
            p.insert_behind(" yield ether", false);
        } else if lists {
            p.insert_before("yield ", false);
        }
        if !p.at(SEMICOLON) {
            p.mark_reported();
        }
    }
    bare_wcet(p);
    if p.at(WCET_KW) {
        others = "";
    }
    wcet(p);
    m.complete(p, CODEL);
    others
}

/// Returns true if a codel property begins here, even where none is expected.
pub(super) fn at_codel(p: &Parser<'_>) -> bool {
    const AFTER: TokenSet = TokenSet::new(&[L_ANGLE, IDENT]);
    p.at(CODEL_KW) && p.nth_at_ts(1, AFTER)
}

fn triggers(p: &mut Parser<'_>) {
    let m = p.start();
    if p.at(L_BRACK) {
        let at = p.position();
        p.bump(L_BRACK);
        comma_list(p, state);
        if p.error_at(at, Parsing::ForeignSign { found: "`[`".into(), sign: "<" }) && p.at(R_BRACK)
        {
            let end = p.position();
            let text = format!("<{}>", p.source(at + 1..end));
            p.replace(at..end + 1, &text, true);
            p.bump(R_BRACK);
        }
        m.complete(p, TRIGGERS);
        return;
    }
    if !p.eat(L_ANGLE) {
        let (state, name) = (p.current_text().into(), p.nth_text(1).into());
        if p.error_here(Parsing::StatesWithoutAngles { state, name }) {
            let (at, text) = (p.position(), format!("<{}>", p.current_text()));
            p.replace(at..at + 1, &text, false);
        }
        state_name(p);
        m.complete(p, TRIGGERS);
        return;
    }
    comma_list(p, state);
    if !p.eat(R_ANGLE) {
        if p.expected("`,` or `>`") && p.at(IDENT) {
            const GOES_ON: TokenSet = TokenSet::new(&[COMMA, R_ANGLE]);
            match p.nth(1) {
                L_PAREN => p.insert_behind(">", true),
                _ if p.nth_at_ts(1, GOES_ON) => p.insert_behind(",", true),
                _ => {}
            }
        }
        // Skip tokens that cannot be a state, if the `>` is near.
        if !p.at(IDENT) && !p.at_item_end() && !p.at(L_PAREN) {
            let bad = p.start();
            while !p.at(R_ANGLE) && !p.at_item_end() && !p.at(L_PAREN) {
                p.bump_any();
            }
            bad.complete(p, ERROR);
            p.eat(R_ANGLE);
        }
    }
    m.complete(p, TRIGGERS);
}

/// A state as a bare word.
fn state_name(p: &mut Parser<'_>) {
    let m = p.start();
    name_ref(p);
    m.complete(p, STATE);
}

fn yields(p: &mut Parser<'_>) -> &'static str {
    let m = p.start();
    p.bump(YIELDS_KW);
    comma_list(p, state);
    m.complete(p, YIELDS);
    " (or `,` and another state)"
}

// test state
// component c { task t { codel<pause, pause::pause> f() yield pause::wcet, pause, yield; }; };
fn state(p: &mut Parser<'_>) -> bool {
    if !at_state(p) {
        p.expected("the name of a state");
        return false;
    }
    let m = p.start();
    const PAUSE: TokenSet = TokenSet::new(&[PAUSE_KW]);
    if !p.at(PAUSE_KW) && p.nth(1) == COLON2 {
        p.respell(PAUSE, |p| p.nth(2) == IDENT);
    }
    if p.at(PAUSE_KW) && p.nth(1) == COLON2 {
        p.bump(PAUSE_KW);
        p.bump(COLON2);
    } else if p.at(PAUSE_KW) && matches!(p.nth(1), DOT | COLON) && p.nth(2) == IDENT {
        p.bump(PAUSE_KW);
        let _ = joined_by_other(p, DOT) || joined_by_other(p, COLON);
    } else if !foreign::pause_and_state(p) && p.nth(1) == COLON2 && p.nth(2) == IDENT {
        let word = p.current_text().into();
        p.error_here(Parsing::QualifiedState { word });
        let bad = p.start();
        p.bump_any();
        p.bump(COLON2);
        bad.complete(p, ERROR);
    }
    if at_state(p) {
        name_ref(p);
    } else {
        p.expected("the name of a state");
    }
    m.complete(p, STATE);
    true
}

/// Returns true at a name that is not the next declaration of incomplete text.
fn at_state(p: &Parser<'_>) -> bool {
    p.at(IDENT) && (!spec::at_item(p) || at_timed_state(p)) && !at_wcet(p)
}

/// Returns true at an execution time, `wcet 5 us`, not at a state called `wcet`.
fn at_wcet(p: &Parser<'_>) -> bool {
    const VALUE: TokenSet = TokenSet::new(&[INT, FLOAT, L_PAREN]);
    const OPERATOR: TokenSet =
        TokenSet::new(&[STAR, SLASH, PLUS, MINUS, COLON2, S_KW, MS_KW, US_KW]);
    let of_name = p.nth(1) == IDENT && !p.nth_at(1, WCET_KW) && p.nth_at_ts(2, OPERATOR);
    p.at(WCET_KW) && (p.nth_at_ts(1, VALUE) || of_name)
}

/// Returns true at a state that is named like the beginning of a declaration, with an execution time:
/// `yield period 5 us`, `yield codel wcet 5 us`.
fn at_timed_state(p: &Parser<'_>) -> bool {
    const NUMBER: TokenSet = TokenSet::new(&[INT, FLOAT]);
    p.nth_at(1, WCET_KW) || p.nth_at_ts(1, NUMBER)
}

/// `wcet D [unit]`, any number of times: repeated ones are reported later, by the model.
fn wcet(p: &mut Parser<'_>) {
    const WORD: TokenSet = TokenSet::new(&[WCET_KW]);
    const NUMBER: TokenSet = TokenSet::new(&[INT, FLOAT]);
    p.respell(WORD, |p| p.nth_at_ts(1, NUMBER));
    while p.at(WCET_KW) {
        let m = p.start();
        p.bump(WCET_KW);
        // A missing value is an error of the clause (`wcet-value`), not of the syntax.
        if !p.at(SEMICOLON) && !p.at(YIELDS_KW) {
            property::quantity(p, property::TIME_UNITS);
        }
        m.complete(p, WCET);
    }
}

/// A duration after the yield list without the word `wcet`.
// test bare_wcet
// component c { task t { codel<start> f() yield ether 2487us; }; };
fn bare_wcet(p: &mut Parser<'_>) {
    if !p.at(INT) && !p.at(FLOAT) {
        return;
    }
    let at = p.position();
    let m = p.start();
    if property::quantity(p, property::TIME_UNITS) {
        // The model warns about it (`wcet-bare`), with its fix.
        m.complete(p, WCET);
    } else {
        p.error_at(at, Parsing::BareNumber);
        m.complete(p, ERROR);
    }
}
