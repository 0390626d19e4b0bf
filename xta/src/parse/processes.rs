//! Processes, instances and the system.

use super::cursor::Cursor;
use crate::ast::{Edge, Expr, Instance, Item, Location, Model, Name, Process, Refused};
use crate::error::{Res, fail};
use crate::lexer::Kind;

/// The syntax tree of a model.
pub(crate) fn model(text: &str) -> Res<Model> {
    let mut cursor = Cursor::new(text)?;
    let mut items = Vec::new();
    loop {
        if cursor.eat("process") {
            items.push(Item::Process(cursor.process()?));
        } else if cursor.eat("system") {
            let system = cursor.system()?;
            if cursor.peek().kind != Kind::End {
                return cursor.unexpected("the end of the text after `system`");
            }
            return Ok(Model { items, system });
        } else if cursor.starts_type() || cursor.is("typedef") {
            items.push(Item::Declaration(cursor.declaration()?));
        } else if cursor.peek().kind == Kind::Word {
            items.push(Item::Instance(cursor.instance()?));
        } else {
            return cursor.unexpected("a declaration, a process, an instance or `system`");
        }
    }
}

impl Cursor<'_> {
    /// Names after `system`, up to `;`, by ascending priority.
    fn system(&mut self) -> Res<Vec<Vec<Name>>> {
        let mut out = vec![Vec::new()];
        loop {
            let name = self.name()?;
            if let Some(last) = out.last_mut() {
                last.push(name);
            }
            if self.eat("<") {
                out.push(Vec::new());
            } else if !self.eat(",") {
                break;
            }
        }
        self.expect(";")?;
        Ok(out)
    }

    fn instance(&mut self) -> Res<Instance> {
        let name = self.name()?;
        if self.is("(") {
            return fail(self.at(), "partial instantiation is not supported: give all arguments");
        }
        if !self.eat(":=") {
            self.expect("=")?;
        }
        let template = self.name()?;
        self.expect("(")?;
        let arguments = self.list(")")?;
        self.expect(")")?;
        self.expect(";")?;
        Ok(Instance { name, template, arguments })
    }

    fn process(&mut self) -> Res<Process> {
        let name = self.name()?;
        let parameters = self.parameters()?;
        self.expect("{")?;
        let mut declarations = Vec::new();
        while self.starts_type() || self.is("typedef") {
            declarations.push(self.declaration()?);
        }
        let mut refused = Vec::new();
        self.expect("state")?;
        let mut locations = vec![self.location(&mut refused)?];
        while self.eat(",") {
            locations.push(self.location(&mut refused)?);
        }
        self.expect(";")?;
        let (mut committed, mut urgent, mut initial) = (Vec::new(), Vec::new(), None);
        let mut edges = Vec::new();
        while !self.eat("}") {
            let at = self.at();
            if self.eat("branchpoint") {
                self.names()?;
                refused.push(Refused {
                    at,
                    message: "branch points (probabilities) are not supported",
                });
            } else if self.eat("commit") {
                committed.extend(self.names()?);
            } else if self.eat("urgent") {
                urgent.extend(self.names()?);
            } else if self.eat("init") {
                initial = Some(self.name()?);
                self.expect(";")?;
            } else if self.eat("trans") {
                self.edges(&mut edges, &mut refused)?;
            } else {
                return self.unexpected("`commit`, `urgent`, `init`, `trans` or `}`");
            }
        }
        let Some(initial) = initial else {
            return fail(name.at, format!("process `{}` has no `init`", name.text));
        };
        Ok(Process {
            name,
            parameters,
            declarations,
            locations,
            committed,
            urgent,
            initial,
            edges,
            refused,
        })
    }

    /// A location, with `{ invariant }` or `{ invariant; rate }`.
    fn location(&mut self, refused: &mut Vec<Refused>) -> Res<Location> {
        let name = self.name()?;
        let mut invariant = None;
        if self.eat("{") {
            if !self.is(";") && !self.is("}") {
                invariant = Some(self.expr()?);
            }
            let at = self.at();
            if self.eat(";") && !self.is("}") {
                self.expr()?;
                refused.push(Refused {
                    at,
                    message: "exponential rates of locations are not supported",
                });
            }
            self.expect("}")?;
        }
        Ok(Location { name, invariant })
    }

    fn edges(&mut self, out: &mut Vec<Edge>, refused: &mut Vec<Refused>) -> Res<()> {
        if self.eat(";") {
            return Ok(());
        }
        let mut source: Option<Name> = None;
        loop {
            let from = match (&source, self.is("->")) {
                (Some(previous), true) => previous.clone(),
                _ => self.name()?,
            };
            source = Some(from.clone());
            if self.is("-u->") {
                return fail(self.at(), "uncontrollable edges are not supported: expected `->`");
            }
            let at = self.expect("->")?;
            let target = self.name()?;
            let mut edge = Edge {
                at,
                source: from,
                target,
                selects: Vec::new(),
                guard: None,
                sync: None,
                assigns: Vec::new(),
            };
            self.edge_body(&mut edge, refused)?;
            out.push(edge);
            if !self.eat(",") {
                break;
            }
        }
        self.expect(";")?;
        Ok(())
    }

    fn edge_body(&mut self, edge: &mut Edge, refused: &mut Vec<Refused>) -> Res<()> {
        self.expect("{")?;
        while !self.eat("}") {
            let at = self.at();
            if self.eat("select") {
                loop {
                    let name = self.name()?;
                    self.expect(":")?;
                    edge.selects.push((name, self.type_expr()?));
                    if !self.eat(",") {
                        break;
                    }
                }
            } else if self.eat("guard") {
                edge.guard = Some(self.comma_joined()?);
            } else if self.eat("sync") {
                let channel = self.expr()?;
                let sends = self.eat("!");
                if !sends {
                    self.expect("?")?;
                }
                edge.sync = Some((channel, sends));
            } else if self.eat("assign") {
                edge.assigns = self.list(";")?;
            } else if self.eat("probability") {
                self.expr()?;
                refused.push(Refused { at, message: "probabilities of edges are not supported" });
            } else {
                return self.unexpected("`select`, `guard`, `sync`, `assign` or `}`");
            }
            self.expect(";")?;
        }
        Ok(())
    }

    /// A guard, in which old models separate conjuncts by commas.
    fn comma_joined(&mut self) -> Res<Expr> {
        let first = self.expr()?;
        if !self.is(",") {
            return Ok(first);
        }
        let (at, mut parts) = (first.at, vec![first]);
        while self.eat(",") {
            parts.push(self.expr()?);
        }
        let depth = parts.iter().map(|part| part.depth).max().unwrap_or(0);
        super::expressions::node(at, depth, crate::ast::ExprKind::All(parts))
    }
}
