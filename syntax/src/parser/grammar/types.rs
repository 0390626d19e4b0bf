//! Constants, types, exceptions.

use super::*;

// test const_decl
// const unsigned long a = 1;
// const string<8> s = "x" "y";
// const m::t b = ::m::c;
pub(super) fn const_decl(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(CONST_KW);
    const UNFIT: TokenSet =
        TokenSet::new(&[ANY_KW, SEQUENCE_KW, OPTIONAL_KW, FIXED_KW, STRUCT_KW, UNION_KW, ENUM_KW]);
    if p.at_ts(UNFIT) {
        unfit_type(p, Parsing::UnfitConstant);
    } else if p.at(IDENT) && p.nth(1) == EQ {
        p.expected_because("the type of the constant", "write `const TYPE NAME = VALUE;`");
        let ty = match p.nth(2) {
            INT => "long ",
            FLOAT => "double ",
            STRING => "string ",
            TRUE_KW | FALSE_KW => "boolean ",
            _ => "",
        };
        if !ty.is_empty() {
            p.insert_before(ty, false);
        }
    } else {
        type_spec(p, AllowedTypes::Simple);
    }
    if name(p) {
        if p.eat(EQ) {
            expr::expr(p);
        } else {
            p.expected_because("`=`", "a constant needs a value");
        }
    }
    semicolon(p, "this constant");
    m.complete(p, CONST_DECL);
}

// test typedef_decl
// typedef long t, u[3], v[2][N + 1];
// typedef struct s { long x; } w;
pub(super) fn typedef_decl(p: &mut Parser<'_>) {
    let m = p.start();
    let typedef = p.position();
    p.bump(TYPEDEF_KW);
    foreign::anonymous(p, typedef);
    let block = p.at_ts(BLOCKS);
    let found = type_spec(p, AllowedTypes::Constructed);
    if found && block && p.at(SEMICOLON) && !p.is_reported() {
        p.push_error(typedef, Parsing::NoNewName);
        p.replace(typedef..typedef + 1, "", true);
    } else if found {
        comma_list(p, declarator);
    }
    semicolon(p, "this typedef");
    m.complete(p, TYPEDEF_DECL);
}

// test native_decl
// native n;
// native native;
pub(super) fn native_decl(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(NATIVE_KW);
    name(p);
    semicolon(p, "this native type");
    m.complete(p, NATIVE_DECL);
}

// test exception_decl
// exception a, b { long code; }, c { };
pub(super) fn exception_decl(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(EXCEPTION_KW);
    comma_list(p, |p| {
        let m = p.start();
        if !name(p) {
            m.abandon(p);
            return false;
        }
        if braces::at_body(p, Fragment::Members) {
            spec::body(p, Fragment::Members, true, "this exception");
        }
        m.complete(p, EXCEPTION);
        true
    });
    semicolon(p, "this exception");
    m.complete(p, EXCEPTION_DECL);
}

// test type_decl
// struct s;
// union u;
// struct s { long x; };
// union u switch (long) { case 1: long x; };
// enum e { A, B };
pub(super) fn type_decl(p: &mut Parser<'_>) {
    let m = p.start();
    if (p.at(STRUCT_KW) || p.at(UNION_KW)) && p.nth(1) == IDENT && p.nth(2) == SEMICOLON {
        p.bump_any();
        name(p);
        p.bump(SEMICOLON);
        m.complete(p, FORWARD_DECL);
        return;
    }
    let what = match p.current() {
        STRUCT_KW => "this struct",
        UNION_KW => "this union",
        _ => "this enum",
    };
    type_spec(p, AllowedTypes::Constructed);
    semicolon(p, what);
    m.complete(p, TYPE_DECL);
}

/// A member of a struct, an exception or ids.
// test member
// struct s { long a, b[2]; sequence<t, 3> c; struct n { port port; } d; };
pub(super) fn member(p: &mut Parser<'_>) -> bool {
    if !p.at_ts(TYPE_FIRST) {
        return false;
    }
    let m = p.start();
    if type_spec(p, AllowedTypes::Constructed) {
        comma_list(p, declarator);
    }
    semicolon(p, "this member");
    m.complete(p, MEMBER);
    true
}

/// A case of a union.
// test case
// union u switch (e) { case A: case m::B: long x; default: sequence<long> y[2]; };
pub(super) fn case(p: &mut Parser<'_>) -> bool {
    const LABELS: TokenSet = TokenSet::new(&[CASE_KW, DEFAULT_KW]);
    p.respell(LABELS, |p| if p.at(DEFAULT_KW) { p.nth(1) == COLON } else { p.nth(2) == COLON });
    if !p.at(CASE_KW) && !p.at(DEFAULT_KW) {
        return false;
    }
    let m = p.start();
    while p.at(CASE_KW) || p.at(DEFAULT_KW) {
        let label = p.start();
        if p.eat(CASE_KW) {
            expr::expr(p);
        } else {
            p.bump(DEFAULT_KW);
        }
        if !p.expect(COLON) && !p.at_ts(TYPE_FIRST) {
            label.complete(p, CASE_LABEL);
            break;
        }
        label.complete(p, CASE_LABEL);
    }
    if !p.is_reported() && type_spec(p, AllowedTypes::Constructed) {
        declarator(p);
    }
    semicolon(p, "this case");
    m.complete(p, CASE);
    true
}

/// A name with array dimensions.
pub(super) fn declarator(p: &mut Parser<'_>) -> bool {
    let m = p.start();
    if !declared_name(p) {
        m.abandon(p);
        return false;
    }
    while p.at(L_BRACK) {
        let dimension = p.start();
        p.bump(L_BRACK);
        expr::expr(p);
        p.expect_before(R_BRACK, AFTER_BRACKET);
        dimension.complete(p, DIMENSION);
    }
    m.complete(p, DECLARATOR);
    true
}

/// The tokens that may follow the name that a type is given to.
const AFTER_NAME: TokenSet =
    TokenSet::new(&[SEMICOLON, COMMA, L_BRACK, EQ, R_PAREN, L_CURLY, COLON]);

/// The name that a type is given to. In incomplete text the next declaration may follow instead.
pub(super) fn declared_name(p: &mut Parser<'_>) -> bool {
    // `port in t ids { doc "…"; };` is a port called `ids`.
    let is_port = p.at(IDS_KW) && p.nth_at(1, L_CURLY) && property::at_body(p, 2);
    if at_member(p) || (spec::at_item(p) && !is_port) {
        p.expected("a name");
        return false;
    }
    name(p)
}

/// Returns true if the next declaration begins here, in the place of a type. A type and a name are not a
/// declaration.
pub(super) fn at_next(p: &Parser<'_>) -> bool {
    let continues = p.starts_line() && p.position() != p.item;
    spec::at_item(p) && (continues || !(p.nth_at(1, IDENT) && p.nth_at_ts(2, AFTER_NAME)))
}

/// Returns true at a type and a name in the place of one name: a declaration of its own.
pub(super) fn at_member(p: &Parser<'_>) -> bool {
    const END: TokenSet = TokenSet::new(&[SEMICOLON, COMMA, L_BRACK]);
    p.at(IDENT) && (p.nth_at(1, COLON2) || (p.nth_at(1, IDENT) && p.nth_at_ts(2, END)))
}

/// Returns true at a type and a name, or at a token that is certainly a type.
pub(super) fn begins_member(p: &Parser<'_>) -> bool {
    at_member(p) || p.at_ts(TYPE_FIRST) && !p.at(IDENT) && !p.at(COLON2)
}

/// Returns true at a parameter of a service without its direction: a type and a name.
pub(super) fn begins_param(p: &Parser<'_>) -> bool {
    const AFTER: TokenSet = TokenSet::new(&[COMMA, R_PAREN, L_BRACK, EQ]);
    let named = p.at(IDENT) && p.nth(1) == IDENT && p.nth_at_ts(2, AFTER);
    named || p.at_ts(TYPE_FIRST) && !p.at(IDENT) && !p.at(COLON2)
}

/// The types that a place allows.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum AllowedTypes {
    /// All but declarations of structs, unions and enums.
    Simple,
    /// All.
    Constructed,
}

/// The types that are declared with a body.
const BLOCKS: TokenSet = TokenSet::new(&[STRUCT_KW, UNION_KW, ENUM_KW]);

/// The tokens that begin a type.
pub(super) const TYPE_FIRST: TokenSet = TokenSet::new(&[
    IDENT,
    COLON2,
    UNSIGNED_KW,
    SHORT_KW,
    LONG_KW,
    FIXED_KW,
    FLOAT_KW,
    DOUBLE_KW,
    CHAR_KW,
    WCHAR_KW,
    STRING_KW,
    WSTRING_KW,
    BOOLEAN_KW,
    OCTET_KW,
    OBJECT_KW,
    ANY_KW,
    STRUCT_KW,
    UNION_KW,
    ENUM_KW,
    SEQUENCE_KW,
    OPTIONAL_KW,
]);

/// A type where it is used. Reports a missing type.
// test type_spec
// typedef boolean a; typedef octet b; typedef char c; typedef any d; typedef float e;
// typedef double f; typedef short g; typedef long h; typedef long long i;
// typedef unsigned short j; typedef unsigned long k; typedef unsigned long long l;
// typedef string m; typedef string<N> n; typedef fixed<5, 2> o; typedef fixed p;
// typedef sequence<long> q; typedef sequence<optional<a::b>, 2 * 3> r; typedef ::a s;
pub(super) fn type_spec(p: &mut Parser<'_>, allow: AllowedTypes) -> bool {
    const TEMPLATES: TokenSet = TokenSet::new(&[SEQUENCE_KW, OPTIONAL_KW, STRING_KW]);
    const MISSPELT_BLOCKS: TokenSet = TokenSet::new(&[STRUCT_KW, ENUM_KW]);
    const SIGNED: TokenSet = TokenSet::new(&[UNSIGNED_KW]);
    const INTEGERS: TokenSet = TokenSet::new(&[SHORT_KW, LONG_KW]);
    foreign::type_of_cpp(p);
    if p.at(IDENT) && p.nth(1) == L_ANGLE {
        p.respell(TEMPLATES, |_| true);
    } else if p.at(IDENT) && p.nth_at_ts(1, INTEGERS) {
        p.respell(SIGNED, |_| true);
    } else if p.at(IDENT) && p.nth(1) == IDENT && p.nth(2) == L_CURLY {
        p.respell(MISSPELT_BLOCKS, |_| allow == AllowedTypes::Constructed);
    }
    match p.current() {
        UNSIGNED_KW | SHORT_KW | LONG_KW | FLOAT_KW | DOUBLE_KW | CHAR_KW | BOOLEAN_KW
        | OCTET_KW | ANY_KW => base_type(p),
        STRING_KW => string_type(p),
        SEQUENCE_KW | OPTIONAL_KW => return template_type(p),
        FIXED_KW => fixed_type(p),
        // In incomplete text.
        IDENT if at_next(p) => {
            p.expected("a type");
            return false;
        }
        IDENT | COLON2 => {
            let m = p.start();
            path_with(p, true);
            m.complete(p, NAMED_TYPE);
        }
        STRUCT_KW | UNION_KW | ENUM_KW if allow == AllowedTypes::Constructed => {
            return constructed_type(p);
        }
        STRUCT_KW | UNION_KW | ENUM_KW => {
            unfit_type(p, Parsing::DeclaredHere);
        }
        WCHAR_KW | WSTRING_KW | OBJECT_KW => {
            let m = p.start();
            let word = p.current_text().into();
            p.error_here(Parsing::Meaningless { word });
            p.bump_any();
            m.complete(p, ERROR);
        }
        _ => {
            p.expected("a type");
            return false;
        }
    }
    true
}

/// A type that is not allowed here: parsed, reported and hidden from the tree's users.
fn unfit_type(p: &mut Parser<'_>, kind: Parsing) {
    let m = p.start();
    p.error_here(kind);
    type_spec(p, AllowedTypes::Constructed);
    m.complete(p, ERROR);
}

fn base_type(p: &mut Parser<'_>) {
    let m = p.start();
    let unsigned = p.eat(UNSIGNED_KW);
    if p.eat(LONG_KW) {
        p.eat(LONG_KW);
        foreign_int(p);
    } else if unsigned {
        if p.eat(SHORT_KW) {
            foreign_int(p);
        } else if p.expected("`short` or `long` after `unsigned`") {
            let at = p.position();
            // Types of C.
            let (tokens, text) = match p.current_text().as_str() {
                "int" => (at..at + 1, "long"),
                "char" => (at - 1..at + 1, "octet"),
                _ => {
                    p.insert_behind(" long", false);
                    m.complete(p, BASE_TYPE);
                    return;
                }
            };
            p.replace(tokens, text, true);
            let bad = p.start();
            p.bump_any();
            bad.complete(p, ERROR);
        }
    } else {
        let is_short = p.at(SHORT_KW);
        p.bump_any();
        if is_short {
            foreign_int(p);
        }
    }
    m.complete(p, BASE_TYPE);
}

/// The word `int` after `long` or `short`, as in C.
fn foreign_int(p: &mut Parser<'_>) {
    if !p.at(IDENT) || p.nth(1) != IDENT || p.current_text() != "int" || p.is_reported() {
        return;
    }
    let at = p.position();
    let word = "int".into();
    p.push_error(at, Parsing::ForeignType { word, ty: "long" });
    p.replace(at..at + 1, "", false);
    let bad = p.start();
    p.bump_any();
    bad.complete(p, ERROR);
}

fn string_type(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(STRING_KW);
    if p.eat(L_ANGLE) {
        expr::in_angles(p);
        close_angle(p);
    }
    m.complete(p, STRING_TYPE);
}

fn fixed_type(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(FIXED_KW);
    if p.eat(L_ANGLE) {
        expr::in_angles(p);
        if p.expect(COMMA) {
            expr::in_angles(p);
        }
        close_angle(p);
    }
    m.complete(p, FIXED_TYPE);
}

/// `sequence<T, N>` or `optional<T>`
fn template_type(p: &mut Parser<'_>) -> bool {
    if !p.enter() {
        return false;
    }
    let m = p.start();
    let kind = if p.at(SEQUENCE_KW) { SEQUENCE_TYPE } else { OPTIONAL_TYPE };
    p.bump_any();
    let opened = p.expect(L_ANGLE);
    if opened && p.starts_line() && at_member(p) {
        p.expected("a type");
    } else if opened && type_spec(p, AllowedTypes::Simple) {
        if kind == SEQUENCE_TYPE && p.eat(COMMA) {
            expr::in_angles(p);
        }
        close_angle(p);
    }
    m.complete(p, kind);
    p.leave();
    true
}

/// The `>` of a template. `>>` is one token, the shift operator: the inner template reports it and the outer
/// one consumes it.
fn close_angle(p: &mut Parser<'_>) {
    if p.at(SHR) {
        if p.is_reported() {
            let m = p.start();
            p.bump(SHR);
            m.complete(p, ERROR);
        } else if p.error_here(Parsing::ClosingShift) {
            let at = p.position();
            p.replace(at..at + 1, "> >", true);
        }
        return;
    }
    const FOLLOWERS: TokenSet = TokenSet::new(&[IDENT, COMMA, R_ANGLE]);
    p.expect_before(R_ANGLE, FOLLOWERS);
}

fn constructed_type(p: &mut Parser<'_>) -> bool {
    if !p.enter() {
        return false;
    }
    match p.current() {
        STRUCT_KW => struct_type(p),
        UNION_KW => union_type(p),
        _ => enum_type(p),
    }
    p.leave();
    true
}

fn struct_type(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(STRUCT_KW);
    if type_name(p) {
        if braces::at_body(p, Fragment::Members) {
            spec::body(p, Fragment::Members, false, "this struct");
        } else {
            p.expected_because(
                "`{`",
                "a type that is declared already is used without the word `struct`",
            );
        }
    }
    m.complete(p, STRUCT);
}

// test union_inline_enum
// union u switch (enum e { A, B }) { case A: long x; };
fn union_type(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(UNION_KW);
    if type_name(p) {
        const SWITCH: TokenSet = TokenSet::new(&[SWITCH_KW]);
        p.respell(SWITCH, |p| p.nth(1) == L_PAREN);
        if !p.eat(SWITCH_KW) {
            p.expected_because("`switch`", "write `union NAME switch (TYPE) { … }`");
            p.skip_construct();
            m.complete(p, UNION);
            return;
        }
        if p.expect(L_PAREN) {
            switch_type(p);
            p.expect(R_PAREN);
        }
        if braces::at_body(p, Fragment::Cases) {
            spec::body(p, Fragment::Cases, false, "this union");
        } else {
            p.expected("`{`");
        }
    }
    m.complete(p, UNION);
}

fn switch_type(p: &mut Parser<'_>) {
    const FIT: TokenSet = TokenSet::new(&[
        UNSIGNED_KW,
        SHORT_KW,
        LONG_KW,
        CHAR_KW,
        BOOLEAN_KW,
        ENUM_KW,
        IDENT,
        COLON2,
    ]);
    if p.at_ts(FIT) || !p.at_ts(TYPE_FIRST) {
        type_spec(p, AllowedTypes::Constructed);
    } else {
        unfit_type(p, Parsing::UnfitSwitch);
    }
}

fn enum_type(p: &mut Parser<'_>) {
    let m = p.start();
    p.bump(ENUM_KW);
    if type_name(p) {
        if braces::at_enumerators(p) {
            enumerators(p);
        } else {
            p.expected_because(
                "`{`",
                "a type that is declared already is used without the word `enum`",
            );
        }
    }
    m.complete(p, ENUM);
}

fn enumerators(p: &mut Parser<'_>) {
    let m = p.start();
    let body = braces::open(p, Fragment::Members, "this enum");
    while !(p.at(R_CURLY) && p.is_after_include()) {
        let one = p.start();
        if name(p) {
            one.complete(p, ENUMERATOR);
            if p.at(EQ) {
                let value = p.start();
                p.error_here(Parsing::EnumeratorValue);
                p.bump(EQ);
                expr::expr(p);
                value.complete(p, ERROR);
            }
        } else {
            one.abandon(p);
            if !p.at(COMMA) && !p.at_item_end() && !spec::at_declaration(p) {
                let bad = p.start();
                p.bump_any();
                bad.complete(p, ERROR);
            }
        }
        if !p.eat(COMMA) {
            if p.at(R_CURLY) || p.at_item_end() || spec::at_declaration(p) {
                break;
            }
            if p.expected("`,` or `}`") && p.at(IDENT) {
                p.insert_behind(",", true);
            }
            // A name right after a name: the comma is missing.
            if !p.at(IDENT) {
                let bad = p.start();
                p.bump_any();
                bad.complete(p, ERROR);
            }
        }
    }
    braces::close(p, body);
    m.complete(p, ENUMERATOR_LIST);
}

/// The name of a struct, union or enum; anonymous ones do not exist.
fn type_name(p: &mut Parser<'_>) -> bool {
    if p.at(L_CURLY) && p.nameless == Some(p.position()) {
        return true;
    }
    if p.at(L_CURLY) {
        p.expected_because("a name", "structs, unions and enums cannot be anonymous");
        p.skip_construct();
        return false;
    }
    name(p)
}
