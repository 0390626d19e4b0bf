//! Payloads of ports, services and actions.

use dotgen_codegen::codels::cdr::{CdrWriter, Unions, to_cdr};
use dotgen_codegen::codels::value::{Reader, Values};
use dotgen_ros2::cdr::{self, GoalInfo, Payloads, RequestEnd, Stamp};
use proptest::prelude::*;
use serde_json::{Value, json};

use super::{PUMP, type_of, unit};

const STATE: &str = "::pump::state";
const SHAPE: &str = "::or::t3d::shape";

fn state() -> Value {
    json!({
        "kind": "ON", "at": {"x": 1.0, "y": 0.5, "tag": "a"}, "path": [],
        "few": [{"x": 2.0, "y": 0.0, "tag": ""}],
        "cov": [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]], "maybe": -7,
        "names": ["p", ""], "ok": true,
    })
}

fn service(spec: &dotgen_analysis::model::Spec, name: &str) -> dotgen_analysis::model::ServiceId {
    let services = &spec.components.raw[0].services;
    let found = services.position(|service| service.name == name);
    found.expect("a service")
}

/// The CDR after its header.
fn body(parts: &[&[u8]]) -> Vec<u8> {
    [&[0, 1, 0, 0][..], &parts.concat()].concat()
}

#[test]
fn a_message_is_aligned_after_its_header() {
    let unit = unit(PUMP);
    let spec = &unit.spec;
    let payloads = Payloads::new(spec, &spec.components.raw[0]);
    let ty = type_of(spec, STATE);
    let data = Values::new(spec).encode(ty, &state()).expect("a value");
    let mut expected: Vec<Vec<u8>> = vec![
        vec![1, 0, 0, 0, 0, 0, 0, 0],
        1f64.to_le_bytes().into(),
        0.5f32.to_le_bytes().into(),
        vec![2, 0, 0, 0, b'a', 0, 0, 0],
        // No path, and one of few.
        vec![0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0],
        2f64.to_le_bytes().into(),
        vec![0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
    ];
    let length = |all: &[Vec<u8>]| all.iter().map(Vec::len).sum::<usize>();
    // The padding before numbers of eight bytes.
    expected[6].truncate(12);
    let padding = length(&expected).next_multiple_of(8) - length(&expected);
    expected.push(vec![0; padding]);
    expected.extend((1..10).map(|number| f64::from(number).to_le_bytes().into()));
    expected.push(vec![1, 0, 0, 0, 0xf9, 0xff, 0, 0]);
    expected.push(vec![2, 0, 0, 0, 2, 0, 0, 0, b'p', 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    let expected: Vec<&[u8]> = expected.iter().map(Vec::as_slice).collect();
    let message = payloads.message(ty, &data).expect("a value");
    assert_eq!(message, body(&expected));
    assert_eq!(payloads.data(ty, &message), Ok(data));
}

#[test]
fn a_union_is_a_discriminator_and_its_branches() {
    let unit = unit(PUMP);
    let spec = &unit.spec;
    let payloads = Payloads::new(spec, &spec.components.raw[0]);
    let ty = type_of(spec, SHAPE);
    let only = json!({"_d": "OFF", "only": {"x": 1.0, "y": 2.0}});
    let data = Values::new(spec).encode(ty, &only).expect("a value");
    let message = payloads.message(ty, &data).expect("a value");
    let expected = body(&[
        &[0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0],
        &1f64.to_le_bytes(),
        &2f64.to_le_bytes(),
        &[0, 0, 0, 0],
    ]);
    assert_eq!(message, expected);
    assert_eq!(payloads.data(ty, &message), Ok(data.clone()));
    // Outside of ROS 2, only the selected branch.
    let plain = to_cdr(Values::new(spec), ty, &data);
    let (one, two) = (1f64.to_le_bytes(), 2f64.to_le_bytes());
    assert_eq!(plain, Ok(body(&[&[0; 8][..], &one, &two])));
    // The branch of another discriminator, and two branches.
    let mut other = message.clone();
    other[4] = 1;
    assert!(payloads.data(ty, &other).is_err());
    let mut two = message;
    two[4 + 32] = 1;
    two.push(5);
    assert!(payloads.data(ty, &two).is_err());
}

#[test]
fn requests_and_responses_are_one_stream() {
    let unit = unit(PUMP);
    let spec = &unit.spec;
    let (component, values) = (&spec.components.raw[0], Values::new(spec));
    let payloads = Payloads::new(spec, component);
    let fill = service(spec, "fill");
    let id = [7; 16];
    let shape = json!({"_d": "AUTO", "mark": 3});
    let object = json!({"target": 2.5, "shape": shape});
    let of = &component.services[fill];
    let inputs = values.inputs(of, object.as_object().expect("it is one"));
    let inputs = inputs.expect("inputs");
    let mut request = CdrWriter::new(Unions::Branches);
    for byte in id {
        request.number([byte]);
    }
    let mut from = Reader::new(&inputs);
    for param in &of.params[..2] {
        request.value(values, param.ty, &mut from).expect("a value");
    }
    let request = request.finish();
    assert_eq!(payloads.goal(fill, &request), Ok((id, inputs)));

    let mut outputs = values.encode(type_of(spec, SHAPE), &shape).expect("a value");
    outputs.extend([1u32.to_ne_bytes(), 9u32.to_ne_bytes()].concat());
    let result = payloads.result(fill, cdr::SUCCEEDED, RequestEnd::Done(&outputs));
    // Status, shape, steps, no exception, no member of one.
    let expected = body(&[
        &[4, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0],
        &[1, 0, 0, 0, 9, 0, 0, 0],
        &[1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0],
    ]);
    assert_eq!(result, Ok(expected));
}

#[test]
fn an_exception_has_its_name_and_members() {
    let unit = unit(PUMP);
    let spec = &unit.spec;
    let payloads = Payloads::new(spec, &spec.components.raw[0]);
    let ty = type_of(spec, "::tank::too_high");
    let detail = json!({"limit": 0.5, "what": "x"});
    let detail = Values::new(spec).encode(ty, &detail).expect("a value");
    let failed = |exception, detail| {
        let wish = service(spec, "wish");
        payloads.response(wish, RequestEnd::Failed { exception, detail })
    };
    let text =
        |text: &str| [&(text.len() as u32 + 1).to_le_bytes()[..], text.as_bytes(), &[0]].concat();
    // No path and `n` is zero; after the name, an exception with members is there.
    let expected = body(&[
        &[0, 0, 0, 0, 0, 0, 0, 0],
        &text("::tank::too_high"),
        &[0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0],
        &0.5f64.to_le_bytes(),
        &text("x"),
    ]);
    let found = failed("::tank::too_high", &detail).expect("a response");
    let closed = failed("::tank::e_closed", &[]).expect("a response");
    let expected_closed =
        body(&[&[0, 0, 0, 0, 0, 0, 0, 0], &text("::tank::e_closed"), &[0, 0, 0, 0, 0, 0, 0]]);
    assert_eq!(closed, expected_closed);
    assert_eq!(found, expected);
    assert!(failed("::tank::too_high", &detail[..3]).is_err());
}

#[test]
fn the_messages_of_actions_have_their_layout() {
    let stamp = Stamp { sec: 1, nanosec: 2 };
    assert_eq!(cdr::accepted(true, stamp), body(&[&[1, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]]));
    let goal = GoalInfo { id: [9; 16], stamp };
    let info: &[u8] = &[&[9; 16][..], &[1, 0, 0, 0, 2, 0, 0, 0]].concat();
    assert_eq!(cdr::cancel(&body(&[info])), Ok(goal));
    assert_eq!(cdr::canceling(0, &[goal]), body(&[&[0, 0, 0, 0, 1, 0, 0, 0], info]));
    let statuses = cdr::statuses(&[(goal, cdr::ABORTED), (goal, cdr::SUCCEEDED)]);
    // The stamp of the second goal is aligned, its identifier is not.
    let second: &[u8] = &[&[9; 16][..], &[0, 0, 0], &info[16..]].concat();
    let expected = body(&[&[2, 0, 0, 0], info, &[6], second, &[4]]);
    assert_eq!(statuses, expected);
    assert_eq!(cdr::feedback([9; 16], "main"), body(&[&[9; 16], &[5, 0, 0, 0], b"main\0"]));
    assert_eq!(cdr::result_of(&body(&[&[9; 16]])), Ok([9; 16]));
    assert!(cdr::result_of(&body(&[&[9; 15]])).is_err());
}

#[test]
fn truncated_messages_are_refused() {
    let unit = unit(PUMP);
    let spec = &unit.spec;
    let payloads = Payloads::new(spec, &spec.components.raw[0]);
    let ty = type_of(spec, STATE);
    let data = Values::new(spec).encode(ty, &state()).expect("a value");
    let message = payloads.message(ty, &data).expect("a value");
    for end in 0..message.len() {
        assert!(payloads.data(ty, &message[..end]).is_err(), "{end} bytes");
    }
}

#[test]
fn any_bytes_are_read_or_refused() {
    let unit = unit(PUMP);
    let spec = &unit.spec;
    let payloads = Payloads::new(spec, &spec.components.raw[0]);
    let types = [STATE, SHAPE, "::or::t3d::path"].map(|name| type_of(spec, name));
    let [wish, fill] = ["wish", "fill"].map(|text| service(spec, text));
    // Small numbers are more often lengths that fit.
    let bytes = || prop::collection::vec(prop_oneof![4 => 0u8..3, 1 => any::<u8>()], 0..160);
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let check = |random: Vec<u8>| {
        for message in [random.clone(), body(&[&random])] {
            for ty in types {
                if let Ok(data) = payloads.data(ty, &message) {
                    let again = payloads.message(ty, &data).expect("what was read is a value");
                    prop_assert_eq!(payloads.data(ty, &again), Ok(data.clone()));
                    // No length takes more memory than the message has.
                    prop_assert!(data.len() <= message.len());
                }
            }
            let _ = payloads.inputs(wish, &message);
            let _ = payloads.goal(fill, &message);
            let _ = cdr::cancel(&message);
        }
        Ok(())
    };
    runner.run(&bytes(), check).expect("it holds");
}
