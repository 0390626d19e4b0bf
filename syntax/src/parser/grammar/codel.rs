//! Codels: functions of the implementation, with the states they serve.

use super::*;

/// Which codels may stand at a place.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// Without states.
    Simple,
    /// With or without.
    Any,
}

/// What follows the word `codel` or `validate`. Returns what else could follow it, for the message about
/// a missing `;`.
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
    let has_triggers = p.at(L_ANGLE) || (lacks_angles && form == Form::Any);
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
    let mut others = "";
    if p.at(YIELDS_KW) && !has_triggers {
        let extra = p.start();
        p.error_here(Parsing::YieldWithoutStates);
        yields(p);
        extra.complete(p, ERROR);
    } else if p.at(YIELDS_KW) {
        others = yields(p);
    } else if has_triggers && form == Form::Any && !p.is_reported() {
        let found = p.describe_current().into();
        p.push_error(name_at, Parsing::NoYield { found });
        if !p.at(SEMICOLON) {
            p.mark_reported();
        }
    }
    bare_wcet(p);
    wcet(p);
    m.complete(p, CODEL);
    others
}

/// Whether a codel property begins here, also where one is not expected.
pub(super) fn at_codel(p: &Parser<'_>) -> bool {
    const AFTER: TokenSet = TokenSet::new(&[L_ANGLE, IDENT]);
    p.at(CODEL_KW) && p.nth_at_ts(1, AFTER)
}

fn triggers(p: &mut Parser<'_>) {
    let m = p.start();
    if !p.eat(L_ANGLE) {
        let (state, name) = (p.current_text().into(), p.nth_text(1).into());
        p.error_here(Parsing::StatesWithoutAngles { state, name });
        state_name(p);
        m.complete(p, TRIGGERS);
        return;
    }
    comma_list(p, state);
    if !p.eat(R_ANGLE) {
        p.expected("`,` or `>`");
        // Pass what cannot be a state, as far as the `>` is near.
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
    if p.at(PAUSE_KW) && p.nth(1) == COLON2 {
        p.bump(PAUSE_KW);
        p.bump(COLON2);
    } else if p.nth(1) == COLON2 && p.nth(2) == IDENT {
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

/// Whether a name is here that is not the next declaration of half-typed text.
fn at_state(p: &Parser<'_>) -> bool {
    p.at(IDENT) && (!spec::at_item(p) || at_timed_state(p)) && !at_wcet(p)
}

/// Whether an execution time is here, `wcet 5 us`, rather than a state called `wcet`.
fn at_wcet(p: &Parser<'_>) -> bool {
    const VALUE: TokenSet = TokenSet::new(&[INT, FLOAT, L_PAREN]);
    const OPERATOR: TokenSet =
        TokenSet::new(&[STAR, SLASH, PLUS, MINUS, COLON2, S_KW, MS_KW, US_KW]);
    let of_name = p.nth(1) == IDENT && !p.nth_at(1, WCET_KW) && p.nth_at_ts(2, OPERATOR);
    p.at(WCET_KW) && (p.nth_at_ts(1, VALUE) || of_name)
}

/// A state called like the beginning of a declaration, with an execution time: `yield period 5 us`,
/// `yield codel wcet 5 us`.
fn at_timed_state(p: &Parser<'_>) -> bool {
    const NUMBER: TokenSet = TokenSet::new(&[INT, FLOAT]);
    p.nth_at(1, WCET_KW) || p.nth_at_ts(1, NUMBER)
}

/// `wcet D [unit]`, any number of times: which is one too many is said with the model at hand.
fn wcet(p: &mut Parser<'_>) {
    while p.at(WCET_KW) {
        let m = p.start();
        p.bump(WCET_KW);
        // A missing value is an error of the clause, not of the text (`wcet-value`).
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
        // Warned about with the model at hand (`wcet-bare`), together with its fix.
        m.complete(p, WCET);
    } else {
        p.error_at(at, Parsing::BareNumber);
        m.complete(p, ERROR);
    }
}
