//! Graphviz DOT, for external tools.

use std::fmt::Write;

use crate::graph::{Direction, Edge, Graph, Node, Shape};

/// Writes a graph as DOT.
pub fn dot(graph: &Graph) -> String {
    let mut out = format!("digraph {} {{\n", quote(&graph.title));
    if graph.direction == Direction::Right {
        out.push_str("  rankdir=LR;\n");
    }
    out.push_str("  node [fontname=\"sans-serif\" fontsize=11];\n  edge [fontname=\"sans-serif\" fontsize=10];\n");
    let mut groups: Vec<&str> = Vec::new();
    for group in graph.nodes.iter().filter_map(|node| node.group.as_deref()) {
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    for (i, group) in groups.iter().enumerate() {
        let inside = graph
            .nodes
            .iter()
            .filter(|node| node.group.as_deref() == Some(*group))
            .map(|node| quote(&node.id));
        let _ = writeln!(
            out,
            "  subgraph cluster_{i} {{ label={}; style=rounded; {}; }}",
            quote(group),
            inside.collect::<Vec<_>>().join("; ")
        );
    }
    for node in &graph.nodes {
        write_node(node, &mut out);
    }
    for edge in &graph.edges {
        write_edge(edge, &mut out);
    }
    out.push_str("}\n");
    out
}

fn write_node(node: &Node, out: &mut String) {
    let shape = match node.shape {
        Shape::Box | Shape::Card => "box",
        Shape::Final => "doublecircle",
        Shape::Initial => "point",
        Shape::Interrupt => "circle",
        Shape::Octagon => "octagon",
        Shape::Pill => "ellipse",
    };
    let text: Vec<&str> = node.lines.iter().map(|l| l.text.as_str()).collect();
    let mut style = Vec::new();
    let has = |class: &str| node.classes.iter().any(|c| c == class);
    if node.shape == Shape::Box {
        style.push("rounded");
    }
    if has("unreachable") || has("undefined") || has("async") || has("unconnected") {
        style.push("dashed");
    }
    let _ = write!(out, "  {} [shape={shape} label={}", quote(&node.id), quote(&text.join("\n")));
    if !style.is_empty() {
        let _ = write!(out, " style={}", quote(&style.join(",")));
    }
    if has("unreachable") {
        out.push_str(" color=gray fontcolor=gray");
    }
    if has("undefined") {
        out.push_str(" color=red fontcolor=red");
    }
    out.push_str("];\n");
}

fn write_edge(edge: &Edge, out: &mut String) {
    let _ = write!(out, "  {} -> {}", quote(&edge.from), quote(&edge.to));
    let mut attributes = Vec::new();
    if !edge.label.is_empty() {
        attributes.push(format!("label={}", quote(&edge.label)));
    }
    if edge.classes.iter().any(|c| c == "paused") {
        attributes.push("style=dashed".to_owned());
    } else if edge.classes.iter().any(|c| c == "interrupt" || c == "throw") {
        attributes.push("style=dotted".to_owned());
    }
    if edge.both_ways {
        attributes.push("dir=both".to_owned());
    }
    if !attributes.is_empty() {
        let _ = write!(out, " [{}]", attributes.join(" "));
    }
    out.push_str(";\n");
}

/// A quoted string.
fn quote(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '\\' => out.push_str("\\\\"),
            '"' => out.push_str("\\\""),
            '\n' => out.push_str("\\n"),
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}
