//! Published components as nodes.

use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::host::{AnalysisHost, BatchInput, Input, UnitResult};
use dotgen_analysis::model::ComponentKind;
use dotgen_codegen::codels::value::Values;
use dotgen_loaders::Disk;
use dotgen_ros2::cdr::{Payloads, RequestEnd};
use dotgen_ros2::conversion::Conversions;
use dotgen_ros2::interfaces::interfaces;
use dotgen_ros2::node::endpoints;
use dotgen_ros2::rules::Rules;
use serde_json::Value;

/// The units of all specifications, in order of their paths.
fn units() -> Vec<(String, UnitResult)> {
    let Some(root) = dotgen_loaders::shared("corpus") else {
        return Vec::new();
    };
    let root = Utf8PathBuf::from_path_buf(root).expect("UTF-8");
    let mut out = Vec::new();
    let folders = ["components", "robnav", "quadcopter"];
    let mut pending: Vec<(&str, Utf8PathBuf)> =
        folders.map(|folder| (folder, root.join(folder))).into();
    while let Some((folder, path)) = pending.pop() {
        if path.is_dir() && path != root.join("components/standins") {
            let entries = path.read_dir_utf8().expect("a folder").flatten();
            pending.extend(entries.map(|entry| (folder, entry.into_path())));
        } else if path.extension() == Some("gen") {
            let include = match folder {
                "components" => "components/standins",
                other => other,
            };
            let input = BatchInput {
                inputs: vec![Input::File(path.clone())],
                include_dirs: vec![root.join(include)],
                ..BatchInput::default()
            };
            let host = AnalysisHost::new(Arc::new(Disk));
            let unit = host.analysis().batch(&input).expect("nobody cancels");
            let name = path.strip_prefix(&root).expect("below it");
            out.push((name.to_string(), unit));
        }
    }
    out.sort_by(|a, b| a.0.cmp(&b.0));
    out
}

#[test]
fn published_components_are_offered() {
    let units = units();
    let (mut found, mut offered) = (String::new(), 0);
    for (path, unit) in &units {
        let spec = &unit.spec;
        let values = Values::new(spec);
        let components = spec.components.iter();
        let components: Vec<_> =
            components.filter(|component| component.kind == ComponentKind::Component).collect();
        for component in &components {
            let node = endpoints(spec, component, 0, Conversions::new())
                .unwrap_or_else(|error| panic!("{path}: {error:?}"));
            offered += node.endpoints.len();
            let payloads = Payloads::new(spec, component);
            for port in &component.ports {
                let zero = values.encode(port.data, &Value::Null).expect("zero");
                let message = payloads.message(port.data, &zero).expect("a message");
                assert_eq!(payloads.data(port.data, &message), Ok(zero), "{path} {}", port.name);
            }
            for service in component.services.keys() {
                let (exception, detail) = ("::other", &[][..]);
                let failed = RequestEnd::Failed { exception, detail };
                payloads.response(service, failed).expect("a response");
            }
        }
        for refusal in interfaces(spec, &components, &Rules::new()).expect("no rules").refused {
            found += &format!("{path}: {refusal}\n");
        }
    }
    assert_eq!(found, "", "everything has a form in ROS 2");
    assert!(units.is_empty() || offered > 300, "{offered} endpoints");
}
