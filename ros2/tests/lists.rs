//! Common messages with lists, and lists of ports.

use dotgen_ros2::conversion::conversions;
use serde_json::{Value, json};

use super::common::{NOW, conversion, data, rules};
use super::unit;

const CAMERA: &str = "module cam {
  struct field { octet kind; string label; unsigned short start; };
  struct dot { string name; unsigned long offset; octet datatype; unsigned long count; };
  struct frame {
    unsigned long w, h; sequence<octet> pixels; boolean big; octet four[4]; sequence<octet, 8> few;
    sequence<float> depth; sequence<string> names; sequence<dot> dots; sequence<field> fields;
    optional<sequence<octet> > maybe; sequence<double> angles;
  };
};
component pom {
  version \"1\"; lang \"c\";
  port out cam::frame frame;
  port in cam::frame goal;
};
";

/// The message of the output port, after its header of 16 bytes: the time of publication and no frame.
fn message(kind: &str, fields: &Value, constants: &Value, frame: &Value) -> Option<Vec<u8>> {
    let unit = unit(CAMERA);
    let conversion = conversion(&unit, &rules("frame", kind, fields, constants));
    let found = conversion.message(&unit.spec, &data(&unit, frame), NOW);
    found.expect("it fits").map(|bytes| bytes[20..].to_vec())
}

fn bytes(parts: &[&[u8]]) -> Vec<u8> {
    parts.concat()
}

#[test]
fn a_sequence_is_the_whole_list() {
    let fields = json!({"data": "pixels", "width": "w", "height": "h", "is_bigendian": "big"});
    let constants = json!({"encoding": "mono8", "step": 3});
    let frame = json!({"w": 3, "h": 1, "pixels": [7, 8, 9], "big": true});
    let found = message("sensor_msgs/Image", &fields, &constants, &frame);
    let header = [1, 0, 0, 0, 3, 0, 0, 0, 6, 0, 0, 0];
    // The word of the frame ends at 13, the numbers begin at 16.
    let tail = [1, 0, 3, 0, 0, 0, 3, 0, 0, 0, 7, 8, 9];
    let expected = bytes(&[&header, b"mono8\0", &tail]);
    assert_eq!(found, Some(expected));
}

#[test]
fn arrays_and_bounded_sequences_are_lists_of_output_ports() {
    let end = |member: &str, frame: &Value| {
        let found = message("sensor_msgs/Image", &json!({"data": member}), &json!({}), frame);
        let found = found.expect("all is there");
        found[found.len().saturating_sub(8)..].to_vec()
    };
    let frame = json!({"four": [1, 2, 3, 4], "few": [1, 2, 3, 4], "maybe": [1, 2, 3, 4]});
    for member in ["four", "few", "maybe"] {
        assert_eq!(end(member, &frame), [4, 0, 0, 0, 1, 2, 3, 4], "{member}");
    }
    let absent = message("sensor_msgs/Image", &json!({"data": "maybe"}), &json!({}), &json!({}));
    assert_eq!(absent, None);
}

#[test]
fn lists_without_a_source_are_empty_and_constants_are_whole() {
    let fields = json!({"position": "depth", "header": {"frame_id": "names"}});
    let unit = unit(CAMERA);
    let rules = rules("frame", "sensor_msgs/JointState", &fields, &json!({}));
    let component = &unit.spec.components.raw[0];
    let errors = conversions(&unit.spec, component, &rules).expect_err("a list is not a string");
    assert!(errors[0].why.contains("`names` is of type `sequence`"), "{errors:?}");
    let names = json!({"name": ["a", "bcd"]});
    let depth = json!({"depth": [0.5, 2.0]});
    let found = message("sensor_msgs/JointState", &json!({"position": "depth"}), &names, &depth);
    let text = [2, 0, 0, 0, 2, 0, 0, 0, b'a', 0, 0, 0, 4, 0, 0, 0, b'b', b'c', b'd', 0];
    let (half, two) = (0.5f64.to_le_bytes(), 2f64.to_le_bytes());
    let expected = bytes(&[&text, &[2, 0, 0, 0], &half, &two, &[0; 8]]);
    assert_eq!(found, Some(expected));
}

#[test]
fn lists_of_messages_take_members_and_tables() {
    let kind = "sensor_msgs/PointCloud2";
    let table =
        json!({"fields": [{"name": "x", "datatype": 7, "count": 1}, {"name": "y", "offset": 4}]});
    let data = json!({"data": "pixels"});
    let dots = json!({"dots": [
        {"name": "x", "datatype": 7, "count": 1}, {"name": "y", "offset": 4},
    ]});
    let assigned = json!({"data": "pixels", "fields": "dots"});
    let found = message(kind, &data, &table, &dots);
    assert_eq!(found, message(kind, &assigned, &json!({}), &dots));
    let found = found.expect("all is there");
    assert_eq!(found[8..30], *b"\x02\0\0\0\x02\0\0\0x\0\0\0\0\0\0\0\x07\0\0\0\x01\0");
}

#[test]
fn an_input_port_reads_lists() {
    let unit = unit(CAMERA);
    let image = |bytes: &[u8]| {
        let mut out = vec![0, 1, 0, 0];
        out.extend([0; 8]);
        out.extend([1, 0, 0, 0, 0, 0, 0, 0]);
        out.extend([1, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        out.extend((bytes.len() as u32).to_le_bytes());
        out.extend(bytes);
        out
    };
    let fields = json!({"data": "pixels", "width": "w"});
    let reads = conversion(&unit, &rules("goal", "sensor_msgs/Image", &fields, &json!({})));
    let found = reads.data(&unit.spec, &image(&[7, 8, 9])).expect("a frame");
    assert_eq!(found, data(&unit, &json!({"w": 2, "pixels": [7, 8, 9]})));
    let message = image(&[7, 8, 9]);
    for end in 0..message.len() {
        assert!(reads.data(&unit.spec, &message[..end]).is_err(), "{end}");
    }
    // A length that the message does not have.
    let mut message = image(&[]);
    let end = message.len();
    message[end - 4..].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(reads.data(&unit.spec, &message).is_err());
}

#[test]
fn messages_with_lists_are_read_back() {
    let unit = unit(CAMERA);
    for (kind, fields, frame) in [
        (
            "sensor_msgs/PointCloud2",
            json!({"fields": "dots", "data": "pixels"}),
            json!({"pixels": [1, 2], "dots": [{"name": "xy", "count": 3}, {"name": "", "offset": 1}]}),
        ),
        (
            "sensor_msgs/LaserScan",
            json!({"ranges": "depth", "intensities": "depth"}),
            json!({"depth": [0.5, 1.5, 2.5]}),
        ),
        (
            "sensor_msgs/JointState",
            json!({"name": "names", "position": "angles"}),
            json!({"names": ["a", ""], "angles": [0.5]}),
        ),
    ] {
        let conversion = |port| {
            let mut fields = fields.clone();
            if port == "goal" {
                fields.as_object_mut().expect("a table").remove("intensities");
            }
            conversion(&unit, &rules(port, kind, &fields, &json!({})))
        };
        let bytes = data(&unit, &frame);
        let message = conversion("frame").message(&unit.spec, &bytes, NOW).expect("it fits");
        let message = message.expect("all is there");
        assert_eq!(conversion("goal").data(&unit.spec, &message), Ok(bytes), "{kind}");
    }
}

#[test]
fn wrong_lists_are_told() {
    let unit = unit(CAMERA);
    let (component, none) = (&unit.spec.components.raw[0], json!({}));
    let image = |port: &str, member: &str| {
        rules(port, "sensor_msgs/Image", &json!({"data": member}), &none)
    };
    let cloud = |fields: Value, constants: Value| {
        rules("frame", "sensor_msgs/PointCloud2", &fields, &constants)
    };
    let wrong = [
        image("frame", "w"),
        image("frame", "depth"),
        image("frame", "dots"),
        image("frame", "pixels[0]"),
        image("goal", "few"),
        image("goal", "four"),
        cloud(json!({"fields": "fields"}), none.clone()),
        cloud(json!({"data[0]": "w"}), none.clone()),
        cloud(json!({"is_dense": "w"}), none.clone()),
        cloud(json!({"height": "big"}), json!({"is_dense": 1})),
        cloud(json!({"data": "pixels"}), json!({"fields": "x"})),
        cloud(json!({"data": "pixels"}), json!({"fields": ["x"]})),
        cloud(json!({"data": "pixels"}), json!({"fields": [{"nam": "x"}]})),
        cloud(json!({"data": "pixels"}), json!({"fields": [{"datatype": 256}]})),
        cloud(json!({"width": "w"}), json!({"data": [1, -1]})),
        rules(
            "goal",
            "sensor_msgs/LaserScan",
            &json!({"ranges": "depth", "intensities": "depth"}),
            &none,
        ),
    ];
    let mut all = String::new();
    for rules in wrong {
        match conversions(&unit.spec, component, &rules) {
            Ok(_) => all += &format!("accepted: {rules:?}\n"),
            Err(errors) => all.extend(errors.iter().map(|error| format!("{error}\n"))),
        }
    }
    insta::assert_snapshot!(all);
}
