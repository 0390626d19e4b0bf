//! Binds a codel, or one of its states, elsewhere.

use dotgen_syntax::ast::{self, AstNode};

use super::{Assist, AssistKind, Cx};
use crate::source_map::bytes;

/// Binds a codel to a state without one, or moves one of several states of a codel to another codel of the
/// same machine.
pub(super) fn move_codel(cx: &Cx<'_, '_>) -> Vec<Assist> {
    moves(cx).unwrap_or_default()
}

fn moves(cx: &Cx<'_, '_>) -> Option<Vec<Assist>> {
    let codel: ast::Codel = cx.ancestor()?;
    let triggers = codel.triggers()?;
    if !cx.is_plain(codel.syntax()) {
        return None;
    }
    let map = cx.view.map();
    let name = codel.name()?;
    let (component, owner, _) = cx.codel_at(&bytes(name.range(map)))?;
    let machine = component.codels_of(owner);
    let bound = |state: &str| {
        let mut all = machine.iter().flat_map(|machine| &machine.triggers);
        all.any(|trigger| trigger.name == state)
    };
    let states: Vec<ast::State> = triggers.states().collect();
    let (first, last) = (states.first()?, states.last()?);
    let list = cx.node_range(first.syntax()).start..cx.node_range(last.syntax()).end;
    let mut out = Vec::new();
    let mut missing: Vec<&str> = Vec::new();
    for machine in machine.iter().flat_map(|machine| &machine.yields) {
        if machine.name != "ether"
            && !bound(&machine.name)
            && !missing.contains(&machine.name.as_str())
        {
            missing.push(&machine.name);
        }
    }
    for state in missing {
        out.push(Assist {
            id: "move-codel",
            title: format!("Move codel `{}` to state `{state}`", name.text(map)),
            kind: AssistKind::Move,
            edits: vec![cx.edit(list.clone(), state)],
        });
    }
    // One of several states to another codel.
    let selected = states.iter().position(|state| cx.touches(state.syntax()));
    let Some(index) = selected.filter(|_| states.len() > 1) else {
        return Some(out);
    };
    let state = cx.text(states[index].syntax()).to_owned();
    let removed = match states.get(index + 1) {
        Some(next) => {
            cx.node_range(states[index].syntax()).start..cx.node_range(next.syntax()).start
        }
        None => {
            cx.node_range(states[index - 1].syntax()).end..cx.node_range(states[index].syntax()).end
        }
    };
    for other in machine.iter().filter(|machine| machine.name != name.text(map)) {
        let Some(after) = other.triggers.last() else {
            continue;
        };
        let Some((file, place)) = cx.view.place(after.src) else {
            continue;
        };
        let end = usize::from(place.end());
        if file != cx.view.file || cx.slice(bytes(place)) != after.name {
            continue;
        }
        out.push(Assist {
            id: "move-state",
            title: format!("Give state `{state}` to codel `{}`", other.name),
            kind: AssistKind::Move,
            edits: vec![cx.edit(removed.clone(), ""), cx.edit(end..end, format!(", {state}"))],
        });
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{assert_not_offered, check};

    #[test]
    fn to_a_state_without_codel() {
        check(
            "move-codel",
            "component c { task t { codel<start> f() yield go; codel<stop> g$0() yield ether; }; };\n",
            "component c { task t { codel<start> f() yield go; codel<go> g() yield ether; }; };\n",
        );
        assert_not_offered(
            "move-codel",
            "component c { task t { codel<start> f$0() yield ether; }; };\n",
        );
    }

    #[test]
    fn one_of_several_states() {
        check(
            "move-state",
            "component c { task t { codel<start, a$0> f() yield a, b; codel<b> g() yield ether; }; };\n",
            "component c { task t { codel<start> f() yield a, b; codel<b, a> g() yield ether; }; };\n",
        );
        check(
            "move-state",
            "component c { task t { codel<a$0, start> f() yield a, b; codel<b> g() yield ether; }; };\n",
            "component c { task t { codel<start> f() yield a, b; codel<b, a> g() yield ether; }; };\n",
        );
    }
}
