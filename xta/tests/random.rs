//! Zones against an exploration of integer times, on random networks with weak bounds, for which integer
//! times are enough. Priorities and broadcasts negate bounds. Networks with them are explored in quarters of
//! the unit, and the zones must reach at least as much.

use std::collections::{BTreeSet, HashSet, VecDeque};

use super::{holds, values};

/// Constants are at most this, so that clocks above are equal.
const HIGHEST: u32 = 4;

#[derive(Clone, Debug)]
struct Edge {
    from: usize,
    to: usize,
    /// At least, at most.
    guard: (u32, u32),
    /// Required value of the variable, if any.
    when: Option<u8>,
    /// 0 internal, 1 sends, 2 receives.
    sync: u8,
    reset: bool,
    set: Option<u8>,
}

#[derive(Clone, Debug)]
struct Automaton {
    invariants: Vec<Option<u32>>,
    kinds: Vec<u8>,
    edges: Vec<Edge>,
}

#[derive(Clone, Debug)]
struct Random {
    automata: Vec<Automaton>,
    broadcast: bool,
    urgent: bool,
    /// Priority of the channel over internal edges.
    priority: i32,
    /// Steps of a unit of time.
    grid: u32,
}

type Point = (Vec<usize>, Vec<u32>, u8);

fn generate(random: &mut fastrand::Rng, weak: bool) -> Random {
    let urgent = random.u8(..3) == 0;
    let broadcast = random.bool();
    let priority = if weak { 0 } else { random.i32(-1..=1) };
    // The guard of a receiver of a broadcast is negated if the receiver does not take part.
    let free = [false, urgent, urgent || (broadcast && weak)];
    let automata =
        (0..if weak { random.usize(2..=3) } else { 2 }).map(|_| automaton(random, free)).collect();
    Random { automata, broadcast, urgent, priority, grid: if weak { 1 } else { 4 } }
}

/// `free` is set for the kinds of synchronisation whose guards have no clocks.
fn automaton(random: &mut fastrand::Rng, free: [bool; 3]) -> Automaton {
    let locations = random.usize(2..=4);
    let bound = |random: &mut fastrand::Rng| random.u32(1..=HIGHEST);
    let invariants = (0..locations).map(|_| random.bool().then(|| bound(random))).collect();
    // 1 urgent, 2 committed.
    let kinds = (0..locations).map(|_| [0, 0, 0, 0, 0, 1, 2][random.usize(..7)]).collect();
    let edges = (0..random.usize(locations..=2 * locations + 2)).map(|_| {
        let low = random.u32(0..=HIGHEST);
        let high = if random.bool() { u32::MAX } else { random.u32(low..=HIGHEST) };
        let sync = random.u8(..3);
        Edge {
            from: random.usize(..locations),
            to: random.usize(..locations),
            guard: if free[sync as usize] { (0, u32::MAX) } else { (low, high) },
            when: (random.u8(..3) == 0).then(|| random.u8(..2)),
            sync,
            reset: random.bool(),
            set: (random.u8(..3) == 0).then(|| random.u8(..2)),
        }
    });
    Automaton { invariants, kinds, edges: edges.collect() }
}

impl Random {
    fn text(&self) -> String {
        let kind = format!(
            "{}{}chan c;",
            if self.urgent { "urgent " } else { "" },
            if self.broadcast { "broadcast " } else { "" }
        );
        let mut out = format!("{kind} int[0, 1] v := 0;\n");
        out += match self.priority {
            0 => "",
            1 => "chan priority default < c;\n",
            _ => "chan priority c < default;\n",
        };
        for (index, automaton) in self.automata.iter().enumerate() {
            out += &automaton.text(index);
        }
        let names: Vec<String> =
            (0..self.automata.len()).map(|number| format!("P{number}")).collect();
        out + &format!("system {};", names.join(", "))
    }

    fn holds_invariants(&self, point: &Point) -> bool {
        self.automata.iter().enumerate().all(|(index, automaton)| {
            automaton.invariants[point.0[index]]
                .is_none_or(|bound| point.1[index] <= bound * self.grid)
        })
    }

    fn ready(&self, point: &Point, process: usize, sync: u8) -> Vec<&Edge> {
        let (locations, clocks, value) = point;
        let fits = |edge: &&Edge| {
            edge.from == locations[process]
                && edge.sync == sync
                && edge.when.is_none_or(|when| when == *value)
                && clocks[process] >= edge.guard.0 * self.grid
                && clocks[process] <= edge.guard.1.saturating_mul(self.grid)
        };
        self.automata[process].edges.iter().filter(fits).collect()
    }

    /// The transitions of a point, as edges by process.
    fn transitions(&self, point: &Point) -> Vec<Vec<(usize, &Edge)>> {
        let count = self.automata.len();
        let mut out = Vec::new();
        for process in 0..count {
            out.extend(self.ready(point, process, 0).into_iter().map(|edge| vec![(process, edge)]));
            for sender in self.ready(point, process, 1) {
                let mut partial = vec![vec![(process, sender)]];
                for other in (0..count).filter(|other| *other != process) {
                    let receivers = self.ready(point, other, 2);
                    if !self.broadcast {
                        out.extend(
                            receivers.iter().map(|edge| vec![(process, sender), (other, *edge)]),
                        );
                    } else if !receivers.is_empty() {
                        partial = partial
                            .iter()
                            .flat_map(|before| {
                                receivers
                                    .iter()
                                    .map(move |edge| [&before[..], &[(other, *edge)]].concat())
                            })
                            .collect();
                    }
                }
                if self.broadcast {
                    out.extend(partial);
                }
            }
        }
        out
    }

    fn kind(&self, point: &Point, process: usize) -> u8 {
        self.automata[process].kinds[point.0[process]]
    }

    fn successors(&self, point: &Point) -> Vec<Point> {
        let transitions = self.transitions(point);
        let committed = (0..self.automata.len()).any(|process| self.kind(point, process) == 2);
        let stops = (0..self.automata.len()).any(|process| self.kind(point, process) > 0);
        let urgent = self.urgent && transitions.iter().any(|transition| transition[0].1.sync == 1);
        let mut out = Vec::new();
        for transition in &transitions {
            if committed && !transition.iter().any(|(process, _)| self.kind(point, *process) == 2) {
                continue;
            }
            let mut next = point.clone();
            for (process, edge) in transition {
                next.0[*process] = edge.to;
                next.1[*process] = if edge.reset { 0 } else { next.1[*process] };
                next.2 = edge.set.unwrap_or(next.2);
            }
            let internal = transition[0].1.sync == 0;
            if self.holds_invariants(&next) {
                out.push((if internal { 0 } else { self.priority }, next));
            }
        }
        let highest = out.iter().map(|(priority, _)| *priority).max();
        out.retain(|(priority, _)| Some(*priority) == highest);
        let mut out: Vec<Point> = out.into_iter().map(|(_, next)| next).collect();
        if !stops && !urgent {
            let mut next = point.clone();
            next.1.iter_mut().for_each(|clock| *clock = (*clock + 1).min(HIGHEST * self.grid + 1));
            if self.holds_invariants(&next) {
                out.push(next);
            }
        }
        out
    }

    fn reachable(&self) -> HashSet<Point> {
        let count = self.automata.len();
        let first: Point = (vec![0; count], vec![0; count], 0);
        let mut seen = HashSet::from([first.clone()]);
        let mut waiting = VecDeque::from([first]);
        while let Some(point) = waiting.pop_front() {
            for next in self.successors(&point) {
                if seen.insert(next.clone()) {
                    waiting.push_back(next);
                }
            }
        }
        seen
    }
}

impl Automaton {
    fn text(&self, index: usize) -> String {
        let locations: Vec<String> = (self.invariants.iter().enumerate())
            .map(|(location, bound)| match bound {
                Some(bound) => format!("l{location} {{ x <= {bound} }}"),
                None => format!("l{location}"),
            })
            .collect();
        let of_kind = |kind: u8, word: &str| {
            let names: Vec<String> = (self.kinds.iter().enumerate())
                .filter(|(_, of)| **of == kind)
                .map(|(location, _)| format!("l{location}"))
                .collect();
            if names.is_empty() { String::new() } else { format!("{word} {};", names.join(", ")) }
        };
        let edges: Vec<String> = self.edges.iter().map(Edge::text).collect();
        format!(
            "process P{index}() {{ clock x; state {}; {} {} init l0; trans {}; }}\n",
            locations.join(", "),
            of_kind(2, "commit"),
            of_kind(1, "urgent"),
            edges.join(",\n  ")
        )
    }
}

impl Edge {
    fn text(&self) -> String {
        let mut guard = Vec::new();
        if self.guard.0 > 0 {
            guard.push(format!("x >= {}", self.guard.0));
        }
        if self.guard.1 < u32::MAX {
            guard.push(format!("x <= {}", self.guard.1));
        }
        guard.extend(self.when.map(|value| format!("v == {value}")));
        let mut assign = Vec::new();
        assign.extend(self.reset.then(|| "x := 0".to_owned()));
        assign.extend(self.set.map(|value| format!("v := {value}")));
        let part = |word: &str, parts: Vec<String>, separator: &str| {
            let text = format!("{word} {};", parts.join(separator));
            if parts.is_empty() { String::new() } else { text }
        };
        let sync = ["", "sync c!;", "sync c?;"][self.sync as usize];
        let (guard, assign) = (part("guard", guard, " && "), part("assign", assign, ", "));
        format!("l{} -> l{} {{ {guard} {sync} {assign} }}", self.from, self.to)
    }
}

#[test]
fn zones_reach_what_integer_times_reach() {
    let factor: u64 =
        std::env::var("DOTGEN_TIMES").ok().and_then(|times| times.parse().ok()).unwrap_or(1);
    for seed in 0..50 * factor {
        let weak = seed % 3 > 0;
        let network = generate(&mut fastrand::Rng::with_seed(seed), weak);
        let text = network.text();
        let reached = network.reachable();
        let vectors: BTreeSet<(Vec<usize>, u8)> =
            reached.iter().map(|(locations, _, value)| (locations.clone(), *value)).collect();
        let state = |(locations, value): &(Vec<usize>, u8)| {
            let names = locations
                .iter()
                .enumerate()
                .map(|(index, location)| format!("P{index}.l{location}"));
            format!("({} and v == {value})", names.collect::<Vec<_>>().join(" and "))
        };
        // Each is reached. If the bounds are weak, nothing else is.
        let all: Vec<String> = vectors.iter().map(state).collect();
        let only = holds(&text, &format!("A[] {}", all.join(" or ")));
        assert!(only || !weak, "seed {seed}\n{text}");
        for one in all.iter().step_by(1 + all.len() / 6) {
            assert!(holds(&text, &format!("E<> {one}")), "seed {seed}: {one}\n{text}");
        }
        if weak {
            clocks(seed, &text, &reached);
        }
    }
}

/// Values of clocks, up to the highest constant.
fn clocks(seed: u64, text: &str, reached: &HashSet<Point>) {
    let Some(locations) = reached.iter().map(|(locations, ..)| locations).max() else { return };
    let of = reached.iter().filter(|point| point.0[0] == locations[0]).map(|point| point.1[0]);
    let (lowest, highest) =
        of.fold((u32::MAX, 0), |(low, high), clock| (low.min(clock), high.max(clock)));
    let within = format!("P0.l{}", locations[0]);
    if highest <= HIGHEST {
        let found = values(text, &format!("sup{{{within}}}: P0.x"));
        assert_eq!(found, [Some((i64::from(highest), true))], "seed {seed} {within}\n{text}");
    }
    if lowest <= HIGHEST {
        let found = values(text, &format!("inf{{{within}}}: P0.x"));
        assert_eq!(found, [Some((i64::from(lowest), true))], "seed {seed} {within}\n{text}");
    }
}
