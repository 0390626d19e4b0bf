//! Queries: predicates of states, and the searches that answer them.

use crate::ast::{Binary, Expr, ExprKind, Form};
use crate::code::{Code, range};
use crate::error::{Res, fail};
use crate::eval::Trap;
use crate::explore::moves::{System, local};
use crate::explore::search::{End, Search, State, Visit};
use crate::network::ceilings::{Ceilings, ceilings, owners};
use crate::network::edges::{Bound, Process};
use crate::network::scope::{Program, Scope};
use crate::zone::{Constraint, INFINITE, LARGEST_BOUND, Zone};
use crate::{Answer, Extreme, Limits, Reason, Value};

/// Largest constant up to which the value of a clock is searched for.
const LARGEST_CLOCK: i32 = 1 << 20;

/// A predicate in negation normal form.
#[derive(Debug, Clone)]
enum Predicate {
    Condition(Code),
    Bound(Bound),
    All(Vec<Predicate>),
    Any(Vec<Predicate>),
    /// If set, no transition is possible, now or later. If not, one is.
    Deadlock(bool),
}

/// What a query searches for.
#[derive(Debug, Clone)]
enum Goal {
    /// A state with the predicate. The flag is set if such a state makes the query true.
    Reach(Predicate, bool),
    Extremes {
        highest: bool,
        within: Predicate,
        of: Vec<Target>,
    },
    Refused(&'static str),
}

#[derive(Debug, Clone)]
enum Target {
    Clock(u32),
    Integer(Code),
}

/// A query with its names resolved.
#[derive(Debug, Clone)]
pub(crate) struct Resolved {
    goal: Goal,
}

pub(crate) fn resolve(program: &Program, form: &Form) -> Res<Resolved> {
    let mut scope = Scope::new(program, None);
    scope.query = true;
    let goal = match form {
        Form::Always(expr) => Goal::Reach(predicate(&mut scope, expr, false)?, false),
        Form::Reachable(expr) => Goal::Reach(predicate(&mut scope, expr, true)?, true),
        Form::Extremes { highest, within, of } => {
            let within = match within {
                Some(expr) => predicate(&mut scope, expr, true)?,
                None => Predicate::All(Vec::new()),
            };
            let target = |expr| match scope.clock(expr)? {
                Some(clock) => Ok(Target::Clock(clock)),
                None => Ok(Target::Integer(scope.scalar(expr)?)),
            };
            let of = of.iter().map(target).collect::<Res<_>>()?;
            Goal::Extremes { highest: *highest, within, of }
        }
        Form::Refused(reason) => Goal::Refused(reason),
    };
    Ok(Resolved { goal })
}

/// The predicate that an expression is true, or that it is false.
fn predicate(scope: &mut Scope<'_>, expr: &Expr, positive: bool) -> Res<Predicate> {
    let mut parts = |exprs: &[Expr], all: bool| {
        let parts =
            exprs.iter().map(|part| predicate(scope, part, positive)).collect::<Res<Vec<_>>>()?;
        Ok(if all { Predicate::All(parts) } else { Predicate::Any(parts) })
    };
    match &expr.kind {
        ExprKind::All(exprs) => parts(exprs, positive),
        ExprKind::Any(exprs) => parts(exprs, !positive),
        ExprKind::Not(inner) => predicate(scope, inner, !positive),
        ExprKind::Deadlock => Ok(Predicate::Deadlock(positive)),
        ExprKind::Quantifier { all, name, ty, body } => {
            let parts = scope.copies(name, ty, |scope| predicate(scope, body, positive))?;
            Ok(if *all == positive { Predicate::All(parts) } else { Predicate::Any(parts) })
        }
        ExprKind::Binary(operator, left, right) if scope.mentions_clock(expr) => {
            if *operator == Binary::NotEqual {
                return Ok(comparison(
                    scope.bounds(expr.at, Binary::Equal, left, right)?,
                    !positive,
                ));
            }
            Ok(comparison(scope.bounds(expr.at, *operator, left, right)?, positive))
        }
        _ => {
            if let Some(at) = crate::network::edges::effect(expr) {
                return fail(at, "a query must not assign");
            }
            let code = scope.scalar(expr)?;
            Ok(Predicate::Condition(if positive { code } else { Code::Not(Box::new(code)) }))
        }
    }
}

/// The conjunction of bounds, or its negation.
fn comparison(bounds: Vec<Bound>, positive: bool) -> Predicate {
    let part = |bound: Bound| {
        let negated = Bound { upper: !bound.upper, strict: !bound.strict, ..bound.clone() };
        Predicate::Bound(if positive { bound } else { negated })
    };
    let parts = bounds.into_iter().map(part).collect();
    if positive { Predicate::All(parts) } else { Predicate::Any(parts) }
}

impl Predicate {
    fn any(&self, found: &dyn Fn(&Predicate) -> bool) -> bool {
        match self {
            Predicate::All(parts) | Predicate::Any(parts) => {
                parts.iter().any(|part| part.any(found))
            }
            leaf => found(leaf),
        }
    }

    fn deadlock(&self) -> bool {
        self.any(&|leaf| matches!(leaf, Predicate::Deadlock(_)))
    }

    /// Reports whether the predicate may hold while a process is in a location.
    fn possible(&self, process: usize, location: usize) -> bool {
        let here = |of: u32, at: i32| (of as usize == process).then_some(at as usize == location);
        match self {
            Predicate::All(parts) => parts.iter().all(|part| part.possible(process, location)),
            Predicate::Any(parts) => parts.iter().any(|part| part.possible(process, location)),
            Predicate::Condition(Code::At { process: of, location: at }) => {
                here(*of, *at).unwrap_or(true)
            }
            Predicate::Condition(Code::Not(inner)) => match **inner {
                Code::At { process: of, location: at } => here(of, at).is_none_or(|here| !here),
                _ => true,
            },
            _ => true,
        }
    }

    /// Largest constant that a clock is compared with, or -1.
    fn constant(&self, program: &Program, clock: usize) -> i32 {
        match self {
            Predicate::All(parts) | Predicate::Any(parts) => {
                parts.iter().map(|part| part.constant(program, clock)).max().unwrap_or(-1)
            }
            Predicate::Bound(bound) if bound.clock as usize == clock => {
                range(&bound.value, &program.functions).1.clamp(0, LARGEST_BOUND)
            }
            _ => -1,
        }
    }

    /// The parts of zones of a state in which the predicate holds, as constraints on rows to add.
    fn parts(
        &self,
        system: &mut System<'_>,
        state: &State,
        zones: Vec<(Zone, Vec<Constraint>)>,
    ) -> Result<Vec<(Zone, Vec<Constraint>)>, Trap> {
        match self {
            _ if zones.is_empty() => Ok(zones),
            Predicate::All(parts) => {
                parts.iter().try_fold(zones, |zones, part| part.parts(system, state, zones))
            }
            Predicate::Any(parts) => {
                let mut out = Vec::new();
                for part in parts {
                    out.extend(part.parts(system, state, zones.clone())?);
                }
                Ok(out)
            }
            Predicate::Condition(code) => {
                system.machine.load(&state.discrete);
                Ok(if system.machine.pure(code)? != 0 { zones } else { Vec::new() })
            }
            Predicate::Bound(bound) => {
                system.machine.load(&state.discrete);
                let constraint = system.constraint(bound)?;
                Ok(intersect(zones, &local(&[constraint], &state.rows)))
            }
            Predicate::Deadlock(positive) => {
                let live = live(system, state)?;
                if *positive {
                    Ok(live.iter().fold(zones, |zones, live| subtract(zones, live)))
                } else {
                    Ok(live.iter().flat_map(|live| intersect(zones.clone(), live)).collect())
                }
            }
        }
    }

    fn holds(
        &self,
        system: &mut System<'_>,
        state: &State,
    ) -> Result<Vec<(Zone, Vec<Constraint>)>, Trap> {
        self.parts(system, state, vec![(state.zone.clone(), Vec::new())])
    }
}

fn intersect(
    zones: Vec<(Zone, Vec<Constraint>)>,
    with: &[Constraint],
) -> Vec<(Zone, Vec<Constraint>)> {
    let mut out = Vec::new();
    for (mut zone, mut constraints) in zones {
        if zone.constrain_all(with) {
            constraints.extend_from_slice(with);
            out.push((zone, constraints));
        }
    }
    out
}

fn subtract(
    zones: Vec<(Zone, Vec<Constraint>)>,
    without: &[Constraint],
) -> Vec<(Zone, Vec<Constraint>)> {
    let mut out = Vec::new();
    for (zone, constraints) in zones {
        for more in zone.without(without) {
            out.extend(intersect(vec![(zone.clone(), constraints.clone())], &more));
        }
    }
    out
}

/// The parts of a state from which a transition is possible, now or later.
fn live(system: &mut System<'_>, state: &State) -> Result<Vec<Vec<Constraint>>, Trap> {
    let mut out = Vec::new();
    for outcome in system.outcomes(&state.discrete, &state.zone, &state.rows)? {
        let mut zone = state.zone.clone();
        if zone.constrain_all(&local(&outcome.step.constraints, &state.rows)) {
            if state.can_delay {
                zone.down();
            }
            out.push(zone.constraints());
        }
    }
    Ok(out)
}

/// The network as a query needs it.
pub(crate) struct Question<'n> {
    pub(crate) program: &'n Program,
    pub(crate) processes: &'n [Process],
    pub(crate) limits: &'n Limits,
}

impl Question<'_> {
    fn system(&self) -> System<'_> {
        let program = self.program;
        let machine = crate::eval::Machine::new(&program.functions, &program.constants, Vec::new());
        System { program, processes: self.processes, machine, priorities: self.priorities() }
    }

    fn priorities(&self) -> bool {
        let channels = self.program.channels.iter().any(|channel| channel.priority != 0);
        channels || self.processes.iter().any(|process| process.priority != 0)
    }

    /// The constants of the model, and those of a query where its predicate may hold.
    fn ceilings(&self, predicate: &Predicate, constant: impl Fn(usize) -> i32) -> Ceilings {
        let owners = owners(self.processes, self.program.clocks.len());
        let constants: Vec<i32> = (0..owners.len()).map(constant).collect();
        let both = self.priorities() || predicate.deadlock();
        ceilings(self.program, self.processes, both, |process, location, clock| {
            match owners[clock] {
                Some(owner) if owner == process && predicate.possible(process, location) => {
                    constants[clock]
                }
                None if process == 0 => constants[clock],
                _ => -1,
            }
        })
    }

    pub(crate) fn answer(&self, query: &Resolved) -> Answer {
        match &query.goal {
            Goal::Refused(reason) => Answer::Refused((*reason).to_owned()),
            Goal::Reach(predicate, found) => self.reach(predicate, *found),
            Goal::Extremes { highest, within, of } => self.extremes(*highest, within, of),
        }
    }

    fn reach(&self, predicate: &Predicate, found: bool) -> Answer {
        let ceilings = self.ceilings(predicate, |clock| predicate.constant(self.program, clock));
        let mut search = Search::new(self.system(), &ceilings);
        let end = search.run(self.limits, |system, state| {
            let parts = predicate.holds(system, state)?;
            Ok(parts
                .into_iter()
                .next()
                .map_or(Visit::Continue, |(_, constraints)| Visit::Stop(constraints)))
        });
        let states = search.store.nodes.len();
        match end {
            End::Exhausted if found => Answer::Fails { trace: None, states },
            End::Exhausted => Answer::Holds { trace: None, states },
            End::Stopped(node, constraints) => match search.trace(node, &constraints) {
                Ok(trace) if found => Answer::Holds { trace: Some(trace), states },
                Ok(trace) => Answer::Fails { trace: Some(trace), states },
                Err(message) => Answer::Invalid { message, trace: None },
            },
            End::GaveUp(reason) => Answer::GaveUp { reason, states },
            End::Invalid(node, message) => invalid(&mut search, node, message),
        }
    }

    fn extremes(&self, highest: bool, within: &Predicate, of: &[Target]) -> Answer {
        let targets = |clock: usize| {
            of.iter().any(|target| matches!(target, Target::Clock(of) if *of as usize == clock))
        };
        let mut ceiling = 64;
        loop {
            let ceilings = self.ceilings(within, |clock| {
                let constant = within.constant(self.program, clock);
                if targets(clock) { constant.max(ceiling) } else { constant }
            });
            let mut search = Search::new(self.system(), &ceilings);
            let mut best: Vec<Option<Value>> = vec![None; of.len()];
            let mut beyond = false;
            let end = search.run(self.limits, |system, state| {
                let free = free(system, state);
                for (zone, constraints) in within.holds(system, state)? {
                    for (target, best) in of.iter().zip(&mut best) {
                        let value = value(system, state, &zone, target, highest)?;
                        let cut = matches!(value, Value::Infinite) || exceeds(value, ceiling);
                        if cut
                            && matches!(target, Target::Clock(_))
                            && !(free && constraints.is_empty() && highest)
                        {
                            beyond = true;
                        }
                        *best = Some(best.map_or(value, |old| better(old, value, highest)));
                    }
                }
                Ok(Visit::Continue)
            });
            let states = search.store.nodes.len();
            match end {
                End::Exhausted if beyond && ceiling >= LARGEST_CLOCK => {
                    return Answer::GaveUp { reason: Reason::Clock(LARGEST_CLOCK), states };
                }
                End::Exhausted if beyond => ceiling *= 4,
                End::Exhausted | End::Stopped(..) => {
                    let values = best.into_iter().map(|value| Extreme { value }).collect();
                    return Answer::Values { values, states };
                }
                End::GaveUp(reason) => return Answer::GaveUp { reason, states },
                End::Invalid(node, message) => return invalid(&mut search, node, message),
            }
        }
    }
}

fn invalid(search: &mut Search<'_, '_>, node: Option<u32>, message: String) -> Answer {
    let trace = node.and_then(|node| search.trace(node, &[]).ok());
    Answer::Invalid { message, trace }
}

/// Reports whether time may pass without end in a state.
fn free(system: &System<'_>, state: &State) -> bool {
    let mut invariants = system.processes.iter().zip(&state.discrete);
    state.can_delay
        && invariants.all(|(process, location)| {
            process.locations[*location as usize].invariant.bounds.is_empty()
        })
}

fn exceeds(value: Value, ceiling: i32) -> bool {
    matches!(value, Value::Finite { value, .. } if value >= i64::from(ceiling))
}

/// The highest or lowest value of a target in a zone.
fn value(
    system: &mut System<'_>,
    state: &State,
    zone: &Zone,
    target: &Target,
    highest: bool,
) -> Result<Value, Trap> {
    match target {
        Target::Integer(code) => {
            system.machine.load(&state.discrete);
            Ok(Value::Finite { value: i64::from(system.machine.pure(code)?), attained: true })
        }
        Target::Clock(clock) => {
            let Some(row) = state.rows.iter().position(|row| row == clock) else {
                return Ok(Value::Infinite);
            };
            let cell = if highest { zone.get(row + 1, 0) } else { zone.get(0, row + 1) };
            if cell == INFINITE {
                return Ok(Value::Infinite);
            }
            let value = i64::from(cell >> 1);
            Ok(Value::Finite {
                value: if highest { value } else { -value },
                attained: cell & 1 == 1,
            })
        }
    }
}

/// The higher of two values, or the lower one.
fn better(a: Value, b: Value, highest: bool) -> Value {
    let key = |value: Value| match value {
        Value::Infinite => (i64::MAX, true),
        Value::Finite { value, attained } => (value, attained == highest),
    };
    if (key(b) > key(a)) == highest { b } else { a }
}
