//! Large pictures, and pictures with elements that the reader opened, moved or selected.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Arc;

use camino::Utf8Path;
use dotgen_analysis::host::{AnalysisHost, Change, UnitResult};
use dotgen_analysis::host::{FileContent, Loader, PackageFlags};
use dotgen_analysis::model::ComponentKind;
use dotgen_diagram::graph::{Direction, Edge, Graph, Line, LineStyle, MARKED, Node, Shape};
use dotgen_diagram::layout::{Layout, Point, layout, layout_within, moved};
use dotgen_diagram::render::svg::svg;
use dotgen_diagram::theme::Theme;
use dotgen_diagram::{fsm, locks, system};

use crate::suite::geometry::problems;

struct Text(String);

impl Loader for Text {
    fn read(&self, _: &Utf8Path) -> FileContent {
        FileContent::Text(self.0.clone())
    }

    fn packages(&self, _: &[String]) -> Result<PackageFlags, String> {
        Ok(PackageFlags::default())
    }
}

fn unit(text: &str) -> UnitResult {
    let path = Utf8Path::new("/large.gen");
    let mut host = AnalysisHost::new(Arc::new(Text(text.to_owned())));
    host.apply(Change { roots: Some(vec![path.to_owned()]), ..Change::default() });
    let unit = host.analysis().root_unit(path).expect("nothing cancels it");
    assert!(unit.accepted(), "{:?}", unit.diagnostics.first());
    unit
}

const ABOUT: &str = "version \"1\"; lang \"c\"; email \"a@b\";";

/// A system of this many components. Each reads the port of the one before it, and some read one far away.
fn chain(components: usize) -> UnitResult {
    let mut text = "struct s { long x; };\n".to_owned();
    for component in 0..components {
        let _ = write!(text, "component c{component} {{ {ABOUT} port out s p{component};");
        if component > 0 {
            let _ = write!(text, " port in s p{};", component - 1);
        }
        if component > 9 && component % 5 == 0 {
            let _ = write!(text, " port in s p{};", component - 9);
        }
        let reads = if component > 0 { format!(", in p{}", component - 1) } else { String::new() };
        let _ = writeln!(
            text,
            " task t {{ period 10 ms; codel<start> c{component}_t(out p{component}{reads}) wcet 1 ms yield pause::start; }};\n\
               activity f{component}() {{ task t; codel<start> c{component}_f(out p{component}) yield ether; }}; }};"
        );
    }
    unit(&text)
}

fn of_system(unit: &UnitResult, options: &system::Options) -> Graph {
    let components = unit.spec.components.iter();
    let parts: Vec<system::Part> = components
        .filter(|component| component.kind == ComponentKind::Component)
        .map(|component| system::Part { spec: &unit.spec, component, number: 0 })
        .collect();
    system::graph(&parts, options)
}

fn assert_readable(graph: &Graph) -> Layout {
    let placed = layout(graph);
    assert_eq!(problems(graph, &placed), Vec::<String>::new(), "{}", graph.title);
    placed
}

fn lines(graph: &Graph, id: &str) -> Vec<String> {
    let node = graph.nodes.iter().find(|node| node.id == id).expect("a node");
    node.lines.iter().map(|line| line.text.clone()).collect()
}

#[test]
fn fifty_components_are_closed_and_readable() {
    let unit = chain(50);
    let mut options = system::Options { services: 6, ..system::Options::default() };
    let graph = of_system(&unit, &options);
    assert_readable(&graph);
    assert_eq!(lines(&graph, "c7"), ["c7", "1 task · 1 service · 2 ports"]);
    // One of them is opened, in place.
    options.opened.insert("c7".to_owned(), true);
    let graph = of_system(&unit, &options);
    assert_readable(&graph);
    let open = ["c7", "in p6: s", "out p7: s", "task t · 10 ms", "f7()"];
    let mut said = lines(&graph, "c7");
    said.sort();
    let mut open = open.map(str::to_owned).to_vec();
    open.sort();
    assert_eq!(said, open);
    assert_eq!(lines(&graph, "c8").len(), 2);
}

#[test]
fn a_small_system_is_summed_up_until_something_is_closed() {
    let unit = chain(3);
    let mut options = system::Options { services: 6, ..system::Options::default() };
    assert_eq!(lines(&of_system(&unit, &options), "c1"), ["c1", "task t · 10 ms", "f1()"]);
    options.opened.insert("c1".to_owned(), false);
    assert_eq!(lines(&of_system(&unit, &options), "c1"), ["c1", "1 task · 1 service · 2 ports"]);
}

#[test]
fn what_is_listed_leads_to_its_own_place() {
    let unit = chain(2);
    let options = system::Options {
        opened: BTreeMap::from([("c1".to_owned(), true)]),
        ..system::Options::default()
    };
    let graph = of_system(&unit, &options);
    let node = graph.nodes.iter().find(|node| node.id == "c1").expect("a node");
    let places: Vec<_> = node.lines.iter().skip(1).map(|line| line.origin).collect();
    assert!(places.iter().all(|place| place.is_some() && *place != node.origin), "{places:?}");
    let text = svg(&graph, &layout(&graph), Theme::Light);
    assert!(text.contains("data-line=\"1\" tabindex=\"0\" role=\"link\""), "{text}");
}

#[test]
fn a_layer_says_who_takes_turns_at_a_port() {
    let unit = chain(2);
    let options = system::Options { locks: true, ..system::Options::default() };
    let graph = of_system(&unit, &options);
    assert_eq!(lines(&graph, "c0.p0"), ["p0", "3 codels take turns, ≤ 1 ms each"]);
    // A resource that is used within one component only is not shared with another.
    assert_eq!(lines(&graph, "c1.p1"), ["p1"]);
    assert_readable(&graph);
}

#[test]
fn a_layer_shows_a_chain_of_data() {
    let unit = chain(3);
    let chain = system::Chain {
        ports: [("c1", "p0"), ("c2", "p1")].map(|(c, p)| (c.to_owned(), p.to_owned())).to_vec(),
        says: "age: 20 ms".to_owned(),
    };
    let graph =
        of_system(&unit, &system::Options { chains: vec![chain], ..system::Options::default() });
    let marked = |classes: &[String]| classes.iter().any(|class| class == MARKED);
    let nodes: Vec<&str> = graph
        .nodes
        .iter()
        .filter(|node| marked(&node.classes))
        .map(|node| node.id.as_str())
        .collect();
    assert_eq!(nodes, ["c0.p0", "c1", "c1.p1"]);
    let edges = graph.edges.iter().filter(|edge| marked(&edge.classes));
    let edges: Vec<String> = edges.map(|edge| format!("{} {}", edge.from, edge.to)).collect();
    assert_eq!(edges, ["c1 c1.p1", "c0.p0 c1"]);
    assert_eq!(graph.notes, ["age: 20 ms"]);
}

#[test]
fn what_was_moved_is_there_and_its_edges_follow() {
    let unit = chain(4);
    let graph = of_system(&unit, &system::Options::default());
    let before = layout(&graph);
    let at = |id: &str| graph.nodes.iter().position(|node| node.id == id).expect("a node");
    let mut by = vec![Point::default(); graph.nodes.len()];
    by[at("c1")] = Point { x: -30.0, y: 400.0 };
    by[at("c1.p1")] = by[at("c1")];
    let after = moved(&graph, before.clone(), &by);
    assert_eq!(problems(&graph, &after), Vec::<String>::new());
    let shift = |placed: &Layout| placed.nodes[at("c1")].y - placed.nodes[at("c0")].y;
    assert!((shift(&after) - shift(&before) - 400.0).abs() < 0.2);
    assert!(after.height > before.height + 200.0);
    assert_eq!(moved(&graph, before.clone(), &[]), before);
}

/// This many codels in three tasks, which share a dozen fields.
fn sharing(codels: usize) -> UnitResult {
    let fields: String = (0..12).map(|number| format!("long x{number}; ")).collect();
    let mut text = format!("component big {{ {ABOUT} ids {{ {fields} }};\n");
    for task in 0..3 {
        let _ = writeln!(
            text,
            "task t{task} {{ period 10 ms; codel<start> t{task}_s(inout x{task}) yield pause::start; }};"
        );
    }
    for codel in 0..codels {
        let (task, a, b) = (codel % 3, codel % 12, (codel / 2) % 12);
        let both = if a == b { String::new() } else { format!(", out x{b}") };
        let _ = writeln!(
            text,
            "activity a{codel}() {{ task t{task}; codel<start> a{codel}_s(inout x{a}{both}) yield ether; }};"
        );
    }
    text += "};\n";
    unit(&text)
}

#[test]
fn many_codels_that_exclude_each_other_are_no_column() {
    for codels in [24, 45, 90] {
        let unit = sharing(codels);
        let graph = locks::graph(&unit.spec, &unit.spec.components.raw[0], None);
        let placed = assert_readable(&graph);
        assert_eq!(graph.nodes.iter().filter(|node| node.group.is_some()).count(), codels + 3);
        let shape = placed.height / placed.width;
        assert!(
            codels < 30 || shape < 2.0,
            "{codels} codels: {} by {}",
            placed.width,
            placed.height
        );
    }
}

const LIFT: &str = "component lift { ABOUT ids { double h; };
  task move { period 10 ms;
    codel<start> l_start(out h) wcet 1 ms yield up, down;
    codel<up> l_up(inout h) wcet 2 ms yield wait, top;
    codel<down> l_down(inout h) yield wait;
    codel<wait> l_wait(inout h) wcet 500 us yield pause::up, ether;
    codel<top> l_top(inout h) wcet 4 ms yield wait;
  };
};";

/// The note about a path, and the marked states.
fn way(states: &[&str]) -> (Option<String>, Vec<String>, Vec<String>) {
    let unit = unit(&LIFT.replace("ABOUT", ABOUT));
    let component = &unit.spec.components.raw[0];
    let owner = component.machines().next().expect("a machine");
    let way = states.iter().map(|state| (*state).to_owned()).collect();
    let options = fsm::Options { way, ..fsm::Options::default() };
    let graph = fsm::graph(&unit.spec, component, owner, options).expect("a machine");
    assert_readable(&graph);
    let marked = |classes: &[String]| classes.iter().any(|class| class == MARKED);
    let note = graph.notes.iter().find(|note| note.contains('→')).cloned();
    let nodes = graph.nodes.iter().filter(|node| marked(&node.classes)).map(|node| node.id.clone());
    let edges = graph.edges.iter().filter(|edge| marked(&edge.classes));
    (note, nodes.collect(), edges.map(|edge| format!("{} {}", edge.from, edge.to)).collect())
}

#[test]
fn a_way_says_its_longest_time() {
    let (note, nodes, edges) = way(&["start", "wait"]);
    assert_eq!(note.as_deref(), Some("start → wait: at most 7.5 ms of execution"));
    assert_eq!(nodes, ["start", "up", "wait", "top"]);
    assert_eq!(edges, ["start up", "up top", "top wait"]);
    // A path that the reader selected step by step is unchanged.
    let (note, _, edges) = way(&["start", "up", "wait"]);
    assert_eq!(note.as_deref(), Some("start → up → wait: at most 3.5 ms of execution"));
    assert_eq!(edges, ["start up", "up wait"]);
}

#[test]
fn a_way_counts_pauses_and_what_is_unknown() {
    let (note, ..) = way(&["up", "up"]);
    assert_eq!(note.as_deref(), Some("up → up: at most 8.5 ms of execution, 1 pause"));
    let (note, ..) = way(&["down", "wait", "ether"]);
    assert_eq!(
        note.as_deref(),
        Some("down → wait → ether: at most 500 µs of execution, + unknown")
    );
}

#[test]
fn a_way_that_is_none_or_endless_says_so() {
    let (note, _, edges) = way(&["top", "start"]);
    assert_eq!(note.as_deref(), Some("top → start: no way leads from top to start"));
    assert!(edges.is_empty());
    let (note, ..) = way(&["start", "ether"]);
    let note = note.expect("a note");
    assert!(note.starts_with("start → ether: no longest time, it can go round "), "{note}");
    // One state is not a path yet, but it is marked.
    let (note, nodes, _) = way(&["up"]);
    assert_eq!((note, nodes), (None, vec!["up".to_owned()]));
}

/// A system of components in chains, each with an output port that two others read.
fn fleet(components: usize) -> Graph {
    let node = |id: String, shape| Node {
        lines: vec![Line::new(LineStyle::Title, id.clone())],
        id,
        shape,
        ..Node::default()
    };
    let edge = |from: String, to: String| Edge { from, to, ..Edge::default() };
    let mut graph = Graph { direction: Direction::Right, ..Graph::default() };
    for component in 0..components {
        let (own, port) = (format!("component{component}"), format!("component{component}.out"));
        graph.nodes.push(node(own.clone(), Shape::Card));
        graph.nodes.push(node(port.clone(), Shape::Octagon));
        graph.edges.push(edge(own, port.clone()));
        for reader in [component + 1, component + 7].into_iter().filter(|&to| to < components) {
            graph.edges.push(edge(port.clone(), format!("component{reader}")));
        }
    }
    graph
}

#[test]
fn a_wide_system_is_drawn_in_rows_of_its_pane_with_letters_of_nine_pixels() {
    for (components, pane) in [(5, 700.0), (50, 1400.0)] {
        let graph = fleet(components);
        let sideways = layout(&graph);
        let rows = layout_within(&graph, pane);
        let letters = 11.0 * (pane / rows.width).min(1.0);
        assert!(letters >= 9.0, "{components}: {letters}");
        assert!(rows.width < sideways.width, "{components}");
        assert_eq!(problems(&graph, &rows), Vec::<String>::new());
        // In a pane that is wide enough, nothing changes.
        assert_eq!(layout_within(&graph, sideways.width), sideways);
    }
}
