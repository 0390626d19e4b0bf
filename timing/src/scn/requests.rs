//! The requests of published models, as laboratories keep them beside a specification: a list of services
//! (`NAME.rqst`), or the queue of requests of a client in Fiacre (`NAME.client.fcr`). Both become a client of
//! a scenario.

use std::fmt::Write as _;

use dotgen_analysis::model::{Component, Service};
use dotgen_syntax::suggestion::nearest;

use super::ast::Unit;
use super::times::Malformed;

/// Most requests of a client.
const MAX_REQUESTS: usize = 1000;

/// End of the names of requests in a Fiacre client.
const FIACRE_SUFFIX: &str = "_RQSTID_FCR";

/// The prefix of services in lists that do not name their component.
const ANY_COMPONENT: &str = "cnam";

/// A request of a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ListedRequest {
    /// The name as written, such as `cnam_ColorTrack`.
    pub name: String,
    /// Number of wait cycles after it.
    pub cycles: u64,
    /// The client waits for its final reply at its end.
    pub awaited: bool,
    /// Line of the file, from 1.
    pub line: usize,
}

/// The requests of a file, in order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RequestList {
    pub requests: Vec<ListedRequest>,
    /// Shortest and longest time of a wait cycle, in units of the model.
    pub cycle: (u64, u64),
}

/// A client for a scenario.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ImportedClient {
    /// Its steps, one a line.
    pub steps: Vec<String>,
    /// Messages about the names that were left out: the line, the reason, and a name to write instead.
    pub unknown: Vec<String>,
}

/// Reads a list of requests, or the queue of a Fiacre client.
///
/// # Errors
/// The text is neither, or has too many requests.
pub fn parse(text: &str) -> Result<RequestList, Malformed> {
    let list = if text.contains("{|") { fiacre(text) } else { pairs(text) }?;
    match list.requests.get(MAX_REQUESTS) {
        Some(request) => Err(Malformed {
            line: request.line,
            what: format!("there are more than {MAX_REQUESTS} requests"),
        }),
        None => Ok(list),
    }
}

/// Reads lines of a name and the number of its requests, one after the other.
fn pairs(text: &str) -> Result<RequestList, Malformed> {
    let mut out = RequestList::default();
    for (line, content) in (1..).zip(text.lines()) {
        let words: Vec<&str> =
            content.split('#').next().unwrap_or_default().split_whitespace().collect();
        let malformed = |what: String| Err(Malformed { line, what });
        let (name, count) = match words[..] {
            [] => continue,
            [name, count] => (name, count.parse::<usize>().ok()),
            _ => {
                return malformed(
                    "a line has a service and the number of its requests, as in `cnam_GoTo 1`"
                        .to_owned(),
                );
            }
        };
        let Some(count) = count.filter(|&count| count <= MAX_REQUESTS) else {
            return malformed(format!("`{}` is no number of requests", words[1]));
        };
        let request = ListedRequest { name: name.to_owned(), cycles: 0, awaited: false, line };
        out.requests.extend(std::iter::repeat_n(request, count));
    }
    Ok(out)
}

/// Reads the queue `{| {rqid=…}, … |}` of a Fiacre client, and the time of its wait cycles.
fn fiacre(text: &str) -> Result<RequestList, Malformed> {
    let text = without_comments(text);
    let line_of = |at: usize| text[..at].matches('\n').count() + 1;
    let start = text.find("{|").unwrap_or_default();
    let Some(length) = text[start..].find("|}") else {
        let what = "the queue of requests `{|` has no end `|}`".to_owned();
        return Err(Malformed { line: line_of(start), what });
    };
    if let Some(second) = text[start + length..].find("{|") {
        let what = "there is a second queue of requests; give a file for each client".to_owned();
        return Err(Malformed { line: line_of(start + length + second), what });
    }
    let mut out = RequestList::default();
    let mut at = start + 2;
    while let Some(found) = text[at..start + length].find('{') {
        let begin = at + found;
        let end = text[begin..].find('}').map_or(text.len(), |end| begin + end);
        let record = &text[begin + 1..end.min(start + length).max(begin + 1)];
        let field = |name: &str| {
            let fields = record.split(',').filter_map(|field| field.split_once('='));
            fields.map(|(key, value)| (key.trim(), value.trim())).find(|(key, _)| *key == name)
        };
        let malformed = |what: &str| Err(Malformed { line: line_of(begin), what: what.to_owned() });
        let Some((_, id)) = field("rqid") else { return malformed("a request has no `rqid`") };
        let id = id.rsplit('(').next().unwrap_or(id).trim_end_matches([')', ' ']);
        let cycles = match field("wait_cycle").map(|(_, value)| value.parse::<u64>()) {
            None => 0,
            Some(Ok(cycles)) => cycles,
            Some(Err(_)) => return malformed("`wait_cycle` is no number"),
        };
        out.requests.push(ListedRequest {
            name: id.trim_end_matches(FIACRE_SUFFIX).to_owned(),
            cycles,
            awaited: field("fr").is_some_and(|(_, value)| value == "true"),
            line: line_of(begin),
        });
        at = end.min(start + length);
    }
    match cycle(&text) {
        Some(cycle) => out.cycle = cycle,
        None if out.requests.iter().any(|request| request.cycles > 0) => {
            let what = "the state `wait_after_rqst` has no `wait [MIN,MAX]`, the time of a cycle";
            return Err(Malformed { line: 1, what: what.to_owned() });
        }
        None => {}
    }
    Ok(out)
}

/// Returns the interval of the first `wait` of the state that counts wait cycles.
fn cycle(text: &str) -> Option<(u64, u64)> {
    let state = text.split_once("from wait_after_rqst")?.1;
    let state = state.split("\nfrom ").next()?;
    let interval = state.split_once("wait")?.1.trim_start().strip_prefix('[')?;
    let (lower, rest) = interval.split_once(',')?;
    let (upper, _) = rest.split_once(']')?;
    Some((lower.trim().parse().ok()?, upper.trim().parse().ok()?))
}

/// Returns the text with blanks in place of comments, so that lines stay.
fn without_comments(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('/') {
        out.push_str(&rest[..at]);
        let comment = &rest[at..];
        let end = if comment.starts_with("//") {
            comment.find('\n').unwrap_or(comment.len())
        } else if comment.starts_with("/*") {
            comment.find("*/").map_or(comment.len(), |end| end + 2)
        } else {
            out.push('/');
            rest = &comment[1..];
            continue;
        };
        out.extend(comment[..end].chars().map(|letter| if letter == '\n' { '\n' } else { ' ' }));
        rest = &comment[end..];
    }
    out + rest
}

impl RequestList {
    /// Returns the client that sends the requests to some components. A wait cycle counts in `unit`.
    pub fn client(&self, components: &[&Component], unit: Unit) -> ImportedClient {
        let mut out = ImportedClient::default();
        let mut awaited: Vec<String> = Vec::new();
        for request in &self.requests {
            match find(&request.name, components) {
                Found::Service(component, service) => {
                    let path = format!("{}.{}", component.name, service.name);
                    out.steps.push(format!("send {path};"));
                    if request.awaited && !awaited.contains(&path) {
                        awaited.push(path);
                    }
                }
                Found::Kill(component) => out.steps.push(format!("kill {};", component.name)),
                Found::Several => {
                    let (line, name) = (request.line, &request.name);
                    out.unknown.push(format!(
                        "line {line}: `{name}` is a service of several components; write \
                         COMPONENT_SERVICE"
                    ));
                    continue;
                }
                Found::Unknown(near) => {
                    let mut what =
                        format!("line {}: `{}` is not a service", request.line, request.name);
                    if let Some(near) = near {
                        let _ = write!(what, "; there is `{near}`");
                    }
                    out.unknown.push(what);
                    continue;
                }
            }
            if request.cycles > 0 {
                let [lower, upper] =
                    [self.cycle.0, self.cycle.1].map(|time| time.saturating_mul(request.cycles));
                out.steps.push(if lower == upper {
                    format!("delay {lower} {};", unit.name())
                } else {
                    format!("delay [{lower},{upper}] {};", unit.name())
                });
            }
        }
        out.steps.extend(awaited.into_iter().map(|path| format!("await ended {path};")));
        out
    }
}

enum Found<'c> {
    Service(&'c Component, &'c Service),
    Kill(&'c Component),
    /// Several components have the service.
    Several,
    /// No component has the service. With the nearest one, if there is one.
    Unknown(Option<String>),
}

/// Finds the service that a list names: alone, with its component in any case, or with `cnam`.
fn find<'c>(name: &str, components: &[&'c Component]) -> Found<'c> {
    let without = |prefix: &str| {
        let rest = name.get(prefix.len()..)?.strip_prefix(['_', '.'])?;
        name[..prefix.len()].eq_ignore_ascii_case(prefix).then_some(rest)
    };
    let mut near = None;
    let mut found: Vec<Found<'c>> = Vec::new();
    for component in components {
        let of_component = without(&component.name);
        let service = of_component.or_else(|| without(ANY_COMPONENT)).unwrap_or(name);
        let mut services = component.services.iter();
        let one = match services.find(|candidate| [service, name].contains(&&*candidate.name)) {
            Some(one) => Found::Service(component, one),
            None if service == "kill" => Found::Kill(component),
            None => {
                let names = || component.services.iter().map(|candidate| candidate.name.as_str());
                let mut longer = names().filter(|candidate| candidate.contains(service));
                let only = longer.next().filter(|_| longer.next().is_none());
                near = near.or(nearest(service, names()).or(only).map(str::to_owned));
                continue;
            }
        };
        // The name of a component excludes all others.
        if of_component.is_some() {
            return one;
        }
        found.push(one);
    }
    match found.len() {
        0 => Found::Unknown(near),
        1 => found.remove(0),
        _ => Found::Several,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLIENT: &str = "\
process client [r: out t] is
var q: queue 10 of e := {|
  {rqid=ROVER_RQ(ROVER_Track_RQSTID_FCR), grid=0, fr=true, ir=true, wait_cycle=100},
  // {rqid=ROVER_RQ(ROVER_Old_RQSTID_FCR), grid=0, fr=true, ir=true, wait_cycle=0},
  {rqid=ROVER_RQ(ROVER_Stop_RQSTID_FCR), grid=0, fr=false, ir=true, wait_cycle=0}
|}
from wait_after_rqst
  select wait [0,10]; to wait_after_rqst end
";

    fn names(text: &str) -> Result<Vec<(String, u64, bool)>, usize> {
        let list = parse(text).map_err(|error| error.line)?;
        let all = list.requests.into_iter();
        Ok(all.map(|request| (request.name, request.cycles, request.awaited)).collect())
    }

    #[test]
    fn the_queue_of_a_fiacre_client_has_its_requests_and_waits() {
        let expected = [("ROVER_Track", 100, true), ("ROVER_Stop", 0, false)];
        let expected = expected.map(|(name, cycles, awaited)| (name.to_owned(), cycles, awaited));
        assert_eq!(names(CLIENT).unwrap(), expected);
        assert_eq!(parse(CLIENT).unwrap().cycle, (0, 10));
    }

    #[test]
    fn a_list_has_services_and_numbers() {
        let expected = ["a", "b", "b"].map(|name| (name.to_owned(), 0, false));
        assert_eq!(names("a 1\nnone 0\nb 2 # twice\n").unwrap(), expected);
    }

    #[test]
    fn what_is_neither_is_told_with_its_line() {
        for (text, line) in [
            ("a 1\nb\n", 2),
            ("a many\n", 1),
            ("a 1000000\n", 1),
            ("a 600\nb 600\n", 2),
            ("\nqueue {| {rqid=x}", 2),
            ("{| {rqid=x} |}\n{| {rqid=y} |}", 2),
            ("{| {grid=0} |}", 1),
            ("{| {rqid=x, wait_cycle=y} |}", 1),
            ("{| {rqid=x, wait_cycle=1} |}", 1),
        ] {
            assert_eq!(names(text).unwrap_err(), line, "{text:?}");
        }
    }
}
