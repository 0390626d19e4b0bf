//! Timelines: intervals of execution and waiting.
//!
//! One lane for each core or task, bars for intervals, marks for instants. Times are integers in one unit, so
//! a timeline of the verifier is drawn exactly.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use crate::render::svg::{escape, number};
use crate::text;
use crate::theme::{self, Theme};

/// A timeline to draw.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Timeline {
    /// Title.
    pub title: String,
    /// Name of the unit of all times (`ms`).
    pub unit: String,
    /// First instant shown.
    #[serde(default)]
    pub start: u64,
    /// Last instant shown.
    pub end: u64,
    /// Lanes, top to bottom.
    pub lanes: Vec<Lane>,
    /// Lines of text below the picture.
    pub notes: Vec<String>,
}

/// One row.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Lane {
    /// Text at its left.
    pub name: String,
    /// Intervals.
    pub bars: Vec<Bar>,
    /// Instants.
    pub marks: Vec<Mark>,
}

/// An interval.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bar {
    /// Start, in the timeline's unit.
    pub from: u64,
    /// End, in the timeline's unit (not before the start).
    pub to: u64,
    /// Short text, shown if there is space.
    pub label: String,
    /// One sentence for tooltips and screen readers.
    pub description: String,
    /// The kind.
    pub kind: BarKind,
    /// The target of a click: opaque to this crate.
    pub link: Option<String>,
}

/// The kinds of bars.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BarKind {
    /// A codel executes.
    Run,
    /// Waiting for a core.
    WaitCore,
    /// Waiting for a lock.
    WaitLock,
    /// Time after the deadline.
    Overrun,
}

/// An event at an instant.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Mark {
    /// The instant, in the timeline's unit.
    pub at: u64,
    /// One sentence for tooltips and screen readers.
    pub description: String,
    /// The kind.
    pub kind: MarkKind,
    /// The target of a click: opaque to this crate.
    pub link: Option<String>,
}

/// The kinds of marks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MarkKind {
    /// A period begins.
    Tick,
    /// A request is sent.
    Request,
    /// A job or service ends.
    End,
    /// A deadline is missed, or a bound exceeded.
    Miss,
}

const LANE: f64 = 28.0;
const BAR: f64 = 18.0;
const TOP: f64 = 34.0;
const MARGIN: f64 = 12.0;
/// Width of the time axis, in pixels.
const SPAN: f64 = 760.0;

/// Draws a timeline. Deterministic.
pub fn svg(timeline: &Timeline, theme: Theme) -> String {
    let names = timeline
        .lanes
        .iter()
        .map(|l| text::width(&l.name, text::LABEL))
        .fold(0.0, f64::max);
    let left = (MARGIN + names + 10.0).ceil();
    let start = timeline.start;
    let end = timeline.end.max(start + 1);
    let x = |at: u64| left + (at.clamp(start, end) - start) as f64 / (end - start) as f64 * SPAN;
    let bottom = TOP + LANE * timeline.lanes.len() as f64;
    let notes = text::NOTE.height * timeline.notes.len() as f64;
    let (width, height) = (
        left + SPAN + 2.0 * MARGIN,
        bottom + 26.0 + notes + MARGIN / 2.0,
    );
    let title = escape(&timeline.title);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
         role=\"graphics-document\" aria-label=\"{title}\">\n<title>{title}</title>\n<style>\n{}{}</style>\n\
         <rect class=\"ground\" width=\"{width}\" height=\"{height}\"/>\n",
        theme::style(theme),
        theme::timeline_style(theme),
    );
    let _ = writeln!(
        out,
        "<text class=\"title\" x=\"{MARGIN}\" y=\"20\">{title}</text>"
    );
    let instants = axis(start, end);
    let (unit, per) = axis_unit(&timeline.unit, &instants);
    for at in instants {
        let at_x = number(x(at));
        let _ = writeln!(
            out,
            "<line class=\"grid\" x1=\"{at_x}\" y1=\"{TOP}\" x2=\"{at_x}\" y2=\"{bottom}\"/>"
        );
        let _ = writeln!(
            out,
            "<text class=\"detail\" x=\"{at_x}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            bottom + 14.0,
            at / per
        );
    }
    let unit_y = bottom + 14.0;
    let _ = writeln!(
        out,
        "<text class=\"detail\" x=\"{}\" y=\"{unit_y}\" text-anchor=\"end\">{}</text>",
        left - 10.0,
        escape(unit)
    );
    for (row, lane) in timeline.lanes.iter().enumerate() {
        let top = TOP + LANE * row as f64;
        let middle = top + LANE / 2.0;
        let _ = writeln!(
            out,
            "<g class=\"lane\" role=\"group\" aria-label=\"{}\">",
            escape(&lane.name)
        );
        let _ = writeln!(
            out,
            "<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>",
            left - 10.0,
            middle + 4.0,
            escape(&lane.name)
        );
        let (x1, x2) = (left, left + SPAN);
        let _ = writeln!(
            out,
            "<line class=\"rule\" x1=\"{x1}\" y1=\"{middle}\" x2=\"{x2}\" y2=\"{middle}\"/>"
        );
        for bar in &lane.bars {
            let (from, to) = (x(bar.from), x(bar.to.max(bar.from)));
            // A bar of no duration must be visible too.
            let w = (to - from).max(2.0);
            let class = match bar.kind {
                BarKind::Run => "run",
                BarKind::WaitCore => "wait-core",
                BarKind::WaitLock => "wait-lock",
                BarKind::Overrun => "overrun",
            };
            let text = escape(&bar.description);
            open(
                &mut out,
                &format!("bar {class}"),
                bar.link.as_deref(),
                &text,
            );
            let _ = writeln!(
                out,
                "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{BAR}\" rx=\"2\"/>",
                number(from),
                middle - BAR / 2.0,
                number(w)
            );
            if text::width(&bar.label, text::LABEL) + 6.0 <= w {
                let _ = writeln!(
                    out,
                    "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                    number(from + w / 2.0),
                    middle + 4.0,
                    escape(&bar.label)
                );
            }
            out.push_str("</g>\n");
        }
        for mark in &lane.marks {
            let class = match mark.kind {
                MarkKind::Tick => "tick",
                MarkKind::Request => "request",
                MarkKind::End => "finish",
                MarkKind::Miss => "miss",
            };
            open(
                &mut out,
                &format!("mark {class}"),
                mark.link.as_deref(),
                &escape(&mark.description),
            );
            let at = x(mark.at);
            let (a, b) = (number(at), middle - BAR / 2.0 - 3.0);
            let path = match mark.kind {
                // Arrows: up for a release, down for a completion, as schedules are drawn.
                MarkKind::Tick => format!("M{a} {}V{b}m-3 4l3 -4l3 4", middle + BAR / 2.0 + 2.0),
                MarkKind::End => format!("M{a} {b}V{}m-3 -4l3 4l3 -4", middle + BAR / 2.0 + 2.0),
                MarkKind::Request => format!("M{a} {}l4 -6h-8z", middle - BAR / 2.0 + 2.0),
                MarkKind::Miss => format!("M{} {}l8 8m0 -8l-8 8", number(at - 4.0), middle - 4.0),
            };
            let _ = writeln!(out, "<path d=\"{path}\"/>");
            out.push_str("</g>\n");
        }
        out.push_str("</g>\n");
    }
    for (i, note) in timeline.notes.iter().enumerate() {
        let y = bottom + 26.0 + text::NOTE.height * i as f64 + text::NOTE.size;
        let _ = writeln!(
            out,
            "<text class=\"note\" x=\"{MARGIN}\" y=\"{y}\">{}</text>",
            escape(note)
        );
    }
    out.push_str("</svg>\n");
    out
}

fn open(out: &mut String, class: &str, link: Option<&str>, description: &str) {
    let link = link.map_or(String::new(), |link| {
        format!(" data-link=\"{}\"", escape(link))
    });
    let _ = writeln!(
        out,
        "<g class=\"{class}\"{link} tabindex=\"0\" role=\"graphics-symbol\" aria-label=\"{description}\">\
         <title>{description}</title>"
    );
}

impl Timeline {
    /// The timeline from an instant on.
    pub fn since(mut self, start: u64) -> Timeline {
        self.start = start;
        for lane in &mut self.lanes {
            lane.bars.retain(|it| it.to >= start);
            lane.marks.retain(|it| it.at >= start);
        }
        self
    }
}

/// Round instants for the axis: 1, 2 or 5 times a power of ten, about ten of them at most.
fn axis(start: u64, end: u64) -> Vec<u64> {
    let mut step = 1;
    while (end - start) / step > 10 {
        step = match step.to_string().as_bytes()[0] {
            b'1' => step * 2,
            b'2' => step / 2 * 5,
            _ => step * 2,
        };
    }
    (start.div_ceil(step)..=end / step)
        .map(|i| i * step)
        .collect()
}

/// The unit for the numbers of an axis, and its length in the timeline's units: a larger unit if all instants
/// are whole numbers of it.
fn axis_unit<'u>(unit: &'u str, instants: &[u64]) -> (&'u str, u64) {
    let (mut unit, mut per) = (unit, 1);
    for (small, large) in [("us", "ms"), ("ms", "s")] {
        let step = per * 1000;
        if unit == small && instants.len() > 1 && instants.iter().all(|it| it % step == 0) {
            (unit, per) = (large, step);
        }
    }
    (unit, per)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_short_numbers() {
        assert_eq!(axis_unit("us", &axis(0, 30_000)), ("ms", 1000));
        assert_eq!(axis_unit("us", &axis(0, 9_000)), ("ms", 1000));
        assert_eq!(axis_unit("us", &axis(0, 900)), ("us", 1));
        assert_eq!(axis_unit("us", &axis(0, 30_000_000)), ("s", 1_000_000));
        assert_eq!(axis_unit("x", &axis(0, 30_000)), ("x", 1));
        let timeline = Timeline {
            unit: "us".into(),
            end: 30_000,
            ..Timeline::default()
        };
        let picture = svg(&timeline, Theme::Light);
        assert!(
            picture.contains(">15</text>") && picture.contains(">ms</text>"),
            "{picture}"
        );
    }

    #[test]
    fn axes_are_round_and_short() {
        assert_eq!(axis(0, 7), [0, 1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(axis(0, 47), [0, 5, 10, 15, 20, 25, 30, 35, 40, 45]);
        assert_eq!(axis(0, 1000).len(), 11);
        assert_eq!(axis(0, 0), [0]);
        assert_eq!(axis(991, 1021), [995, 1000, 1005, 1010, 1015, 1020]);
    }

    #[test]
    fn a_part_is_drawn_over_the_whole_width() {
        let bar = |from, to| Bar {
            from,
            to,
            label: String::new(),
            description: format!("{from} to {to}"),
            kind: BarKind::Run,
            link: None,
        };
        let timeline = Timeline {
            end: 200,
            lanes: vec![Lane {
                name: "t".into(),
                bars: vec![bar(0, 50), bar(60, 150), bar(150, 200)],
                marks: vec![],
            }],
            ..Timeline::default()
        };
        let part = timeline.since(100);
        assert_eq!(part.lanes[0].bars.len(), 2);
        let picture = svg(&part, Theme::Light);
        let bars = picture.lines().filter(|it| it.starts_with("<rect x="));
        let widths = bars.filter(|it| it.contains("width=\"380\""));
        assert_eq!(widths.count(), 2, "half of it each: {picture}");
    }

    #[test]
    fn a_bar_without_length_is_drawn() {
        let timeline = Timeline {
            end: 10,
            lanes: vec![Lane {
                name: "core 1".into(),
                bars: vec![Bar {
                    from: 4,
                    to: 4,
                    label: "f".into(),
                    description: "f takes no time".into(),
                    kind: BarKind::Run,
                    link: None,
                }],
                marks: vec![],
            }],
            ..Timeline::default()
        };
        assert!(svg(&timeline, Theme::Light).contains("width=\"2\""));
    }
}
