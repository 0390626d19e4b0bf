//! Declarations, types and functions.

use super::{holds, invalid};

/// A network that runs one update, after which `q` has to hold.
fn after(declarations: &str, update: &str, query: &str) -> bool {
    let model = format!(
        "{declarations} process P() {{ state a, b; init a; trans a -> b {{ assign {update}; }}; }} system P;"
    );
    holds(&model, &format!("A[] P.b imply ({query})"))
}

#[test]
fn operators_have_the_precedence_of_c() {
    let values = "int a, b, c; bool d;";
    assert!(after(
        values,
        "a := 1 + 2 * 3, b := 7 / 2 - 1, c := -7 % 4",
        "a == 7 && b == 2 && c == -3"
    ));
    assert!(after(
        values,
        "a := 6 & 3 | 8, b := 1 << 3 >> 1, c := 5 <? 3 >? 4",
        "a == 10 && b == 4 && c == 4"
    ));
    assert!(after(values, "d := not 1 == 2 and true, a := d ? 1 : 2", "d and a == 1"));
    assert!(after(values, "a := 3, a += 2, b := a++, c := --a", "a == 5 && b == 5 && c == 5"));
}

#[test]
fn records_and_arrays_are_copied() {
    let declarations = "const int n := 2;
        typedef struct { int[0, 9] key; bool flag[n]; } cell;
        cell list[n] := { {1, {false, true}}, {2, {true, false}} };
        cell one := {0, {false, false}};";
    assert!(after(
        declarations,
        "one := list[1], list[0].key := 7",
        "one.key == 2 && one.flag[0] && !one.flag[1]"
    ));
    assert!(after(
        declarations,
        "list[0] := list[1], list[1].key := 5",
        "list[0].key == 2 && list[1].key == 5"
    ));
}

#[test]
fn functions_take_references_and_copies() {
    let declarations = "const int n := 3; int a[n] := {5, 3, 4}; int s := 0;
        void sort(int &v[n]) { int i, j, t;
            for (i := 0; i < n; i++) for (j := i + 1; j < n; j++)
                if (v[j] < v[i]) { t := v[i]; v[i] := v[j]; v[j] := t; } }
        int total(int v[n]) { int t := 0; int i := 0; while (i < n) { t += v[i]; v[i] := 0; i++; } return t; }
        int last(int v[n]) { int i := n; do { i--; if (v[i] < 5) return v[i]; } while (i > 0); return -1; }";
    assert!(after(
        declarations,
        "sort(a), s := total(a)",
        "a[0] == 3 && a[1] == 4 && a[2] == 5 && s == 12"
    ));
    assert!(after(declarations, "s := last(a)", "s == 4"));
}

#[test]
fn a_loop_runs_over_a_type() {
    let declarations = "typedef int[0, 3] id; int n := 0; bool b[id];
        void f() { for (i : id) n += i; b[3] := true; }";
    assert!(after(
        declarations,
        "f()",
        "n == 6 && exists (i : id) b[i] && not forall (i : id) b[i]"
    ));
}

#[test]
fn an_endless_loop_is_an_error_of_the_model() {
    let model = "void f() { while (true) { } }
        process P() { state a; init a; trans a -> a { assign f(); }; } system P;";
    assert!(invalid(model, "A[] true").starts_with("more than"));
}

#[test]
fn a_function_without_return_is_an_error_of_the_model() {
    let model = "int f(int a) { if (a > 0) return 1; }
        process P() { state a; init a; trans a -> a { guard f(0) == 1; }; } system P;";
    assert!(invalid(model, "A[] true").starts_with("a function ended without `return`"));
}

#[test]
fn a_guard_must_not_assign_through_a_function() {
    let model = "int n := 0; int f() { n := 1; return 1; }
        process P() { state a; init a; trans a -> a { guard f() == 1; }; } system P;";
    assert_eq!(invalid(model, "A[] true"), "a condition assigns a variable");
}

#[test]
fn parameters_are_references_or_values() {
    let model = "int a := 1; int b := 2; clock z;
        process P(int &r, int v, clock &c) { state s { c <= 3 }, t; init s;
            trans s -> t { guard c >= 2; assign r := r + v, v := 0, c := 0; }; }
        p := P(a, 7, z); q := P(b, 8, z);
        system p, q;";
    assert!(holds(model, "E<> a == 8 and b == 10"));
    assert!(holds(model, "A[] p.t imply (a == 8 and p.v == 0)"));
}
