//! Default values of parameters.

use super::*;

// test initializer
// component c {
//   function f(in s a = { 1, { .x = 2, .y = : "doc" }, [3] = { } : "more" "text" },
//              in long b = : "only a documentation",
//              in long c = -1 + 2 : "both",
//              in v d = [1] = 2, in v e = .x = 1, in v f = { [2] =, .y = });
// };
pub(super) fn initializer(p: &mut Parser<'_>) {
    let m = p.start();
    if p.at(DOT) {
        let designator = p.start();
        p.bump(DOT);
        name_ref(p);
        designator.complete(p, MEMBER_DESIGNATOR);
        designated(p);
    } else if p.at(L_BRACK) {
        let designator = p.start();
        p.bump(L_BRACK);
        expr::expr(p);
        p.expect_before(R_BRACK, AFTER_BRACKET);
        designator.complete(p, INDEX_DESIGNATOR);
        designated(p);
    } else if p.at(L_CURLY) {
        list(p);
    } else if !p.at(COLON) && !expr::expr_or(p, "a value, `{` or `:`") {
        m.abandon(p);
        return;
    }
    if p.at(COLON) {
        let doc = p.start();
        p.bump(COLON);
        strings(p);
        doc.complete(p, INITIALIZER_DOC);
    }
    m.complete(p, INITIALIZER);
}

/// `= [value]` after a designator.
fn designated(p: &mut Parser<'_>) {
    if !p.at(EQ) && p.at(DOT) {
        p.expected_because("`=`", "a member of a member is given in braces of its own");
        return;
    }
    if !p.expect(EQ) {
        return;
    }
    const NO_VALUE: TokenSet = TokenSet::new(&[COLON, COMMA, R_CURLY, R_PAREN]);
    if p.at(L_CURLY) {
        list(p);
    } else if !p.at_ts(NO_VALUE) {
        expr::expr_or(p, "a value, `{` or `:`");
    }
}

/// `{ … }`
fn list(p: &mut Parser<'_>) {
    if !p.enter() {
        return;
    }
    let m = p.start();
    p.bump(L_CURLY);
    const END: TokenSet = TokenSet::new(&[R_CURLY, R_PAREN, SEMICOLON, EOF]);
    // A comma must not come first.
    if p.eat(COMMA) && p.at(R_CURLY) && p.expected_because("a value", "remove the comma") {
        let comma = p.position() - 1;
        p.replace(comma..comma + 1, "", true);
    }
    while !p.at_ts(END) {
        initializer(p);
        if p.eat(COMMA) {
            if p.at(R_CURLY) && p.expected_because("a value", "remove the last comma") {
                let comma = p.position() - 1;
                p.replace(comma..comma + 1, "", true);
            }
            continue;
        }
        if p.at_ts(END) {
            break;
        }
        const NEXT: TokenSet = TokenSet::new(&[DOT, INT, FLOAT, STRING, L_CURLY, IDENT]);
        if p.expected("`,` or `}`") && p.at_ts(NEXT) {
            p.insert_behind(",", true);
            continue;
        }
        skip_value(p);
        if !p.eat(COMMA) && !p.at(R_CURLY) {
            p.mark_reported();
        }
    }
    p.expect(R_CURLY);
    m.complete(p, INITIALIZER_LIST);
    p.leave();
}

/// Skips the rest of a bad value, up to `,` or the end of the list.
fn skip_value(p: &mut Parser<'_>) {
    let m = p.start();
    let mut open = 0u32;
    loop {
        match p.current() {
            EOF | SEMICOLON => break,
            COMMA | R_CURLY | R_PAREN if open == 0 => break,
            L_CURLY | L_PAREN | L_BRACK => open += 1,
            R_CURLY | R_PAREN | R_BRACK => open = open.saturating_sub(1),
            _ => {}
        }
        p.bump_any();
    }
    m.complete(p, ERROR);
}
