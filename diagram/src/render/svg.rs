//! SVG: one self-contained file, without scripts or external references.
//!
//! Every node and edge is a group that carries its id, its link and a sentence for screen readers,
//! can take the keyboard focus, and is styled by classes only.

use std::fmt::Write;

use crate::graph::{Edge, Graph, LineStyle, Node, Shape};
use crate::layout::{
    CARD_HEADER, EdgePath, Frame, LABEL_HEIGHT, LINE_PADDING, Layout, Point, Rect, octagon,
};
use crate::text;
use crate::theme::{self, Theme};

/// Draws a placed graph.
pub fn svg(graph: &Graph, layout: &Layout, theme: Theme) -> String {
    let (w, h) = (layout.width, layout.height);
    let mut out = Svg { text: String::new(), cut: theme.is_clear().then_some((w, h)), cuts: 0 };
    out.line(&format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
         role=\"graphics-document\" aria-label=\"{}\">",
        escape(&graph.title)
    ));
    out.line(&format!("<title>{}</title>", escape(&graph.title)));
    let marks = if graph.has_marks() { theme::mark_style(theme) } else { String::new() };
    out.line(&format!("<style>\n{}{marks}</style>", theme::style(theme)));
    out.line(&format!("<rect class=\"ground\" width=\"{w}\" height=\"{h}\"/>"));
    for frame in &layout.frames {
        out.frame(frame);
    }
    for (edge, path) in graph.edges.iter().zip(&layout.edges) {
        out.edge(edge, path);
    }
    for (node, rect) in graph.nodes.iter().zip(&layout.nodes) {
        out.node(node, *rect);
    }
    for (note, at) in graph.notes.iter().zip(&layout.notes) {
        out.text("note", Point { x: at.x, y: at.y + text::NOTE.size }, "start", note);
    }
    out.line("</svg>");
    out.text
}

struct Svg {
    text: String,
    /// Size of a picture without a background, in pixels: a label cannot cover its line there, so the line is
    /// cut.
    cut: Option<(f64, f64)>,
    /// Number of lines cut so far.
    cuts: usize,
}

impl Svg {
    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// The frame round a group of nodes, with its name on top.
    fn frame(&mut self, frame: &Frame) {
        let Rect { x, y, width, height } = frame.rect;
        self.line(&format!(
            "<rect class=\"frame\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"8\"/>"
        ));
        let at =
            Point { x: x + width / 2.0, y: y + LABEL_HEIGHT / 2.0 + text::LABEL.size * 0.36 + 1.0 };
        self.text("detail", at, "middle", &frame.name);
    }

    fn node(&mut self, node: &Node, rect: Rect) {
        let mut attributes =
            format!("class=\"node {}\" data-id=\"{}\"", node.classes.join(" "), escape(&node.id));
        if !node.names.is_empty() {
            let _ = write!(attributes, " data-names=\"{}\"", escape(&node.names.join(" ")));
        }
        let label = escape(if node.description.is_empty() { &node.id } else { &node.description });
        // A node with lines that can be focused on their own is more than a symbol.
        let parts = node.lines.iter().any(|line| line.origin.is_some());
        let role = if parts { "graphics-object" } else { "graphics-symbol" };
        self.line(&format!(
            "<g {attributes} tabindex=\"0\" role=\"{role}\" aria-label=\"{label}\"><title>{label}</title>"
        ));
        self.outline(node, rect);
        self.lines(node, rect);
        self.line("</g>");
    }

    fn outline(&mut self, node: &Node, rect: Rect) {
        let Rect { x, y, width, height } = rect;
        let heated = node.classes.iter().any(|c| c.starts_with("heat-"));
        match node.shape {
            Shape::Initial => self.disc("mark", rect, width / 2.0 - 1.0),
            Shape::Interrupt => self.disc("ring", rect, width / 2.0 - 1.0),
            Shape::Pill => {
                let r = (height / 2.0).min(17.0);
                self.line(&format!(
                    "<rect class=\"shape\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
                        rx=\"{r}\"/>"
                ));
            }
            Shape::Octagon => {
                let corners: Vec<String> = octagon(rect)
                    .iter()
                    .map(|p| format!("{},{}", number(p.x), number(p.y)))
                    .collect();
                self.line(&format!("<polygon class=\"shape\" points=\"{}\"/>", corners.join(" ")));
            }
            Shape::Final => {
                let r = height / 2.0;
                self.line(&format!(
                    "<rect class=\"shape\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
                        rx=\"{r}\"/>"
                ));
                let (x, y, width, height, r) =
                    (x + 3.0, y + 3.0, width - 6.0, height - 6.0, r - 3.0);
                self.line(&format!(
                    "<rect class=\"shape\" x=\"{}\" y=\"{}\" width=\"{width}\" height=\"{height}\" \
                        rx=\"{r}\"/>",
                    number(x),
                    number(y)
                ));
            }
            Shape::Box | Shape::Card => {
                let r = if node.shape == Shape::Box { 6.0 } else { 3.0 };
                self.line(&format!(
                    "<rect class=\"shape\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
                        rx=\"{r}\"/>"
                ));
                if heated {
                    self.line(&format!(
                        "<rect class=\"heat\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" \
                            rx=\"{r}\"/>"
                    ));
                }
            }
        }
    }

    fn disc(&mut self, class: &str, rect: Rect, radius: f64) {
        let center = rect.center();
        let (cx, cy) = (number(center.x), number(center.y));
        self.line(&format!("<circle class=\"{class}\" cx=\"{cx}\" cy=\"{cy}\" r=\"{radius}\"/>"));
    }

    fn lines(&mut self, node: &Node, rect: Rect) {
        let total: f64 = node.lines.iter().map(|l| l.style.metrics().height).sum();
        let card = node.shape == Shape::Card && node.lines.len() > 1;
        let mut top = rect.center().y - f64::midpoint(total, if card { CARD_HEADER } else { 0.0 });
        for (i, line) in node.lines.iter().enumerate() {
            let metrics = line.style.metrics();
            let baseline = top + metrics.height / 2.0 + metrics.size * 0.36;
            // The body of a card reads as a list.
            let (x, anchor) = if card && i > 0 {
                (rect.x + LINE_PADDING.0, "start")
            } else {
                (rect.center().x, "middle")
            };
            let class = match line.style {
                LineStyle::Title => "title",
                LineStyle::Code => "code",
                LineStyle::Detail => "detail",
            };
            let at = Point { x, y: baseline };
            match line.origin {
                Some(_) => {
                    let attributes = format!(
                        "class=\"{class} part\" data-line=\"{i}\" tabindex=\"0\" role=\"link\""
                    );
                    self.text_with(&attributes, at, anchor, &line.text);
                }
                None => self.text(class, at, anchor, &line.text),
            }
            top += metrics.height;
            if card && i == 0 {
                let y = number(top + CARD_HEADER / 2.0);
                let (x1, x2) = (rect.x, rect.x + rect.width);
                self.line(&format!(
                    "<line class=\"rule\" x1=\"{x1}\" y1=\"{y}\" x2=\"{x2}\" y2=\"{y}\"/>"
                ));
                top += CARD_HEADER;
            }
        }
    }

    fn text(&mut self, class: &str, at: Point, anchor: &str, text: &str) {
        self.text_with(&format!("class=\"{class}\""), at, anchor, text);
    }

    fn text_with(&mut self, attributes: &str, at: Point, anchor: &str, text: &str) {
        let anchor =
            if anchor == "start" { String::new() } else { format!(" text-anchor=\"{anchor}\"") };
        self.line(&format!(
            "<text {attributes} x=\"{}\" y=\"{}\"{anchor}>{}</text>",
            number(at.x),
            number(at.y),
            escape(text)
        ));
    }

    fn edge(&mut self, edge: &Edge, path: &EdgePath) {
        if path.points.len() < 4 {
            return;
        }
        let attributes = format!(
            "class=\"edge {}\" data-from=\"{}\" data-to=\"{}\"",
            edge.classes.join(" "),
            escape(&edge.from),
            escape(&edge.to)
        );
        let label = escape(&edge.description);
        self.line(&format!(
            "<g {attributes} role=\"graphics-symbol\" aria-label=\"{label}\"><title>{label}</title>"
        ));
        let (first, last) = (path.points[0], path.points[path.points.len() - 1]);
        let (after, before) = (path.points[1], path.points[path.points.len() - 2]);
        let curve = curve(&path.points, edge.both_ways);
        let mask = self.clip_edge(path);
        self.line(&format!("<path class=\"line\"{mask} d=\"{curve}\"/>"));
        let mut heads = head(last, before);
        if edge.both_ways {
            heads.push_str(&head(first, after));
        }
        self.line(&format!("<path class=\"head\" d=\"{heads}\"/>"));
        if let Some(rect) = path.label {
            let at = Point { x: rect.center().x, y: rect.center().y + text::LABEL.size * 0.36 };
            self.text("label", at, "middle", &edge.label);
        }
        self.line("</g>");
    }
}

impl Svg {
    /// Defines the part of an edge that is visible next to its label; returns the attribute that refers to
    /// it.
    fn clip_edge(&mut self, path: &EdgePath) -> String {
        let (Some((w, h)), Some(label)) = (self.cut, path.label) else {
            return String::new();
        };
        self.cuts += 1;
        let id = format!("cut{}", self.cuts);
        let (x, y) = (number(label.x), number(label.y));
        let (width, height) = (number(label.width), number(label.height));
        self.line(&format!(
            "<mask id=\"{id}\" maskUnits=\"userSpaceOnUse\" x=\"0\" y=\"0\" width=\"{w}\" height=\"{h}\">\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#fff\"/>\
             <rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/></mask>"
        ));
        format!(" mask=\"url(#{id})\"")
    }
}

/// Length and half width of an arrow head, in pixels.
const HEAD: (f64, f64) = (9.0, 3.8);

/// A chain of Bézier curves, shortened at one end or both for an arrow head.
fn curve(points: &[Point], both_ways: bool) -> String {
    let last = points.len() - 1;
    let mut points = points.to_vec();
    points[last] = shorten_for_arrow(points[last], points[last - 1]);
    if both_ways {
        points[0] = shorten_for_arrow(points[0], points[1]);
    }
    let n = |p: &Point| format!("{} {}", number(p.x), number(p.y));
    let mut out = format!("M{}", n(&points[0]));
    for piece in points[1..].chunks_exact(3) {
        let _ = write!(out, "C{} {} {}", n(&piece[0]), n(&piece[1]), n(&piece[2]));
    }
    out
}

/// The end of a line that has an arrow head before `tip`.
fn shorten_for_arrow(tip: Point, behind: Point) -> Point {
    let (dx, dy) = (tip.x - behind.x, tip.y - behind.y);
    let length = dx.hypot(dy).max(1e-9);
    let by = (HEAD.0 - 1.0).min(length * 0.9);
    Point { x: tip.x - dx / length * by, y: tip.y - dy / length * by }
}

fn head(tip: Point, behind: Point) -> String {
    let (dx, dy) = (tip.x - behind.x, tip.y - behind.y);
    let length = dx.hypot(dy).max(1e-9);
    let (ux, uy) = (dx / length, dy / length);
    let base = Point { x: tip.x - ux * HEAD.0, y: tip.y - uy * HEAD.0 };
    let n = |x: f64, y: f64| format!("{} {}", number(x), number(y));
    format!(
        "M{}L{}L{}Z",
        n(tip.x, tip.y),
        n(base.x - uy * HEAD.1, base.y + ux * HEAD.1),
        n(base.x + uy * HEAD.1, base.y - ux * HEAD.1)
    )
}

/// One decimal, no trailing zero: stable bytes and no noise in diffs.
pub(crate) fn number(v: f64) -> String {
    let v = (v * 10.0).round() / 10.0;
    if v == 0.0 { "0".to_owned() } else { format!("{v}") }
}

/// Text for XML attributes and content; characters XML cannot hold become U+FFFD.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' => out.push(c),
            c if c < ' ' || c == '\u{FFFE}' || c == '\u{FFFF}' => out.push('\u{FFFD}'),
            c => out.push(c),
        }
    }
    out
}
