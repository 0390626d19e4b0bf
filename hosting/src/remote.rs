//! Components of runs on other machines.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard};

use serde_json::{Value, json};

/// Maximum number of components, and of runs with a component of the same host and name. Others are ignored,
/// so that no peer can fill the memory of this machine.
const MAX: usize = 256;

/// The sessions that provide each component now, by host and name.
type Providers = BTreeMap<(String, String), BTreeSet<String>>;

/// The components of other runs that have been seen. Copies share them.
#[derive(Debug, Clone, Default)]
pub struct RemoteComponents(Arc<Mutex<Providers>>);

impl RemoteComponents {
    fn all(&self) -> MutexGuard<'_, Providers> {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Records that a session provides a component from now on, or provides it no longer. Returns true if the
    /// component has appeared or disappeared by that.
    pub fn set(&self, host: &str, component: &str, session: &str, provides: bool) -> bool {
        let mut all = self.all();
        let place = (host.to_owned(), component.to_owned());
        if !provides {
            let sessions = all.get_mut(&place);
            return sessions.is_some_and(|all| all.remove(session) && all.is_empty());
        }
        if all.len() >= MAX && !all.contains_key(&place) {
            // One that has disappeared makes room.
            let mut absent = all.iter().filter(|(_, sessions)| sessions.is_empty());
            let Some(absent) = absent.next().map(|(place, _)| place.clone()) else {
                return false;
            };
            all.remove(&absent);
        }
        let sessions = all.entry(place).or_default();
        let appears = sessions.is_empty();
        if sessions.len() < MAX {
            sessions.insert(session.to_owned());
        }
        appears
    }

    /// Returns the components as a list in JSON.
    pub(crate) fn list(&self) -> Vec<Value> {
        let all = self.all();
        let list = all.iter().map(|((host, component), sessions)| {
            json!({"host": host, "component": component, "present": !sessions.is_empty()})
        });
        list.collect()
    }
}

/// Returns the name of this machine.
#[cfg(unix)]
pub fn host_name() -> String {
    let name = rustix::system::uname();
    name.nodename().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_component_disappears_with_its_last_session() {
        let remote = RemoteComponents::default();
        assert!(remote.set("robot", "arm", "1", true));
        assert!(!remote.set("robot", "arm", "1", true));
        assert!(!remote.set("robot", "arm", "2", true));
        assert!(!remote.set("robot", "arm", "1", false));
        assert!(!remote.set("robot", "arm", "1", false));
        assert!(remote.set("robot", "arm", "2", false));
        assert!(!remote.set("robot", "leg", "2", false));
        let absent = json!({"host": "robot", "component": "arm", "present": false});
        assert_eq!(remote.list(), [absent]);
    }

    #[test]
    fn the_number_of_components_is_limited() {
        let remote = RemoteComponents::default();
        for number in 0..=MAX {
            let appears = remote.set("robot", &number.to_string(), "1", true);
            assert_eq!(appears, number < MAX);
        }
        assert_eq!(remote.list().len(), MAX);
    }
}
