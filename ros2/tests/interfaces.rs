//! Files of packages.

use std::collections::BTreeMap;

use dotgen_ros2::conversion::Conversions;
use dotgen_ros2::description::Types;
use dotgen_ros2::interfaces::interfaces;
use dotgen_ros2::node::endpoints;
use dotgen_ros2::rules::Rules;

use super::{PUMP, unit};

#[test]
fn each_module_is_a_package() {
    let unit = unit(PUMP);
    let found =
        interfaces(&unit.spec, &[&unit.spec.components.raw[0]], &Rules::new()).expect("no rules");
    assert_eq!(found.refused, []);
    let mut all = String::new();
    for (path, text) in &found.files {
        all += &format!("== {path}\n{text}");
    }
    insta::assert_snapshot!(all);
}

/// The files say what the node offers: read back, they have the same hashes.
#[test]
fn files_and_descriptions_agree() {
    let unit = unit(PUMP);
    let component = &unit.spec.components.raw[0];
    let node = endpoints(&unit.spec, component, 0, Conversions::new()).expect("it has a name");
    let mut read = Types::standard();
    for (path, text) in interfaces(&unit.spec, &[component], &Rules::new()).expect("no rules").files
    {
        let Some((name, "msg" | "srv" | "action")) = path.rsplit_once('.') else {
            continue;
        };
        let lines = text.lines().filter(|line| !line.starts_with('#') && !line.contains('='));
        let bounded = text.lines().filter(|line| line.contains("<="));
        let lines: BTreeMap<usize, &str> =
            lines.chain(bounded).map(|line| (at(&text, line), line)).collect();
        let lines: Vec<&str> =
            lines.values().map(|line| line.split("  #").next().unwrap_or(line)).collect();
        super::hashes::add(&format!("= {name}\n{}\n", lines.join("\n")), &mut read);
    }
    let mut checked = 0;
    for endpoint in &node.endpoints {
        if !endpoint.type_name.starts_with("std_msgs") {
            assert_eq!(endpoint.hash, read.hash(&endpoint.type_name), "{}", endpoint.type_name);
            checked += 1;
        }
    }
    assert_eq!(checked, 12);
}

fn at(text: &str, line: &str) -> usize {
    line.as_ptr() as usize - text.as_ptr() as usize
}

#[test]
fn packages_that_need_each_other_are_refused() {
    let unit = unit(
        "module a { struct one { long x; }; };
         module b { struct two { a::one x; }; };
         module a { struct three { b::two x; }; };
         component demo { version \"1.0\"; lang \"c\"; port out a::three p; };",
    );
    let found =
        interfaces(&unit.spec, &[&unit.spec.components.raw[0]], &Rules::new()).expect("no rules");
    let found: Vec<String> = found.refused.iter().map(ToString::to_string).collect();
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].contains("`a` is not") && found[0].contains("`b` need each other"));
}

#[test]
fn names_that_do_not_build_are_left_out() {
    let unit = unit(
        "module m {
           struct a_b { long x; }; struct ab { long x; };
           enum reason { EOF, OK }; struct s { reason why; };
         };
         component demo {
           version \"1.0\"; lang \"c\";
           port out m::a_b p; port out m::ab q; port out m::s r;
         };",
    );
    let found =
        interfaces(&unit.spec, &[&unit.spec.components.raw[0]], &Rules::new()).expect("no rules");
    let refused: Vec<String> = found.refused.iter().map(ToString::to_string).collect();
    assert!(refused[0].contains("both become the files `m/msg/ab`"), "{refused:?}");
    let constants = &found.files["m/msg/Reason.msg"];
    assert!(
        constants.contains("# EOF=0: a macro") && constants.contains("uint32 OK=1"),
        "{constants}"
    );
}
