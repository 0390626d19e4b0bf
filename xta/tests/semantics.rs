//! One test for each rule of the semantics.

use super::{holds, invalid, trace, values};

#[test]
fn time_passes_up_to_the_invariant() {
    let model =
        "process P() { clock x; state a { x <= 5 }, b; init a; trans a -> b { guard x >= 3; }; }
        system P;";
    assert!(holds(model, "E<> P.b and P.x == 3"));
    assert!(holds(model, "A[] not (P.b and P.x < 3)"));
    assert!(holds(model, "A[] P.a imply P.x <= 5"));
    assert!(!holds(model, "A[] P.a imply P.x < 5"));
    assert_eq!(trace(model, "E<> P.b and P.x > 7").time, 7);
}

#[test]
fn an_urgent_location_stops_time_but_not_others() {
    let model = "bool seen := false;
        process P() { clock x; state a, b; urgent a; init a; trans a -> b { }; }
        process Q() { state a, b; init a; trans a -> b { assign seen := true; }; }
        system P, Q;";
    assert!(holds(model, "A[] P.a imply P.x == 0"));
    assert!(holds(model, "E<> P.a and seen"));
}

#[test]
fn a_committed_location_moves_next() {
    let model = "bool seen := false;
        process P() { clock x; state a, b; commit a; init a; trans a -> b { }; }
        process Q() { state a, b; init a; trans a -> b { assign seen := true; }; }
        system P, Q;";
    assert!(holds(model, "A[] P.a imply P.x == 0"));
    assert!(holds(model, "A[] not (P.a and seen)"));
}

#[test]
fn a_receiver_may_be_the_committed_process() {
    let model = "chan c;
        process P() { state a, b; commit a; init a; trans a -> b { sync c?; }; }
        process Q() { state a, b; init a; trans a -> b { sync c!; }; }
        system P, Q;";
    assert!(holds(model, "E<> P.b and Q.b"));
    assert!(holds(model, "A[] P.a imply Q.a"));
}

#[test]
fn an_urgent_channel_stops_time_only_if_both_sides_are_enabled() {
    let model = |wait: i32| {
        format!(
            "urgent chan go; bool open := {wait};
            process P() {{ clock x; state a, b; init a; trans a -> b {{ guard open; sync go!; }}; }}
            process Q() {{ clock y; state w, b; init w; trans w -> w {{ guard y == 4; assign open := true; }},
                w -> b {{ sync go?; }}; }}
            system P, Q;"
        )
    };
    assert!(holds(&model(1), "A[] P.a imply P.x == 0"));
    assert!(holds(&model(0), "A[] P.a and open imply P.x == 4"));
    assert!(holds(&model(0), "E<> P.a and P.x == 3"));
}

#[test]
fn an_urgent_broadcast_needs_no_receiver() {
    let model = "urgent broadcast chan go;
        process P() { clock x; state a, b; init a; trans a -> b { sync go!; }; }
        system P;";
    assert!(holds(model, "A[] P.a imply P.x == 0"));
    assert!(holds(&model.replace("urgent broadcast", "broadcast"), "E<> P.a and P.x > 9"));
}

#[test]
fn a_binary_channel_needs_two_processes() {
    let model = "chan c;
        process P() { state a, b; init a; trans a -> b { sync c!; }, a -> b { sync c?; }; }
        system P;";
    assert!(!holds(model, "E<> P.b"));
}

#[test]
fn a_broadcast_reaches_all_that_are_enabled() {
    let model = "broadcast chan c; int n := 0;
        process S() { state a, b; init a; trans a -> b { sync c!; }; }
        process R(const int on) { state a, b; init a; trans a -> b { guard on > 0; sync c?; assign n++; }; }
        r1 := R(1); r2 := R(1); r3 := R(0);
        system S, r1, r2, r3;";
    assert!(holds(model, "A[] S.b imply (r1.b and r2.b and not r3.b and n == 2)"));
}

#[test]
fn a_receiver_of_a_broadcast_takes_part_by_its_clock() {
    let model = "broadcast chan c;
        process S() { state a, b; init a; trans a -> b { sync c!; }; }
        process R() { clock x; state a, b; init a; trans a -> b { guard x >= 2 && x < 4; sync c?; }; }
        system S, R;";
    assert!(holds(model, "E<> S.b and R.b"));
    assert!(holds(model, "A[] (S.b and R.a and R.x < 4) imply R.x >= 0"));
    let model = model.replace(
        "state a, b; init a; trans a -> b { sync c!",
        "clock y; state a, b { y <= 0 }; init a; trans a -> b { assign y := 0; sync c!",
    );
    assert!(holds(&model, "A[] (S.b and R.a) imply (R.x < 2 or R.x >= 4)"));
    assert!(holds(&model, "A[] (S.b and R.b) imply (R.x >= 2 and R.x < 4)"));
    assert!(holds(&model, "E<> S.b and R.a and R.x >= 4"));
}

#[test]
fn the_sender_updates_first() {
    let model = "chan c; int n := 1;
        process S() { state a, b; init a; trans a -> b { sync c!; assign n := n + 1; }; }
        process R() { state a, b; init a; trans a -> b { sync c?; assign n := n * 10; }; }
        system R, S;";
    assert!(holds(model, "A[] S.b imply n == 20"));
}

#[test]
fn a_channel_of_higher_priority_goes_first() {
    let model = "broadcast chan low, high; chan priority low < default < high;
        process P(broadcast chan &c, const int wait) { clock x; state a, b; init a;
            trans a -> b { guard x >= wait; sync c!; }; }
        process T() { state a, b; init a; trans a -> b { }; }
        p := P(low, 0); q := P(high, 3);
        system p, q, T;";
    // The sender on `high` blocks the others from time 3.
    assert!(holds(model, "E<> p.b and q.a"));
    assert!(holds(model, "A[] (p.b and q.a) imply T.b"));
    let model = model.replace("clock x;", "").replace("guard x >= wait; ", "");
    assert!(holds(&model, "A[] T.b imply q.b"));
    assert!(holds(&model, "A[] p.b imply T.b"));
}

#[test]
fn a_higher_priority_blocks_only_while_its_clock_allows() {
    let model = "broadcast chan low, high; chan priority low < high;
        process P() { clock y; state a, b { y <= 0 }, c; init a;
            trans a -> b { sync low!; assign y := 0; }, b -> c { }; }
        process Q() { clock x; state a, b; init a; trans a -> b { guard x >= 2 && x <= 3; sync high!; }; }
        system P, Q;";
    assert!(holds(model, "A[] (P.b and Q.a) imply (Q.x < 2 or Q.x > 3)"));
    assert!(holds(model, "E<> P.b and Q.a and Q.x > 3"));
}

#[test]
fn a_process_of_higher_priority_goes_first() {
    let model = "process P() { state a, b; init a; trans a -> b { }; }
        p := P(); q := P();
        system p < q;";
    assert!(holds(model, "A[] p.b imply q.b"));
    assert!(!holds(&model.replace('<', ","), "A[] p.b imply q.b"));
}

#[test]
fn a_value_out_of_range_is_an_error_of_the_model() {
    let model = "int[0, 2] n := 0;
        process P() { state a; init a; trans a -> a { assign n++; }; }
        system P;";
    let message = invalid(model, "A[] n >= 0");
    assert_eq!(message, "value 3 is out of the range [0, 2], at P.a -> a");
    let model = model
        .replace("trans", "trans a -> a { guard n == 2; assign n := 0; },")
        .replace("{ assign n++", "{ guard n < 2; assign n++");
    assert!(holds(&model, "A[] n <= 2"));
}

#[test]
fn an_index_out_of_bounds_is_an_error_of_the_model() {
    let model = "int n[2]; int i := 0;
        process P() { state a; init a; trans a -> a { guard n[i] == 0; assign i := i + 1; }; }
        system P;";
    assert_eq!(invalid(model, "A[] true"), "index 2 is out of an array of length 2");
}

#[test]
fn an_invariant_of_the_target_disables_the_edge() {
    let model =
        "process P() { clock x; state a, b { x <= 2 }; init a; trans a -> b { guard x >= 1; }; }
        system P;";
    assert!(holds(model, "A[] P.b imply (P.x >= 1 and P.x <= 2)"));
    let model = model.replace("x <= 2", "x <= 0");
    assert!(!holds(&model, "E<> P.b"));
}

#[test]
fn a_clock_is_set_to_a_value() {
    let model =
        "process P() { clock x; state a, b { x <= 9 }; init a; trans a -> b { assign x := 4; }; }
        system P;";
    assert_eq!(values(model, "inf{P.b}: P.x"), [Some((4, true))]);
    assert_eq!(values(model, "sup{P.b}: P.x"), [Some((9, true))]);
}

#[test]
fn channels_are_chosen_by_index() {
    let model = "chan c[3]; int[0, 2] which := 2;
        process S() { state a, b; init a; trans a -> b { sync c[which]!; }; }
        process R(const int[0, 2] mine) { state a, b; init a; trans a -> b { sync c[mine]?; }; }
        r0 := R(0); r2 := R(2);
        system S, r0, r2;";
    assert!(holds(model, "E<> r2.b"));
    assert!(!holds(model, "E<> r0.b"));
}

#[test]
fn a_select_tries_all_values() {
    let model = "int[0, 9] n := 9;
        process P() { state a, b; init a; 
            trans a -> b { select i : int[2, 4]; guard i != 3; assign n := i; }; }
        system P;";
    assert!(holds(model, "E<> n == 2") && holds(model, "E<> n == 4"));
    assert!(!holds(model, "E<> n == 3 or n < 2"));
}
