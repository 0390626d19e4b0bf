//! Line charts with a logarithmic scale, in the style of the other pictures of the documentation.

use std::collections::BTreeSet;
use std::fmt::Write;

/// A chart over whole numbers.
pub(crate) struct Chart<'a> {
    pub(crate) title: &'a str,
    /// The quantity on the horizontal axis.
    pub(crate) across: &'a str,
    /// Labels of powers of ten, ascending: the smallest that is shown, and those above it.
    pub(crate) powers: &'a [(f64, &'a str)],
    /// True if the horizontal axis is logarithmic too.
    pub(crate) ratios: bool,
    pub(crate) lines: Vec<Line<'a>>,
}

/// A line, with its name at its end.
pub(crate) struct Line<'a> {
    pub(crate) name: &'a str,
    pub(crate) points: Vec<(usize, f64)>,
}

const WIDTH: f64 = 640.0;
const HEIGHT: f64 = 320.0;
/// The left side of the area for lines.
const LEFT: f64 = 64.0;
const RIGHT: f64 = 490.0;
const TOP: f64 = 44.0;
const BOTTOM: f64 = 272.0;
/// Minimum distance between the names of lines.
const NAME: f64 = 15.0;

const STYLE: &str = "\
text{fill:#1f2328;font:11px system-ui,'Segoe UI',Ubuntu,'DejaVu Sans',sans-serif}
.ground{fill:#ffffff}
.title{font-size:13px;font-weight:600}
.scale{fill:#656d76}
.rule{stroke:#656d76;stroke-width:1;opacity:.25}
.l0{--c:#0550ae}.l1{--c:#bc4c00}.l2{--c:#656d76}.l3{--c:#8250df}
.line{fill:none;stroke:var(--c);stroke-width:1.8;stroke-linejoin:round}
.point,.name{fill:var(--c)}
.l1 .line{stroke-dasharray:7 3}.l2 .line{stroke-dasharray:2 3}.l3 .line{stroke-dasharray:9 3 2 3}
@media (prefers-color-scheme:dark){
text{fill:#e6edf3}
.ground{fill:#1e1e1e}
.scale{fill:#9198a1}
.rule{stroke:#9198a1}
.l0{--c:#79b8ff}.l1{--c:#ffa657}.l2{--c:#9198a1}.l3{--c:#d2a8ff}
.point,.name{fill:var(--c)}
}
";

impl Chart<'_> {
    /// The picture.
    pub(crate) fn svg(&self) -> String {
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
             viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{title}\">\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n\
             <rect class=\"ground\" width=\"{WIDTH}\" height=\"{HEIGHT}\"/>\n\
             <text class=\"title\" x=\"16\" y=\"24\">{title}</text>\n",
            title = self.title
        );
        for (value, name) in self.powers {
            let y = self.y(*value);
            let _ = writeln!(
                out,
                "<path class=\"rule\" d=\"M{LEFT} {y:.1}H{RIGHT}\"/>\
                 <text class=\"scale\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{name}</text>",
                LEFT - 8.0,
                y + 4.0
            );
        }
        let sizes = self.lines.iter().flat_map(|line| &line.points).map(|point| point.0);
        for size in sizes.collect::<BTreeSet<usize>>() {
            let _ = writeln!(
                out,
                "<text class=\"scale\" x=\"{:.1}\" y=\"{}\" text-anchor=\"middle\">{size}</text>",
                self.x(size),
                BOTTOM + 18.0
            );
        }
        let _ = writeln!(
            out,
            "<text class=\"scale\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            f64::midpoint(LEFT, RIGHT),
            BOTTOM + 36.0,
            self.across
        );
        let names = self.names();
        for (number, (line, name)) in std::iter::zip(&self.lines, names).enumerate() {
            let _ = write!(out, "<g class=\"l{number}\"><path class=\"line\" d=\"");
            for (i, &(size, value)) in line.points.iter().enumerate() {
                let letter = if i == 0 { 'M' } else { 'L' };
                let _ = write!(out, "{letter}{:.1} {:.1}", self.x(size), self.y(value));
            }
            out.push_str("\"/>");
            for &(size, value) in &line.points {
                let _ = write!(
                    out,
                    "<circle class=\"point\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.6\"/>",
                    self.x(size),
                    self.y(value)
                );
            }
            let end = line.points.last().map_or(LEFT, |point| self.x(point.0));
            let _ = writeln!(
                out,
                "<text class=\"name\" x=\"{:.1}\" y=\"{:.1}\">{}</text></g>",
                end + 9.0,
                name + 4.0,
                line.name
            );
        }
        out.push_str("</svg>\n");
        out
    }

    /// Heights of the names: at the ends of their lines, moved apart.
    fn names(&self) -> Vec<f64> {
        let end = |line: &Line| line.points.last().map_or(BOTTOM, |point| self.y(point.1));
        let mut heights: Vec<f64> = self.lines.iter().map(end).collect();
        let mut order: Vec<usize> = (0..heights.len()).collect();
        order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
        for pair in order.windows(2) {
            heights[pair[1]] = heights[pair[1]].max(heights[pair[0]] + NAME);
        }
        heights
    }

    fn range(&self) -> (usize, usize) {
        let sizes = self.lines.iter().flat_map(|line| &line.points).map(|point| point.0);
        let last = sizes.clone().max().unwrap_or(1);
        (sizes.min().unwrap_or(0), last)
    }

    fn x(&self, size: usize) -> f64 {
        let (first, last) = self.range();
        let part = match self.ratios {
            true => (size as f64 / first as f64).ln() / (last as f64 / first as f64).ln().max(1e-9),
            false => (size - first) as f64 / (last - first).max(1) as f64,
        };
        LEFT + 10.0 + part * (RIGHT - LEFT - 20.0)
    }

    fn y(&self, value: f64) -> f64 {
        let scale = |value: f64| value.log10();
        let low = scale(self.powers[0].0);
        let high = scale(self.powers[self.powers.len() - 1].0);
        let part = (scale(value.max(self.powers[0].0)) - low) / (high - low);
        BOTTOM - part * (BOTTOM - TOP)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(lines: Vec<Line>) -> String {
        let powers = &[(1.0, "1"), (10.0, "10"), (100.0, "100")];
        Chart { title: "t", across: "n", powers, ratios: false, lines }.svg()
    }

    #[test]
    fn a_power_of_ten_is_on_its_rule_and_less_than_the_least_at_the_bottom() {
        let svg = chart(vec![Line { name: "a", points: vec![(1, 0.2), (2, 10.0), (3, 100.0)] }]);
        let middle = f64::midpoint(TOP, BOTTOM);
        assert!(
            svg.contains(&format!("d=\"M74.0 {BOTTOM:.1}L277.0 {middle:.1}L480.0 {TOP:.1}\"")),
            "{svg}"
        );
    }

    #[test]
    fn names_of_lines_that_end_together_are_moved_apart() {
        let line = |name| Line { name, points: vec![(1, 10.0)] };
        let svg = chart(vec![line("a"), line("b")]);
        let height = |name: &str| -> f64 {
            let at = svg.find(&format!(">{name}</text></g>")).unwrap();
            let y = svg[..at].rfind(" y=\"").unwrap() + 4;
            svg[y..at].trim_end_matches('"').parse().unwrap()
        };
        assert!(height("b") - height("a") >= NAME);
    }
}
