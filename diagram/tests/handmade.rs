//! Pictures of hand-made graphs.

use dotgen_diagram::graph::{Edge, Graph, Line, LineStyle, Node, Shape};
use dotgen_diagram::layout::layout;
use dotgen_diagram::render::svg::svg;
use dotgen_diagram::theme::Theme;

use crate::suite::geometry::problems;

/// A machine written as `from -> to [label]` lines; `~>` is a paused transition.
fn machine(text: &str) -> Graph {
    let mut graph = Graph { title: "test".into(), ..Graph::default() };
    for line in text.lines().map(str::trim).filter(|l| !l.is_empty()) {
        let paused = line.contains("~>");
        let (from, rest) = line.split_once(if paused { "~>" } else { "->" }).unwrap();
        let mut words = rest.split_whitespace();
        let (from, to) = (from.trim(), words.next().unwrap());
        for id in [from, to] {
            if graph.nodes.iter().all(|n| n.id != id) {
                let shape = match id {
                    "ether" => Shape::Final,
                    "(entry)" => Shape::Initial,
                    _ => Shape::Box,
                };
                let mut lines = vec![Line::new(LineStyle::Title, id)];
                match shape {
                    Shape::Initial => lines.clear(),
                    Shape::Box => lines.push(Line::new(LineStyle::Code, format!("mv_{id}_codel"))),
                    _ => {}
                }
                graph.nodes.push(Node {
                    id: id.into(),
                    shape,
                    lines,
                    names: vec![id.into()],
                    ..Node::default()
                });
            }
        }
        let mut classes = vec!["transition".to_owned()];
        if paused {
            classes.push("paused".into());
        }
        graph.edges.push(Edge {
            from: from.into(),
            to: to.into(),
            label: words.next().unwrap_or(if paused { "pause" } else { "" }).into(),
            classes,
            ..Edge::default()
        });
    }
    graph
}

const SURVEY: &str = "
    (entry) -> start
    start -> plan
    plan -> exec
    plan -> plan
    plan ~> plan
    exec ~> exec
    exec -> wait
    wait ~> wait
    wait -> ether
    wait -> plan retry
    wait ~> plan
    stop -> ether
    exec -> stop
";

#[test]
fn a_machine_with_loops_and_parallel_edges_is_readable() {
    let graph = machine(SURVEY);
    let placed = layout(&graph);
    assert_eq!(problems(&graph, &placed), Vec::<String>::new());
}

#[test]
fn forty_states_stay_readable() {
    let mut text = String::from("(entry) -> start\nstart -> s0\n");
    for i in 0..40 {
        text.push_str(&format!("s{i} -> s{}\ns{i} ~> s{i}\n", (i * 7 + 3) % 40));
        if i % 3 == 0 {
            text.push_str(&format!("s{i} ~> s{}\n", (i + 1) % 40));
        }
    }
    text.push_str("s39 -> ether\n");
    let graph = machine(&text);
    assert_eq!(problems(&graph, &layout(&graph)), Vec::<String>::new());
}

#[test]
fn the_same_graph_gives_the_same_bytes() {
    let graph = machine(SURVEY);
    let once = svg(&graph, &layout(&graph), Theme::Auto);
    for _ in 0..5 {
        assert_eq!(svg(&graph, &layout(&graph), Theme::Auto), once);
    }
}

#[test]
fn degenerate_graphs_are_drawn() {
    for text in ["", "a -> a", "a ~> a\na -> a\na -> a again"] {
        let graph = machine(text);
        let placed = layout(&graph);
        assert_eq!(problems(&graph, &placed), Vec::<String>::new(), "{text}");
        assert!(svg(&graph, &placed, Theme::Dark).ends_with("</svg>\n"));
    }
}

#[test]
fn text_is_escaped() {
    let mut graph = machine("a -> b");
    graph.title = "<&\"\u{1}>".into();
    let text = svg(&graph, &layout(&graph), Theme::Light);
    assert!(text.contains("<title>&lt;&amp;&quot;\u{FFFD}&gt;</title>"), "{text}");
}

#[test]
fn on_no_ground_a_line_is_cut_where_its_label_stands() {
    let graph = machine("a -> b\na -> c stopped");
    let placed = layout(&graph);
    for theme in [Theme::Neutral, Theme::LightClear, Theme::DarkClear] {
        let text = svg(&graph, &placed, theme);
        assert_eq!(text.matches("<mask id=").count(), 1, "{text}");
        assert!(text.contains("<path class=\"line\" mask=\"url(#cut1)\""), "{text}");
    }
    // Elsewhere the label covers it.
    assert!(!svg(&graph, &placed, Theme::Auto).contains("mask"));
}
