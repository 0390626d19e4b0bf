//! Traces as text, as `verifyta -t0`, `-t1` and `-t2` print them: blocks `State:`, `Delay:` and
//! `Transitions:`. The conditions in the braces of a transition and the zones of states are not read: the
//! model has them.

use super::{Error, Moved, State, Transition, Written, time};

/// Beginnings of lines about queries, which end a trace.
const OTHERS: [&str; 5] = ["Verifying", "--", "Showing", "Options", "Writing"];

/// Block of a trace.
#[derive(Clone, Copy, PartialEq)]
enum Block {
    /// Before or after the trace.
    Outside,
    State,
    Transitions,
    /// After a delay, which is a transition without edges.
    Delay,
}

/// Reads a trace.
pub(super) fn read(text: &str) -> Result<Written<'_>, Error> {
    let mut out = Written::default();
    let mut block = Block::Outside;
    for (index, line) in text.lines().enumerate() {
        let (number, line) = (index + 1, line.trim());
        let header = ["State", "Transitions", "Transition", "Delay"].into_iter().find_map(|word| {
            Some((word, line.strip_prefix(word)?.trim_start().strip_prefix(':')?.trim()))
        });
        match header {
            Some(("State", rest)) => {
                let is_first = out.states.is_empty();
                let has_edges = out.transitions.last().is_some_and(|last| !last.edges.is_empty());
                match block {
                    Block::Outside if is_first => {}
                    Block::Delay => {}
                    Block::Transitions if has_edges => {}
                    Block::Outside => {
                        return Err(Error::at(number, "a second trace begins: give one trace"));
                    }
                    _ => {
                        return Err(Error::at(
                            number,
                            "a transition is expected before this state",
                        ));
                    }
                }
                out.states.push(State { line: number, ..State::default() });
                block = Block::State;
                state(rest, number, &mut out)?;
            }
            Some(("Delay", rest)) if block == Block::State => {
                let delay = time(rest, number)?;
                out.has_times = true;
                out.transitions.push(Transition { line: number, delay, edges: Vec::new() });
                block = Block::Delay;
            }
            Some(("Transition" | "Transitions", rest)) if block == Block::State => {
                let delay = Some(0);
                out.transitions.push(Transition { line: number, delay, edges: Vec::new() });
                block = Block::Transitions;
                edge(rest, number, &mut out)?;
            }
            Some((word, _)) => {
                return Err(Error::at(number, format!("`{word}:` does not follow a state")));
            }
            None if OTHERS.iter().any(|word| line.starts_with(word)) => block = Block::Outside,
            None => match block {
                Block::State => state(line, number, &mut out)?,
                Block::Transitions => edge(line, number, &mut out)?,
                Block::Delay if !line.is_empty() => {
                    return Err(Error::at(number, "`State:` is expected after a delay"));
                }
                Block::Delay | Block::Outside => {}
            },
        }
    }
    if out.states.len() != out.transitions.len() + 1 {
        return Err(Error::new("the trace breaks off after a transition: its state is missing"));
    }
    Ok(out)
}

/// Reads a part of a state: `( P.a Q.b ) n=1 x<=5 x-y=2`.
fn state<'t>(text: &'t str, line: usize, out: &mut Written<'t>) -> Result<(), Error> {
    let Some(state) = out.states.last_mut() else { return Ok(()) };
    let (locations, values) = match text.strip_prefix('(') {
        Some(rest) => rest.split_once(')').ok_or_else(|| Error::at(line, "`)` is missing"))?,
        None => ("", text),
    };
    state.locations.extend(locations.split_whitespace());
    let words = values.split([' ', '\t', ',']).filter(|word| !word.is_empty());
    for word in words.filter(|word| !word.contains(['<', '>'])) {
        let pair = word.split_once('=');
        state.values.push(
            pair.ok_or_else(|| Error::at(line, format!("`{word}` is not a part of a state")))?,
        );
    }
    Ok(())
}

/// Reads an edge: `P.a->P.b { guard, channel!, updates }`.
fn edge<'t>(text: &'t str, line: usize, out: &mut Written<'t>) -> Result<(), Error> {
    if text.is_empty() {
        return Ok(());
    }
    let names = text.split('{').next().unwrap_or_default().trim();
    let moved = names.split_once("->").and_then(|(source, target)| {
        let (process, source) = source.trim().split_once('.')?;
        let (same, target) = target.trim().split_once('.')?;
        (process == same).then_some(Moved { process, between: Some((source, target)), event: None })
    });
    let moved = moved.ok_or_else(|| Error::at(line, format!("`{text}` is not a transition")))?;
    if let Some(transition) = out.transitions.last_mut() {
        transition.edges.push(moved);
    }
    Ok(())
}

/// Returns the error for a text that has no states.
pub(super) fn not_a_trace(text: &str) -> Error {
    let is_number = |byte: u8| byte.is_ascii_digit() || b".;,- \t\r\n".contains(&byte);
    if text.bytes().any(|byte| byte.is_ascii_digit()) && text.bytes().all(is_number) {
        return Error::new(
            "an `.xtr` file of UPPAAL has numbers instead of names: give the text that `verifyta -t0` prints \
             without `-f`",
        );
    }
    Error::new(
        "neither a trace of UPPAAL (`State:`, `Transitions:`) nor of TChecker (`digraph`): give the output of \
         `verifyta -t0` or of `tck-reach -C symbolic`",
    )
}
