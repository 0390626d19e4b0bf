//! The system of a workspace: the components of its folders, and their connections.

use std::collections::BTreeMap;
use std::sync::Arc;

use camino::{Utf8Path, Utf8PathBuf};
use dotgen_analysis::host::{Cancellable, UnitResult};
use dotgen_analysis::source_map::Locations;
use dotgen_diagram::system::Connection;
use smol_str::SmolStr;

use crate::workspace::snapshot::Snapshot;

/// The units of a system. Components of equal name in different folders have the folder in their names.
pub(super) struct WorkspaceSystem {
    pub(super) units: Vec<UnitResult>,
    pub(super) connections: Vec<Connection>,
    names: ComponentNames,
}

/// The names of components in the system, by folder and declared name.
#[derive(Default)]
struct ComponentNames {
    folders: Arc<Vec<Utf8PathBuf>>,
    renamed: BTreeMap<(usize, SmolStr), SmolStr>,
}

impl WorkspaceSystem {
    /// The system that a file belongs to.
    pub(super) fn new(snapshot: &Snapshot, path: &Utf8Path) -> Cancellable<WorkspaceSystem> {
        let mut units = snapshot.workspace_units(path)?;
        let names = ComponentNames::new(snapshot, &units);
        for unit in &mut units {
            names.rename(unit);
        }
        let all = snapshot.config.connections.iter();
        let connections = all.map(|(directory, connection)| {
            let folder = names.folder(directory);
            let port = |(component, port): &(String, String)| {
                (names.of(folder, component).to_string(), port.clone())
            };
            Connection { from: port(&connection.from), to: port(&connection.to) }
        });
        Ok(WorkspaceSystem { connections: connections.collect(), units, names })
    }

    /// The name of a component, as a file uses it.
    pub(super) fn name(&self, file: &Utf8Path, component: &str) -> String {
        self.names.of(self.names.folder(file), component).to_string()
    }
}

impl ComponentNames {
    fn new(snapshot: &Snapshot, units: &[UnitResult]) -> ComponentNames {
        let mut names =
            ComponentNames { folders: snapshot.folders.clone(), ..ComponentNames::default() };
        let mut declared: BTreeMap<SmolStr, Vec<usize>> = BTreeMap::new();
        for unit in units {
            for component in &unit.spec.components {
                let place = unit.locations.locate(component.src);
                let folder = place.and_then(|place| names.folder(&place.path));
                let folders = declared.entry(component.name.clone()).or_default();
                folders.extend(folder.filter(|folder| !folders.contains(folder)));
            }
        }
        for (name, folders) in declared.into_iter().filter(|declared| declared.1.len() > 1) {
            for folder in folders {
                let renamed = format!("{name} ({})", names.label(folder));
                names.renamed.insert((folder, name.clone()), renamed.into());
            }
        }
        names
    }

    /// The folder of a file.
    fn folder(&self, file: &Utf8Path) -> Option<usize> {
        let around =
            (0..self.folders.len()).filter(|folder| file.starts_with(&self.folders[*folder]));
        around.max_by_key(|folder| self.folders[*folder].as_str().len())
    }

    /// The last names in the path of a folder, as many as no other folder has. A point would end the name of
    /// a component.
    fn label(&self, folder: usize) -> String {
        let path = &self.folders[folder];
        let depth = path.components().count();
        let last = |path: &Utf8Path, count: usize| -> Utf8PathBuf {
            path.components().skip(path.components().count().saturating_sub(count)).collect()
        };
        let alone = |count: &usize| {
            let equal =
                self.folders.iter().filter(|other| last(other, *count) == last(path, *count));
            equal.count() == 1
        };
        let count = (1..depth).find(alone).unwrap_or(depth);
        last(path, count).as_str().replace('.', "_")
    }

    /// The name of a component that a folder declares.
    fn of<'n>(&'n self, folder: Option<usize>, component: &'n str) -> &'n str {
        let renamed = folder.and_then(|folder| self.renamed.get(&(folder, component.into())));
        renamed.map_or(component, SmolStr::as_str)
    }

    fn rename(&self, unit: &mut UnitResult) {
        let components = unit.spec.components.iter_enumerated();
        let renamed = components.filter_map(|(index, component)| {
            let folder = self.folder(&unit.locations.locate(component.src)?.path)?;
            Some((index, self.renamed.get(&(folder, component.name.clone()))?.clone()))
        });
        for (index, name) in renamed.collect::<Vec<_>>() {
            Arc::make_mut(&mut unit.spec).components[index].name = name;
        }
    }
}
