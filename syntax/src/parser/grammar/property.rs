//! Properties of components, tasks, ports and services. In the grammar any property may be in any list.

use super::*;

/// Words that begin a property. `local` and `task` depend on the token after them.
pub(super) const PROPERTY_FIRST: TokenSet = TokenSet::new(&[
    DOC_KW,
    VERSION_KW,
    LANG_KW,
    EMAIL_KW,
    REQUIRES_KW,
    CODELS_REQUIRES_KW,
    CLOCK_RATE_KW,
    PROVIDES_KW,
    USES_KW,
    EXTENDS_KW,
    THROWS_KW,
    PERIOD_KW,
    DELAY_KW,
    PRIORITY_KW,
    SCHEDULING_KW,
    STACK_KW,
    TASK_KW,
    INTERRUPTS_KW,
    BEFORE_KW,
    AFTER_KW,
    VALIDATE_KW,
    LOCAL_KW,
    ASYNC_KW,
    CODEL_KW,
]);

/// Units of durations.
pub(super) const TIME_UNITS: TokenSet = TokenSet::new(&[S_KW, MS_KW, US_KW]);
/// Units of stack sizes.
const SIZE_UNITS: TokenSet = TokenSet::new(&[K_KW, M_KW]);

pub(super) fn at_property(p: &Parser<'_>) -> bool {
    p.at_ts(PROPERTY_FIRST)
}

/// Returns true at an item that can only be a property, given the token after its keyword. Broken text is
/// skipped up to it.
pub(super) fn at_certain_property(p: &Parser<'_>) -> bool {
    const NAME: TokenSet = TokenSet::new(&[IDENT]);
    const TEXT: TokenSet = TokenSet::new(&[STRING, OPEN_STRING]);
    const NUMBER: TokenSet = TokenSet::new(&[INT, FLOAT]);
    const LIST: TokenSet = TokenSet::new(&[COMMA, SEMICOLON]);
    const DECLARATOR: TokenSet = TokenSet::new(&[COMMA, SEMICOLON, L_BRACK]);
    match p.current_contextual() {
        CODEL_KW => codel::at_codel(p),
        ASYNC_KW => p.nth_at(1, CODEL_KW),
        VALIDATE_KW => p.nth_at_ts(1, NAME) && p.nth_at(2, L_PAREN),
        SCHEDULING_KW => p.nth_at(1, REAL_TIME_KW),
        // `local in x` is a parameter of a codel.
        LOCAL_KW if p.nth_at_ts(1, param::DIRECTION) => false,
        LOCAL_KW if p.nth(1) == IDENT => {
            p.nth(2) == COLON2 || p.nth(2) == IDENT && p.nth_at_ts(3, DECLARATOR)
        }
        LOCAL_KW => p.nth_at_ts(1, types::TYPE_FIRST) && p.nth(1) != COLON2,
        DOC_KW | VERSION_KW | LANG_KW | EMAIL_KW | REQUIRES_KW | CODELS_REQUIRES_KW => {
            p.nth_at_ts(1, TEXT)
        }
        PERIOD_KW | DELAY_KW | CLOCK_RATE_KW | PRIORITY_KW | STACK_KW => p.nth_at_ts(1, NUMBER),
        THROWS_KW | PROVIDES_KW | USES_KW | EXTENDS_KW | INTERRUPTS_KW | BEFORE_KW | AFTER_KW
        | TASK_KW => p.nth_at_ts(1, NAME) && p.nth_at_ts(2, LIST),
        _ => false,
    }
}

/// Returns true at the properties of a port, behind the `{`.
pub(super) fn at_body(p: &Parser<'_>, n: usize) -> bool {
    p.nth_at(n, R_CURLY) || p.nth_at_ts(n, PROPERTY_FIRST)
}

/// A name in a list of a property. In incomplete text the next declaration may follow instead: its words
/// could be names, but not with the tokens after them.
fn reference(p: &mut Parser<'_>) -> bool {
    unless_item(p, name_ref)
}

/// Like `reference`, for `[::]a::b`.
fn qualified(p: &mut Parser<'_>) -> bool {
    unless_item(p, path)
}

/// Reads one element, unless the next declaration begins here.
pub(super) fn unless_item(p: &mut Parser<'_>, one: fn(&mut Parser<'_>) -> bool) -> bool {
    if spec::at_item(p) {
        p.expected("a name");
        return false;
    }
    one(p)
}

/// `{ … }`, if present.
pub(super) fn properties(p: &mut Parser<'_>, owner: &str) {
    if braces::at_body(p, Fragment::Properties) {
        spec::body(p, Fragment::Properties, true, owner);
    }
}

/// A property, if one begins here.
// test property
// component c {
//   doc "a" "b"; version "1"; lang "c"; email "x@y";
//   require "p >= 1", "q"; requires "r"; codels-require "s"; codels-requires "t";
//   clock-rate 1 ms; provides i, j; use k; extend l;
//   throw e, ::m::f;
//   task t { period 5; delay 0.5 s; priority 10; scheduling real-time; stack 4 k; stack 1M; };
//   activity a() {
//     task t; interrupts a, all; before b; after c;
//     validate v(in x); local long l, m[2];
//     codel f(in x); async codel<start, main> g(in x) yields pause::main, ether;
//   };
// };
pub(super) fn property(p: &mut Parser<'_>) -> bool {
    if !at_property(p) {
        return false;
    }
    let m = p.start();
    let word = p.current_text();
    let what = format!("the property `{word}`");
    let mut others = "";
    let keyword = p.current_contextual();
    if keyword == ASYNC_KW {
        async_codel(p, m);
        return true;
    }
    p.bump(keyword);
    let kind = match keyword {
        DOC_KW | VERSION_KW | LANG_KW | EMAIL_KW => {
            strings(p);
            STRING_PROPERTY
        }
        REQUIRES_KW | CODELS_REQUIRES_KW => {
            comma_list(p, strings);
            REQUIRES_PROPERTY
        }
        CLOCK_RATE_KW | PERIOD_KW | DELAY_KW => {
            if !quantity(p, TIME_UNITS) {
                others = " (or a unit: `s`, `ms` or `us`)";
            }
            DURATION_PROPERTY
        }
        PROVIDES_KW | USES_KW | EXTENDS_KW => {
            comma_list(p, reference);
            INTERFACES_PROPERTY
        }
        THROWS_KW => {
            comma_list(p, qualified);
            THROWS_PROPERTY
        }
        PRIORITY_KW => {
            expr::expr(p);
            PRIORITY_PROPERTY
        }
        SCHEDULING_KW => {
            if !p.eat(REAL_TIME_KW) {
                p.expected("`real-time`");
            }
            SCHEDULING_PROPERTY
        }
        STACK_KW => {
            if !quantity(p, SIZE_UNITS) {
                others = " (or a unit: `k` or `M`)";
            }
            STACK_PROPERTY
        }
        TASK_KW => {
            reference(p);
            TASK_PROPERTY
        }
        INTERRUPTS_KW | BEFORE_KW | AFTER_KW => {
            comma_list(p, reference);
            SERVICES_PROPERTY
        }
        VALIDATE_KW => {
            others = codel::codel(p, codel::Form::Simple);
            VALIDATE_PROPERTY
        }
        LOCAL_KW => {
            if types::type_spec(p, types::AllowedTypes::Constructed) {
                comma_list(p, types::declarator);
            }
            LOCAL_PROPERTY
        }
        _ => {
            others = codel::codel(p, codel::Form::Any);
            CODEL_PROPERTY
        }
    };
    semicolon_or(p, &what, others);
    m.complete(p, kind);
    true
}

fn async_codel(p: &mut Parser<'_>, m: Marker) {
    p.bump(ASYNC_KW);
    let mut others = "";
    const CODEL: TokenSet = TokenSet::new(&[CODEL_KW]);
    p.respell(CODEL, codel::at_codel);
    if p.eat(CODEL_KW) {
        others = codel::codel(p, codel::Form::Any);
    } else {
        p.expected_because("`codel`", "only codels are asynchronous");
    }
    semicolon_or(p, "this codel", others);
    m.complete(p, CODEL_PROPERTY);
}

/// A number with an optional unit. Returns true if it has a unit.
pub(super) fn quantity(p: &mut Parser<'_>, units: TokenSet) -> bool {
    let m = p.start();
    // In incomplete text the next declaration may follow.
    if spec::at_item(p) && !p.nth_at_ts(1, units) {
        p.expected("a number");
        m.abandon(p);
        return false;
    }
    if !expr::expr_or(p, "a number") {
        m.abandon(p);
        return false;
    }
    let unit = p.at_ts(units);
    if unit {
        p.bump_contextual();
    } else if units.contains(MS_KW) {
        foreign_unit(p);
    }
    m.complete(p, QUANTITY);
    unit
}

/// A word after a number that is not a unit of time but clearly stands for one.
fn foreign_unit(p: &mut Parser<'_>) {
    const AFTER: TokenSet = TokenSet::new(&[SEMICOLON, YIELDS_KW]);
    if !p.at(IDENT) || !p.nth_at_ts(1, AFTER) || p.is_reported() {
        return;
    }
    let at = p.position();
    let word = p.current_text();
    let factor = match word.to_ascii_lowercase().as_str() {
        "hz" | "hertz" => Some(1.0),
        "khz" => Some(1e3),
        "mhz" => Some(1e6),
        _ => None,
    };
    let unit = match word.to_ascii_lowercase().as_str() {
        "sec" | "secs" | "second" | "seconds" => Some("s"),
        "msec" | "msecs" | "millis" | "millisecond" | "milliseconds" => Some("ms"),
        "usec" | "usecs" | "micros" | "microsecond" | "microseconds" => Some("us"),
        _ if word.eq_ignore_ascii_case("s") => Some("s"),
        _ if word.eq_ignore_ascii_case("ms") => Some("ms"),
        _ if word.eq_ignore_ascii_case("us") => Some("us"),
        _ => None,
    };
    let word = word.into();
    if let Some(factor) = factor {
        p.error_here(Parsing::Frequency { word });
        // The rate in whole microseconds, at least one, if the number is written here.
        let rate = p.nth_text_at(at - 1).parse::<f64>().ok();
        let time = rate.filter(|rate| *rate > 0.0).map(|rate| 1e6 / (rate * factor));
        if let Some(time) = time.filter(|time| time.fract() == 0.0) {
            let text = match time {
                _ if time % 1e6 == 0.0 => format!("{} s", time / 1e6),
                _ if time % 1e3 == 0.0 => format!("{} ms", time / 1e3),
                _ => format!("{time} us"),
            };
            p.replace(at - 1..at + 1, &text, true);
        }
    } else if let Some(unit) = unit {
        p.error_here(Parsing::NoUnit { word });
        p.replace(at..at + 1, unit, true);
    } else {
        return;
    }
    let bad = p.start();
    p.bump_any();
    bad.complete(p, ERROR);
}
