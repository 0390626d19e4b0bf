//! Pictures of specifications: our examples, and published ones if they are next to the project.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use camino::Utf8PathBuf;
use dotgen_analysis::host::{AnalysisHost, Change, Config, UnitResult};
use dotgen_analysis::model::{Component, ComponentKind};
use dotgen_diagram::graph::Graph;
use dotgen_diagram::layout::layout;
use dotgen_diagram::render::{dot::dot, mermaid::mermaid, png::png, svg::svg};
use dotgen_diagram::theme::Theme;
use dotgen_diagram::{fsm, locks, system};
use dotgen_loaders::Disk;

use crate::suite::geometry::problems;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The `.gen` files below a directory, each as a unit.
fn units(directory: &Path) -> Vec<(Utf8PathBuf, UnitResult)> {
    let mut files = Vec::new();
    let mut includes = vec![];
    let mut pending = vec![directory.to_owned()];
    while let Some(directory) = pending.pop() {
        for entry in std::fs::read_dir(&directory).expect("a directory") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                if path.join("or").is_dir() || path.ends_with("idl") {
                    includes.push(Utf8PathBuf::from_path_buf(path.clone()).expect("UTF-8"));
                }
                pending.push(path);
            } else if path.extension().is_some_and(|extension| extension == "gen") {
                files.push(Utf8PathBuf::from_path_buf(path).expect("UTF-8"));
            }
        }
    }
    files.sort();
    includes.push(Utf8PathBuf::from_path_buf(directory.to_owned()).expect("UTF-8"));
    let mut host = AnalysisHost::new(Arc::new(Disk));
    host.apply(Change {
        roots: Some(files.clone()),
        config: Some(Config { include_dirs: includes, ..Config::default() }),
        ..Change::default()
    });
    let analysis = host.analysis();
    let unit = |path: &Utf8PathBuf| analysis.root_unit(path).expect("nothing cancels it");
    files.iter().map(|file| (file.clone(), unit(file))).collect()
}

/// Every picture of a specification.
fn pictures(unit: &UnitResult) -> Vec<Graph> {
    let spec = &unit.spec;
    let mut graphs = Vec::new();
    let components: Vec<&Component> = spec
        .components
        .iter()
        .filter(|component| component.kind == ComponentKind::Component)
        .collect();
    for component in &components {
        for owner in component.machines() {
            for (wcet, paths, locks) in [(true, false, false), (true, true, true)] {
                let options = fsm::Options { wcet, paths, locks, ..fsm::Options::default() };
                graphs.extend(fsm::graph(spec, component, owner, options));
            }
        }
        graphs.push(locks::graph(spec, component, None));
    }
    let part = |component| system::Part { spec, component, number: 0 };
    let parts: Vec<system::Part> = components.into_iter().map(part).collect();
    if !parts.is_empty() {
        for interrupts in [false, true] {
            let options = system::Options { services: 6, interrupts, ..system::Options::default() };
            graphs.push(system::graph(&parts, &options));
        }
    }
    graphs
}

/// The system of several specifications, each component once.
fn system_of(units: &[(Utf8PathBuf, UnitResult)]) -> Graph {
    let mut parts: Vec<system::Part> = Vec::new();
    for (number, (_, unit)) in units.iter().enumerate() {
        for component in &unit.spec.components {
            let known = parts.iter().any(|part| part.component.name == component.name);
            if component.kind == ComponentKind::Component && !known {
                parts.push(system::Part { spec: &unit.spec, component, number });
            }
        }
    }
    let options = system::Options { services: 6, ..system::Options::default() };
    system::graph(&parts, &options)
}

fn assert_readable(graph: &Graph) {
    let placed = layout(graph);
    assert_eq!(problems(graph, &placed), Vec::<String>::new(), "{}", graph.title);
    for theme in [Theme::Auto, Theme::Light, Theme::Dark, Theme::Editor] {
        let text = svg(graph, &placed, theme);
        assert_eq!(text, svg(graph, &layout(graph), theme), "{}", graph.title);
        let document = roxmltree::Document::parse(&text).expect("well-formed XML");
        let named = |node: &roxmltree::Node| {
            node.attribute("aria-label").is_some_and(|attribute| !attribute.is_empty())
        };
        let nodes = document.descendants().filter(|node| node.has_attribute("data-id"));
        let nodes: Vec<_> = nodes.collect();
        assert_eq!(nodes.len(), graph.nodes.len());
        assert!(nodes.iter().all(named), "{}", graph.title);
    }
    assert!(dot(graph).ends_with("}\n"));
    assert!(mermaid(graph).starts_with("flowchart "));
}

#[test]
fn every_machine_and_system_of_published_specifications_is_readable() {
    let Some(corpus) = dotgen_loaders::shared("corpus") else {
        return;
    };
    let mut count = 0;
    for directory in ["components", "quadcopter", "robnav"] {
        let units = units(&corpus.join(directory));
        assert_readable(&system_of(&units));
        for (_, unit) in units {
            for graph in pictures(&unit) {
                assert_readable(&graph);
                count += 1;
            }
        }
    }
    assert!(count > 100, "{count} pictures");
}

#[test]
fn pictures_of_the_examples() {
    for entry in std::fs::read_dir(root().join("examples")).expect("examples") {
        let directory = entry.expect("an entry").path();
        if !directory.is_dir() {
            continue;
        }
        let units = units(&directory);
        assert_readable(&system_of(&units));
        for (file, unit) in units {
            for (number, graph) in pictures(&unit).iter().enumerate() {
                assert_readable(graph);
                let example = directory.file_name().unwrap_or_default().to_string_lossy();
                let name = format!("{example}-{}-{number}", file.file_stem().unwrap_or_default());
                insta::assert_snapshot!(name, svg(graph, &layout(graph), Theme::Light));
            }
        }
    }
}

#[test]
fn images_need_no_fonts_of_the_system() {
    let examples = root().join("examples/maneuver");
    let (_, unit) = units(&examples)
        .into_iter()
        .find(|unit| unit.0.ends_with("maneuver.gen"))
        .expect("the example");
    let graph = &pictures(&unit)[0];
    let placed = layout(graph);
    let light = png(graph, &placed, Theme::Light).expect("an image");
    let dark = png(graph, &placed, Theme::Dark).expect("an image");
    assert!(light.starts_with(b"\x89PNG"));
    assert_ne!(light, dark);
    // Texts are drawn: without them the image differs.
    let mut empty = graph.clone();
    for node in &mut empty.nodes {
        for line in &mut node.lines {
            line.text = " ".repeat(line.text.len());
        }
    }
    assert_ne!(png(&empty, &placed, Theme::Light).expect("an image"), light);
}
