//! The drawings of UPPAAL (`.xml`): each location is in the layer of its distance from the initial one.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::{conditions, declarations, formulas, invariant, synchronisation, system, updates};
use crate::model::{LocationKind, Network, Process};

/// Distances between locations of a layer, and between layers, in UPPAAL's units.
const WIDTH: usize = 340;
const HEIGHT: usize = 170;

/// Distance between the lines of a label.
const LINE: usize = 17;

/// Position in a drawing.
type Point = (usize, usize);

/// Prints a network and its queries.
pub(super) fn print(network: &Network) -> String {
    let mut out = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<!DOCTYPE nta PUBLIC \
        \"-//Uppaal Team//DTD Flat System 1.1//EN\" \
        \"http://www.it.uu.se/research/group/darts/uppaal/flat-1_1.dtd\">\n<nta>"
        .to_owned();
    let _ = writeln!(out, "<declaration>{}</declaration>", escaped(&declarations(network)));
    let mut id = 0;
    for process in &network.processes {
        template(process, id, &mut out);
        id += process.locations.len();
    }
    let _ = writeln!(out, "<system>{}</system>\n<queries>", escaped(&system(network)));
    for query in &network.queries {
        let comment = escaped(&format!("{}\n{}", query.name, query.comment.join("\n")));
        for formula in formulas(&query.kind) {
            let formula = escaped(&formula);
            let _ = writeln!(
                out,
                "<query><formula>{formula}</formula><comment>{comment}</comment></query>"
            );
        }
    }
    out.push_str("</queries>\n</nta>\n");
    out
}

/// Prints a process. `id`: number of its first location among those of all processes.
fn template(process: &Process, id: usize, out: &mut String) {
    let _ = writeln!(out, "<template><name>{}</name>", escaped(&process.name));
    let _ = writeln!(out, "<declaration>// {}</declaration>", escaped(&process.comment));
    let points = points(process);
    let mut ids = BTreeMap::new();
    for (index, location) in process.locations.iter().enumerate() {
        let (x, y) = points[index];
        ids.insert(&*location.name, (id + index, (x, y)));
        let _ = writeln!(out, "<location id=\"id{}\" x=\"{x}\" y=\"{y}\">", id + index);
        let name = escaped(&location.name);
        let _ = writeln!(out, "<name x=\"{}\" y=\"{}\">{name}</name>", x + LINE, y + LINE);
        let text = invariant(location).unwrap_or_default();
        label("invariant", &text, (x + LINE, y + 2 * LINE), out);
        label("comments", &location.comment, (x + LINE, y + 3 * LINE), out);
        out.push_str(match location.kind {
            LocationKind::Normal => "</location>\n",
            LocationKind::Urgent => "<urgent/></location>\n",
            LocationKind::Committed => "<committed/></location>\n",
        });
    }
    if !process.locations.is_empty() {
        let _ = writeln!(out, "<init ref=\"id{id}\"/>");
    }
    for edge in &process.edges {
        let (Some((source, from)), Some((target, to))) =
            (ids.get(&*edge.source), ids.get(&*edge.target))
        else {
            continue;
        };
        let _ =
            writeln!(out, "<transition><source ref=\"id{source}\"/><target ref=\"id{target}\"/>");
        let (x, mut y) = (from.0.midpoint(to.0), from.1.midpoint(to.1));
        let labels = [
            ("guard", conditions(edge).join("\n&& ")),
            ("synchronisation", synchronisation(edge)),
            ("assignment", updates(edge).join(",\n")),
            ("comments", edge.comment.clone()),
        ];
        for (kind, text) in labels {
            label(kind, &text, (x, y), out);
            y += LINE * text.lines().count();
        }
        out.push_str("</transition>\n");
    }
    out.push_str("</template>\n");
}

/// Prints a label, unless it is empty.
fn label(kind: &str, text: &str, (x, y): Point, out: &mut String) {
    if !text.is_empty() {
        let text = escaped(text);
        let _ = writeln!(out, "<label kind=\"{kind}\" x=\"{x}\" y=\"{y}\">{text}</label>");
    }
}

/// Returns the position of each location. Locations without a path from the initial one are the last layer.
fn points(process: &Process) -> Vec<Point> {
    let mut layers: BTreeMap<&str, usize> = BTreeMap::new();
    let mut next: Vec<&str> =
        process.locations.first().map(|first| &*first.name).into_iter().collect();
    let mut layer = 0;
    while !next.is_empty() {
        for name in std::mem::take(&mut next) {
            if layers.contains_key(name) {
                continue;
            }
            layers.insert(name, layer);
            let edges = process.edges.iter().filter(|edge| edge.source == name);
            next.extend(edges.map(|edge| &*edge.target));
        }
        layer += 1;
    }
    let mut used: BTreeMap<usize, usize> = BTreeMap::new();
    let locations = process.locations.iter();
    locations
        .map(|location| {
            let layer = layers.get(&*location.name).copied().unwrap_or(layer);
            let place = used.entry(layer).or_default();
            *place += 1;
            ((*place - 1) * WIDTH, layer * HEIGHT)
        })
        .collect()
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    // XML has no control characters except these.
    text.chars().filter(|c| !c.is_control() || matches!(c, '\n' | '\t')).collect()
}
