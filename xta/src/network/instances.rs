//! Processes of the system, from their templates.

use std::collections::HashMap;

use super::declarations::{Target, add};
use super::edges::{Edge, Guard, Location, Process, effect};
use super::scope::{Member, Program, Scope, Symbol, Symbols, declare};
use crate::ast::{self, Expr, Instance, Item, Model, Name};
use crate::code::Root;
use crate::error::{Res, fail};
use crate::types::Type;

/// Largest number of processes, and of edges of one process.
const LARGEST_SYSTEM: usize = 1 << 12;

/// Instantiates the system of a model.
pub(crate) fn system(model: &Model) -> Res<(Program, Vec<Process>)> {
    let mut program = Program::default();
    let names: Vec<(&Name, i32)> = model
        .system
        .iter()
        .zip(0..)
        .flat_map(|(level, priority)| level.iter().map(move |n| (n, priority)))
        .collect();
    if names.len() > LARGEST_SYSTEM {
        return fail(names[0].0.at, format!("more than {LARGEST_SYSTEM} processes"));
    }
    // The first slots are the locations of the processes.
    for (name, _) in &names {
        program.initial.push(0);
        program.slots.push((name.text.clone(), (0, i32::MAX)));
    }
    let mut templates: HashMap<&str, &ast::Process> = HashMap::new();
    let mut instances: HashMap<&str, &Instance> = HashMap::new();
    for item in &model.items {
        match item {
            Item::Declaration(declaration) => {
                add(&mut program, &mut Target { names: None, prefix: "" }, declaration)?;
            }
            Item::Process(process) => {
                if templates.insert(&process.name.text, process).is_some() {
                    return fail(
                        process.name.at,
                        format!("process `{}` is declared twice", process.name.text),
                    );
                }
            }
            Item::Instance(instance) => {
                if instances.insert(&instance.name.text, instance).is_some() {
                    return fail(
                        instance.name.at,
                        format!("`{}` is declared twice", instance.name.text),
                    );
                }
            }
        }
    }
    // Processes and variables have one scope.
    let names_of_processes = (templates.values().map(|process| &process.name))
        .chain(instances.values().map(|instance| &instance.name));
    for name in names_of_processes {
        if program.global.contains_key(&name.text) {
            return fail(name.at, format!("`{}` is declared twice", name.text));
        }
    }
    let mut processes = Vec::new();
    for (index, (name, priority)) in names.into_iter().enumerate() {
        let instance = instances.get(name.text.as_str()).copied();
        let (template, arguments): (&Name, &[Expr]) = match instance {
            Some(instance) => (&instance.template, &instance.arguments),
            None => (name, &[]),
        };
        let Some(template) = templates.get(template.text.as_str()) else {
            return fail(template.at, format!("unknown process `{}`", template.text));
        };
        let at = instance.map_or(name.at, |instance| instance.name.at);
        let process = Instantiation { index: index as u32, name, at, template, arguments };
        processes.push(process.build(&mut program, priority)?);
    }
    Ok((program, processes))
}

struct Instantiation<'m> {
    index: u32,
    name: &'m Name,
    at: u32,
    template: &'m ast::Process,
    arguments: &'m [Expr],
}

impl Instantiation<'_> {
    fn build(&self, program: &mut Program, priority: i32) -> Res<Process> {
        let template = self.template;
        if let Some(refused) = template.refused.first() {
            return fail(refused.at, refused.message);
        }
        let mut names = Symbols::default();
        let prefix = format!("{}.", self.name.text);
        self.parameters(program, &mut names, &prefix)?;
        for declaration in &template.declarations {
            let mut target = Target { names: Some(&mut names), prefix: &prefix };
            add(program, &mut target, declaration)?;
        }
        let mut indices: HashMap<String, i32> = HashMap::new();
        let mut locations = Vec::new();
        for (location, number) in template.locations.iter().zip(0..) {
            if indices.insert(location.name.text.clone(), number).is_some() {
                return fail(
                    location.name.at,
                    format!("location `{}` is declared twice", location.name.text),
                );
            }
            let mut invariant = Guard::default();
            if let Some(expr) = &location.invariant {
                Scope::new(program, Some(&names)).guard(expr, &mut invariant)?;
                if invariant.bounds.iter().any(|bound| !bound.upper) {
                    return fail(expr.at, "an invariant can only bound clocks from above");
                }
            }
            let name = location.name.text.clone();
            locations.push(Location { name, invariant, committed: false, urgent: false });
        }
        let find = |name: &Name| match indices.get(&name.text) {
            Some(index) => Ok(*index),
            None => fail(name.at, format!("unknown location `{}`", name.text)),
        };
        for name in &template.committed {
            locations[find(name)? as usize].committed = true;
        }
        for name in &template.urgent {
            locations[find(name)? as usize].urgent = true;
        }
        let initial = find(&template.initial)?;
        let mut edges = Vec::new();
        for edge in &template.edges {
            let (source, target) = (find(&edge.source)?, find(&edge.target)?);
            let mut scope = Scope::new(program, Some(&names));
            selected(&mut scope, edge, &edge.selects, &mut |scope| {
                edges.push(compile(scope, edge, source, target)?);
                Ok(())
            })?;
        }
        let mut outgoing = vec![Vec::new(); locations.len()];
        for (edge, number) in edges.iter().zip(0..) {
            outgoing[edge.source as usize].push(number);
        }
        if let Some(slot) = program.initial.get_mut(self.index as usize) {
            *slot = initial;
        }
        let member = Member { process: self.index, locations: indices, names };
        if program.members.insert(self.name.text.clone(), member).is_some() {
            return fail(
                self.name.at,
                format!("process `{}` is in the system twice", self.name.text),
            );
        }
        Ok(Process { name: self.name.text.clone(), locations, edges, outgoing, priority })
    }

    fn parameters(&self, program: &mut Program, names: &mut Symbols, prefix: &str) -> Res<()> {
        let (wanted, given) = (self.template.parameters.len(), self.arguments.len());
        if wanted != given {
            return fail(
                self.at,
                format!("`{}` takes {wanted} arguments, not {given}", self.template.name.text),
            );
        }
        for (parameter, argument) in self.template.parameters.iter().zip(self.arguments) {
            let name = &parameter.declarator.name;
            let mut scope = Scope::new(program, Some(names));
            let ty = scope.resolve(&parameter.ty)?;
            let ty = scope.dimensions(ty, &parameter.declarator.dimensions)?;
            let mut scope = Scope::new(program, None);
            let handle = matches!(ty.element(), Type::Clock | Type::Chan { .. });
            if parameter.reference || handle {
                let symbol = reference(&mut scope, argument, &ty, parameter.ty.constant)?;
                declare(names, name, symbol)?;
                continue;
            }
            let Some(range) = ty.range() else {
                return fail(
                    name.at,
                    "arrays and records by value are not supported as parameters of processes",
                );
            };
            let value = scope.constant(argument)?;
            if value < range.0 || value > range.1 {
                let (low, high) = range;
                return fail(
                    argument.at,
                    format!("argument {value} is out of the range [{low}, {high}]"),
                );
            }
            let symbol = if parameter.ty.constant {
                Symbol::Constant(value)
            } else {
                let offset = program.initial.len() as u32;
                program.initial.push(value);
                program.slots.push((format!("{prefix}{}", name.text), range));
                Symbol::Variable { root: Root::Static, offset, ty, constant: false }
            };
            declare(names, name, symbol)?;
        }
        Ok(())
    }
}

/// The variable, clock or channel that a parameter stands for.
fn reference(scope: &mut Scope<'_>, argument: &Expr, ty: &Type, constant: bool) -> Res<Symbol> {
    let Some(found) = scope.located(argument)? else {
        return fail(argument.at, "expected a variable, a clock or a channel");
    };
    let channels =
        |ty: &Type| matches!(ty.element(), Type::Chan { .. }) && ty.size() == found.ty.size();
    if found.ty != *ty && !(channels(ty) && matches!(found.ty.element(), Type::Chan { .. })) {
        return fail(argument.at, "the type of the argument differs from that of the parameter");
    }
    if !found.place.indices.is_empty() {
        return fail(argument.at, "index of an argument must be a constant");
    }
    let constant = constant || found.constant;
    Ok(Symbol::Variable {
        root: found.place.root,
        offset: found.place.offset,
        ty: found.ty,
        constant,
    })
}

/// Runs `each` for all values of the names of a `select`.
fn selected(
    scope: &mut Scope<'_>,
    edge: &ast::Edge,
    selects: &[(Name, ast::TypeExpr)],
    each: &mut dyn FnMut(&mut Scope<'_>) -> Res<()>,
) -> Res<()> {
    if edge.selects.len() > 16 {
        return fail(edge.at, "more than 16 names in `select`");
    }
    match selects.split_first() {
        None => each(scope),
        Some(((name, ty), rest)) => {
            scope.copies(name, ty, |scope| selected(scope, edge, rest, each))?;
            Ok(())
        }
    }
}

fn compile(scope: &mut Scope<'_>, edge: &ast::Edge, source: i32, target: i32) -> Res<Edge> {
    let mut guard = Guard::default();
    if let Some(expr) = &edge.guard {
        scope.guard(expr, &mut guard)?;
    }
    let sync = match &edge.sync {
        Some((channel, sends)) => {
            if let Some(at) = effect(channel) {
                return fail(at, "a channel must not assign");
            }
            Some(scope.sync(channel, *sends)?)
        }
        None => None,
    };
    if let (Some(sync), Some(bound)) = (&sync, guard.bounds.first())
        && sync.urgent
        && (sync.sends || !sync.broadcast)
    {
        let clock = &scope.program.clocks[bound.clock as usize];
        let message =
            format!("guard with the clock `{clock}` on an urgent channel is not supported");
        return fail(edge.guard.as_ref().map_or(edge.at, |guard| guard.at), message);
    }
    let updates = edge.assigns.iter().map(|expr| scope.update(expr)).collect::<Res<_>>()?;
    Ok(Edge { source, target, guard, sync, updates })
}
