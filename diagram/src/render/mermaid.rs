//! Mermaid, for editors and pages that render it themselves.

use std::fmt::Write;

use rustc_hash::FxHashMap;

use crate::graph::{Direction, Edge, Graph, LineStyle, Node, Shape};

/// Writes a graph as a Mermaid flow chart.
pub fn mermaid(graph: &Graph) -> String {
    let direction = if graph.direction == Direction::Right { "LR" } else { "TD" };
    let mut out = format!("flowchart {direction}\n");
    let ids: FxHashMap<&str, String> = graph
        .nodes
        .iter()
        .enumerate()
        .map(|(i, node)| (node.id.as_str(), format!("n{i}")))
        .collect();
    let mut nodes: Vec<_> = graph.nodes.iter().collect();
    // Nodes of one group are consecutive, in a subgraph.
    nodes.sort_by_key(|node| {
        let group = node.group.as_deref()?;
        graph.nodes.iter().position(|node| node.group.as_deref() == Some(group))
    });
    let mut open_group: Option<&str> = None;
    for node in nodes {
        if node.group.as_deref() != open_group {
            if open_group.is_some() {
                out.push_str("  end\n");
            }
            open_group = node.group.as_deref();
            if let Some(group) = open_group {
                let _ =
                    writeln!(out, "  subgraph {}_[\"{}\"]", ids[node.id.as_str()], escape(group));
            }
        }
        write_node(node, &ids[node.id.as_str()], &mut out);
    }
    if open_group.is_some() {
        out.push_str("  end\n");
    }
    for edge in &graph.edges {
        let (Some(from), Some(to)) = (ids.get(edge.from.as_str()), ids.get(edge.to.as_str()))
        else {
            continue;
        };
        write_edge(edge, from, to, &mut out);
    }
    out
}

fn write_node(node: &Node, id: &str, out: &mut String) {
    let text: Vec<String> = node
        .lines
        .iter()
        .map(|line| match line.style {
            LineStyle::Title => format!("<b>{}</b>", escape(&line.text)),
            LineStyle::Code | LineStyle::Detail => escape(&line.text),
        })
        .collect();
    let text = text.join("<br>");
    let (open, close) = match node.shape {
        Shape::Box => ("(", ")"),
        Shape::Card => ("[", "]"),
        Shape::Final | Shape::Pill => ("([", "])"),
        Shape::Initial | Shape::Interrupt => ("((", "))"),
        Shape::Octagon => ("{{", "}}"),
    };
    let text = if text.is_empty() { " ".to_owned() } else { text };
    let _ = writeln!(out, "  {id}{open}\"{text}\"{close}");
}

fn write_edge(edge: &Edge, from: &str, to: &str, out: &mut String) {
    let dashed = edge.classes.iter().any(|c| c == "paused" || c == "interrupt" || c == "throw");
    let arrow = match (edge.both_ways, dashed) {
        (true, _) => "<-->",
        (false, true) => "-.->",
        (false, false) => "-->",
    };
    if edge.label.is_empty() {
        let _ = writeln!(out, "  {from} {arrow} {to}");
    } else {
        let _ = writeln!(out, "  {from} {arrow}|\"{}\"| {to}", escape(&edge.label));
    }
}

/// Text for a quoted label. Mermaid has entities of its own (`#35;`), and takes backticks for Markdown.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '#' => out.push_str("#35;"),
            '`' => out.push_str("#96;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
