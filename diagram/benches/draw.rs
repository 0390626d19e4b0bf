//! Layout and rendering times.

use divan::Bencher;
use dotgen_diagram::graph::{Direction, Edge, Graph, Line, LineStyle, Node, Shape};
use dotgen_diagram::layout::layout;
use dotgen_diagram::render::svg::svg;
use dotgen_diagram::theme::Theme;

fn main() {
    divan::main();
}

/// A machine of `n` states: a chain with jumps back, self loops and pauses.
fn machine(n: usize) -> Graph {
    let mut graph = Graph::default();
    for i in 0..n {
        graph.nodes.push(Node {
            id: format!("s{i}"),
            lines: vec![
                Line::new(LineStyle::Title, format!("state{i}")),
                Line::new(LineStyle::Code, format!("codel_number_{i}")),
            ],
            ..Node::default()
        });
        let mut edge = |to: usize, label: &str| {
            graph.edges.push(Edge {
                from: format!("s{i}"),
                to: format!("s{to}"),
                label: label.into(),
                ..Edge::default()
            });
        };
        edge((i + 1) % n, "");
        edge(i, "pause");
        if i % 3 == 0 {
            edge((i * 7 + 3) % n, "pause");
        }
    }
    graph
}

#[divan::bench(args = [4, 12, 40])]
fn layout_and_render(bencher: Bencher, states: usize) {
    let graph = machine(states);
    bencher.bench(|| svg(&graph, &layout(&graph), Theme::Auto));
}

/// A system of `n` components. Each writes two ports, reads two ports of the components before it and one of
/// a component after it, as controllers do.
fn system(n: usize) -> Graph {
    let mut graph = Graph { direction: Direction::Right, ..Graph::default() };
    let edge = |edges: &mut Vec<Edge>, from: String, to: String| {
        edges.push(Edge { from, to, ..Edge::default() });
    };
    for i in 0..n {
        let mut lines = vec![Line::new(LineStyle::Title, format!("component{i}"))];
        for j in 0..8 {
            lines.push(Line::new(LineStyle::Code, format!("service_{j}()")));
        }
        graph.nodes.push(Node {
            id: format!("c{i}"),
            shape: Shape::Card,
            lines,
            ..Node::default()
        });
        for port in ["a", "b"] {
            graph.nodes.push(Node {
                id: format!("c{i}.{port}"),
                shape: Shape::Octagon,
                lines: vec![Line::new(LineStyle::Title, format!("port_{port}"))],
                ..Node::default()
            });
            edge(&mut graph.edges, format!("c{i}"), format!("c{i}.{port}"));
        }
    }
    for i in 1..n {
        edge(&mut graph.edges, format!("c{}.a", i / 2), format!("c{i}"));
        edge(&mut graph.edges, format!("c{}.b", (i * 5 + 1) % i), format!("c{i}"));
        if i % 5 == 0 {
            edge(&mut graph.edges, format!("c{i}.b"), format!("c{}", i - 3));
        }
    }
    graph
}

#[divan::bench(args = [5, 50])]
fn layout_and_render_system(bencher: Bencher, components: usize) {
    let graph = system(components);
    bencher.bench(|| svg(&graph, &layout(&graph), Theme::Auto));
}
