//! Systems whose clients stop: at a delay without an upper bound, they wait for ever.
//!
//! A client may stay for ever at a delay without an upper bound. If all clients do so at their *k*-th such
//! delay, the system has a subset of the runs of the full system. These runs have few requests, are soon
//! explored and easy to read.

use super::{Client, ClientAction, ClientStep, FOREVER, TimedSystem};

impl Client {
    /// Returns true if a step is a delay without an upper bound.
    fn may_stay(&self, step: usize) -> bool {
        let step = self.steps.get(step);
        step.is_some_and(|step| matches!(step.action, ClientAction::Delay(_, FOREVER)))
    }

    /// Returns the client that stays for ever at a delay without an upper bound, after it has passed `most`
    /// of them.
    fn waiting_forever_after(&self, most: usize) -> Client {
        let n = self.steps.len();
        let done = n * (most + 1);
        let at = |round: usize, step: usize| match (self.may_stay(step), round == most) {
            _ if step == self.done() => done,
            (true, true) => done,
            (true, false) => (round + 1) * n + step,
            (false, _) => round * n + step,
        };
        let step = |round: usize, step: &ClientStep| ClientStep {
            next: step.next.iter().map(|&next| at(round, next)).collect(),
            ..step.clone()
        };
        Client {
            steps: (0..=most)
                .flat_map(|round| self.steps.iter().map(move |own| step(round, own)))
                .collect(),
            first: self.first.iter().map(|&step| at(0, step)).collect(),
            ..self.clone()
        }
        .reached()
    }

    /// Returns the client without its unreachable steps.
    fn reached(&self) -> Client {
        let mut reached = vec![false; self.steps.len()];
        let mut stack = self.first.clone();
        while let Some(at) = stack.pop() {
            if at < reached.len() && !std::mem::replace(&mut reached[at], true) {
                stack.extend(&self.steps[at].next);
            }
        }
        let before = |at: usize| reached[..at].iter().filter(|&&flag| flag).count();
        let renumbered = |list: &[usize]| list.iter().map(|&step| before(step)).collect();
        let steps = self.steps.iter().zip(&reached).filter(|(_, reached)| **reached);
        Client {
            steps: steps
                .map(|(step, _)| ClientStep { next: renumbered(&step.next), ..step.clone() })
                .collect(),
            first: renumbered(&self.first),
            ..self.clone()
        }
    }
}

impl TimedSystem {
    /// Returns the system whose clients stay for ever at a delay without an upper bound, after they have
    /// passed `most` of them. `None` if no client has such a delay.
    pub(crate) fn waiting_forever_after(&self, most: usize) -> Option<TimedSystem> {
        let stays = |client: &Client| (0..client.steps.len()).any(|step| client.may_stay(step));
        self.clients.iter().any(stays).then(|| TimedSystem {
            clients: (self.clients.iter().map(|client| client.waiting_forever_after(most)))
                .filter(|waiting_forever| !waiting_forever.steps.is_empty())
                .collect(),
            ..self.clone()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a client that lets any time pass, then sends one of two requests, again and again.
    fn any() -> Client {
        let send = |service: usize| ClientStep {
            action: ClientAction::Send {
                service: service.into(),
                trackers: Vec::new(),
                accepted: Vec::new(),
                aborts: None,
            },
            next: vec![0],
            label: None,
        };
        let stay =
            ClientStep { action: ClientAction::Delay(0, FOREVER), next: vec![1, 2], label: None };
        Client {
            name: "any".to_owned(),
            steps: vec![stay, send(0), send(1)],
            first: vec![0],
            trackers: 0,
            awaits_event: None,
        }
    }

    fn program(client: &Client) -> String {
        let word = |step: &ClientStep| match step.action {
            ClientAction::Send { service, .. } => format!("send {}", usize::from(service)),
            _ => "stay".to_owned(),
        };
        let steps = client.steps.iter();
        let steps: Vec<String> =
            steps.map(|step| format!("{} {:?}", word(step), step.next)).collect();
        format!("{:?}: {}", client.first, steps.join(", "))
    }

    #[test]
    fn a_client_stays_at_last() {
        let program = |most| program(&any().waiting_forever_after(most));
        assert_eq!(program(0), "[0]: ");
        assert_eq!(program(1), "[0]: stay [1, 2], send 0 [3], send 1 [3]");
        assert_eq!(
            program(2),
            "[0]: stay [1, 2], send 0 [3], send 1 [3], stay [4, 5], send 0 [6], send 1 [6]"
        );
    }

    #[test]
    fn a_client_that_has_to_go_on_does() {
        let mut client = any();
        client.steps[0].action = ClientAction::Delay(0, 5);
        assert_eq!(program(&client.waiting_forever_after(1)), program(&client));
    }
}
