//! Clients, and the services they request.

use num_rational::Ratio;

use super::{Builder, not_a};
use crate::scn::Diagnostic;
use crate::scn::ast::{self, Path, StepKind, Unit};
use crate::scn::names::Target;
use crate::system::{Client, FOREVER, program, units};

impl Builder<'_> {
    pub(super) fn find_requested(&mut self) {
        let mut paths = Vec::new();
        for client in &self.settings.clients {
            sends(&client.steps, &mut paths);
        }
        for path in paths {
            match self.service(path) {
                Ok(it) => self.requested.push(it),
                Err(error) => self.report(error),
            }
        }
    }

    pub(super) fn clients(&mut self) {
        let unit = self.out.system.unit;
        let ticks = |count: u64, of: Unit| {
            let time = of.seconds() * Ratio::from_integer(i128::from(count));
            units::ticks(time, unit).unwrap_or(FOREVER / 8)
        };
        for client in &self.settings.clients {
            let mut paths = Vec::new();
            sends(&client.steps, &mut paths);
            let here = paths.iter().any(|path| {
                self.service(path)
                    .is_ok_and(|it| self.out.services.contains_key(&it))
            });
            if !here && !paths.is_empty() {
                continue;
            }
            let resolve = |path: &Path| {
                let it = self.service(path)?;
                self.out
                    .services
                    .get(&it)
                    .copied()
                    .ok_or_else(|| not_a("service", path))
            };
            let compiled: Result<Client, Diagnostic> = program::compile(client, &resolve, &ticks);
            match compiled {
                Ok(client) => self.out.system.clients.push(client),
                Err(error) => self.report(error),
            }
        }
    }

    fn service(&self, path: &Path) -> Result<(usize, u32), Diagnostic> {
        match self.names.resolve(path)? {
            Target::Service(c, s) => Ok((c, s)),
            _ => Err(not_a("service", path)),
        }
    }
}

/// Paths of all requests.
fn sends<'s>(steps: &'s [ast::Step], out: &mut Vec<&'s Path>) {
    for step in steps {
        match &step.kind {
            StepKind::Send(path) => out.push(path),
            StepKind::Repeat(_, body) => sends(body, out),
            StepKind::Choice(branches) => branches.iter().for_each(|it| sends(it, out)),
            _ => {}
        }
    }
}
