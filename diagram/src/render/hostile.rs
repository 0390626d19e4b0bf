//! Names that contain the syntax of a picture's language.

use super::{dot::dot, mermaid::mermaid, svg::svg};
use crate::graph::{Edge, Graph, Line, LineStyle, Node};
use crate::layout::layout;
use crate::theme::Theme;

const HOSTILE: &[&str] = &[
    "</text><script>alert(1)</script>",
    "\"/><image href=\"http://example.org/x\"/>",
    "a\" onload=\"alert(1)",
    "]]> <!-- & &amp; --> <?x?>",
    "x\"] click n0 \"javascript:alert(1)\"",
    "x\n  evil[\"y\"]",
    "#lt;b#gt; `code`",
    "\\\" ; evil -> x",
    "\u{1b}[31m\u{0}\u{7}",
];

fn graph() -> Graph {
    let node = |(index, text): (usize, &&str)| Node {
        id: format!("{index}{text}"),
        lines: vec![Line::new(LineStyle::Title, *text), Line::new(LineStyle::Detail, *text)],
        description: (*text).to_owned(),
        names: vec![(*text).to_owned()],
        group: Some((*text).to_owned()),
        ..Node::default()
    };
    let nodes: Vec<Node> = HOSTILE.iter().enumerate().map(node).collect();
    let edge = |ends: &[Node]| Edge {
        from: ends[0].id.clone(),
        to: ends[1].id.clone(),
        label: ends[0].description.clone(),
        description: ends[1].description.clone(),
        ..Edge::default()
    };
    Graph {
        title: HOSTILE.concat(),
        edges: nodes.windows(2).map(edge).collect(),
        nodes,
        notes: HOSTILE.iter().map(|text| (*text).to_owned()).collect(),
        ..Graph::default()
    }
}

#[test]
fn an_svg_has_its_own_elements_and_attributes_only() {
    let graph = graph();
    let text = svg(&graph, &layout(&graph), Theme::default());
    let document = roxmltree::Document::parse(&text).expect("XML");
    let elements = [
        "svg", "title", "style", "rect", "g", "text", "path", "line", "circle", "polygon", "mask",
        "defs",
    ];
    for node in document.descendants().filter(roxmltree::Node::is_element) {
        assert!(elements.contains(&node.tag_name().name()), "{node:?}");
        for attribute in node.attributes() {
            assert!(
                !attribute.name().starts_with("on") && attribute.name() != "href",
                "{attribute:?}"
            );
        }
    }
    assert!(!document.descendants().any(|node| node.is_comment() || node.is_pi()));
    let mut texts = document.descendants().filter_map(|node| node.text());
    assert!(texts.any(|text| text.contains("<script>")), "the name is there, as text");
}

#[test]
fn mermaid_has_no_line_and_no_quote_of_a_name() {
    let text = mermaid(&graph());
    assert!(!text.contains("evil[\""), "{text}");
    assert!(!text.contains("<script") && !text.contains("<image"), "{text}");
    for line in text.lines() {
        assert_eq!(line.matches('"').count() % 2, 0, "{line}");
        assert!(!line.contains('`') && !line.contains("#lt;"), "{line}");
        assert!(!line.trim_start().starts_with("click"), "{line}");
    }
}

#[test]
fn dot_strings_end_where_they_end() {
    let text = dot(&graph());
    for line in text.lines() {
        // No part of a name is outside of strings.
        let mut outside = String::new();
        let mut inside = false;
        let mut characters = line.chars();
        while let Some(c) = characters.next() {
            match c {
                '\\' if inside => {
                    characters.next();
                }
                '"' => inside = !inside,
                c if !inside => outside.push(c),
                _ => {}
            }
        }
        assert!(!inside, "{line}");
        for word in ["evil", "script", "alert", "click"] {
            assert!(!outside.contains(word), "{line}");
        }
    }
}
