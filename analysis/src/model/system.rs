//! Components that exchange data through ports: the connections of outputs to inputs, and the codels of other
//! components that a codel excludes because of them.

use rustc_hash::FxHashMap;
use typed_index_collections::TiVec;

use super::{
    CodelRef, Component, ComponentKind, OwnerName, ParamSource, PortDir, PortId, Spec, TypeId,
};

/// A component of a system, with the specification it belongs to.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// The specification with its types.
    pub spec: &'a Spec,
    pub component: &'a Component,
    /// Index of the specification.
    pub number: usize,
}

/// `a.in_port` is fed by `b.out_port`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Connection {
    /// Component and output port.
    pub from: (String, String),
    /// Component and input port.
    pub to: (String, String),
}

/// A port: indexes of its component in [`System::parts`] and of the port there.
pub type PortRef = (usize, PortId);

/// Components with the connections between them.
#[derive(Debug)]
pub struct System<'a> {
    /// The components, without interfaces.
    pub parts: Vec<Part<'a>>,
    connections: &'a [Connection],
    /// Output ports by the name of their type.
    outputs: FxHashMap<String, Vec<PortRef>>,
}

/// A codel of another component that cannot run at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RemoteExclusion {
    /// Index of the component in [`System::parts`].
    pub part: usize,
    pub codel: CodelRef,
    /// The output port that both use.
    pub port: PortRef,
}

/// The components of specifications. A component declared by several of them counts once.
pub fn parts<'a>(specs: impl IntoIterator<Item = &'a Spec>) -> Vec<Part<'a>> {
    let mut parts: Vec<Part<'_>> = Vec::new();
    let mut known = rustc_hash::FxHashSet::default();
    for (number, spec) in specs.into_iter().enumerate() {
        for component in &spec.components {
            if component.kind == ComponentKind::Component && known.insert(&component.name) {
                parts.push(Part { spec, component, number });
            }
        }
    }
    parts
}

impl<'a> System<'a> {
    /// A system with known connections; the others are found by type and name.
    pub fn new(
        parts: impl IntoIterator<Item = Part<'a>>,
        connections: &'a [Connection],
    ) -> System<'a> {
        let parts = parts.into_iter();
        let parts: Vec<Part<'_>> =
            parts.filter(|part| part.component.kind == ComponentKind::Component).collect();
        let mut outputs: FxHashMap<String, Vec<PortRef>> = FxHashMap::default();
        for (number, part) in parts.iter().enumerate() {
            for (index, port) in part.component.ports.iter_enumerated() {
                if port.dir == PortDir::Out {
                    let ty = type_name(part.spec, port.data);
                    outputs.entry(ty).or_default().push((number, index));
                }
            }
        }
        System { parts, connections, outputs }
    }

    /// Output ports that feed an input port: the configured ones; otherwise those of other components with
    /// equal name and type; otherwise the only one of that type.
    pub fn sources(&self, (part, port): PortRef) -> Vec<PortRef> {
        let reader = &self.parts[part];
        let port = &reader.component.ports[port];
        let configured: Vec<PortRef> = self
            .connections
            .iter()
            .filter(|connection| {
                connection.to.0 == reader.component.name.as_str()
                    && connection.to.1 == port.name.as_str()
            })
            .filter_map(|connection| self.output(&connection.from.0, &connection.from.1))
            .collect();
        if !configured.is_empty() {
            return configured;
        }
        let name = |port: &PortRef| &self.parts[port.0].component.ports[port.1].name;
        let of_type = self.outputs.get(&type_name(reader.spec, port.data));
        let others = of_type.into_iter().flatten();
        let candidates: Vec<PortRef> = others.filter(|ty| ty.0 != part).copied().collect();
        let mut same_name =
            candidates.iter().filter(|candidate| *name(candidate) == port.name).copied().peekable();
        match (same_name.peek(), candidates.len()) {
            (Some(_), _) => same_name.collect(),
            (None, 1) => candidates,
            _ => Vec::new(),
        }
    }

    /// Index of a component.
    pub fn part(&self, name: &str) -> Option<usize> {
        let mut parts = self.parts.iter();
        parts.position(|part| part.component.name.as_str() == name)
    }

    fn output(&self, component: &str, port: &str) -> Option<PortRef> {
        let part = self.part(component)?;
        let mut ports = self.parts[part].component.ports.iter_enumerated();
        let found = ports.find(|(_, candidate)| {
            candidate.dir == PortDir::Out && candidate.name.as_str() == port
        });
        found.map(|(index, _)| (part, index))
    }

    /// The ports that hold the data of a port: itself, or the outputs that feed it.
    pub fn data_of(&self, port: PortRef) -> Vec<PortRef> {
        match self.parts[port.0].component.ports[port.1].dir {
            PortDir::Out => vec![port],
            PortDir::In => self.sources(port),
        }
    }

    /// The codels of other components that use the data of a port that a codel uses, each once for
    /// every port. Readers exclude readers, as within a component.
    pub fn exclusions(&self, part: usize, codel: CodelRef) -> Vec<RemoteExclusion> {
        let own = self.parts[part].component.codel(codel);
        let mut shared: Vec<PortRef> = Vec::new();
        for param in &own.params {
            if let ParamSource::Port(port) = param.source {
                shared.extend(self.data_of((part, port)));
            }
        }
        shared.sort_unstable();
        shared.dedup();
        let mut out = Vec::new();
        if shared.is_empty() {
            return out;
        }
        for (other, entry) in self.parts.iter().enumerate().filter(|(other, _)| *other != part) {
            let ports = entry.component.ports.keys();
            let meets: TiVec<PortId, Vec<PortRef>> = ports
                .map(|port| {
                    let mut locks = self.data_of((other, port));
                    locks.retain(|lock| shared.contains(lock));
                    locks
                })
                .collect();
            if meets.iter().all(Vec::is_empty) {
                continue;
            }
            for codel in entry.component.all_codels() {
                let mut found: Vec<PortRef> = Vec::new();
                for param in &entry.component.codel(codel).params {
                    if let ParamSource::Port(port) = param.source {
                        found.extend(&meets[port]);
                    }
                }
                found.sort_unstable();
                found.dedup();
                let part = other;
                out.extend(found.into_iter().map(|port| RemoteExclusion { part, codel, port }));
            }
        }
        out
    }

    /// For messages: ``"`go_codel` of activity `go` of `nav` (port `pom.pose`)"``.
    pub fn describe(&self, exclusion: &RemoteExclusion) -> String {
        let component = self.parts[exclusion.part].component;
        format!(
            "`{}` of {} of `{}` (port `{}`)",
            component.codel(exclusion.codel).name,
            OwnerName::of(component, exclusion.codel.owner),
            component.name,
            self.port_name(exclusion.port)
        )
    }

    /// `component.port`
    pub fn port_name(&self, (part, port): PortRef) -> String {
        let component = self.parts[part].component;
        format!("{}.{}", component.name, component.ports[port].name)
    }
}

/// The name of a type, aliases resolved.
pub fn type_name(spec: &Spec, ty: TypeId) -> String {
    spec.full_name(spec.resolve_alias(ty)).unwrap_or_default()
}

/// Names as one text; names beyond `many` as a number.
pub fn listed(names: &[String], many: usize) -> String {
    match names.get(..many) {
        Some(first) if names.len() > many => {
            format!("{} and {} more", first.join(", "), names.len() - many)
        }
        _ => names.join(", "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::Fixture;

    const POM: &str = "struct s { long x; };\ncomponent pom {\n  port out s pose;\n  task t { period 5 ms; codel<start> pom_t(out pose) yield pause::start; };\n};\n";
    const NAV: &str = "struct s { long x; };\ncomponent nav {\n  port in s pose;\n  port in s other;\n  ids { s x; };\n  task t { period 5 ms; codel<start> nav_t(in pose, out x) yield pause::start; };\n  activity go() { task t; codel<start> nav_go(in other) yield ether; codel<stop> nav_stop(out x) yield ether; };\n};\n";
    const LOG: &str = "struct s { long x; };\ncomponent log {\n  port in s position;\n  port in s none;\n  ids { s x; };\n  function f() { codel log_f(in position, out x); };\n};\n";

    fn excluded(files: &str, connections: &[(&str, &str)], component: &str) -> Vec<String> {
        let fixture = Fixture::new(files);
        let units: Vec<_> = fixture
            .paths()
            .iter()
            .map(|path| fixture.analysis().root_unit(path).unwrap())
            .collect();
        let port = |text: &str| {
            let (component, port) = text.split_once('.').unwrap();
            (component.to_owned(), port.to_owned())
        };
        let connections: Vec<_> = connections
            .iter()
            .map(|(to, from)| Connection { from: port(from), to: port(to) })
            .collect();
        let system = System::new(parts(units.iter().map(|unit| &*unit.spec)), &connections);
        let part = system.part(component).unwrap();
        let own = system.parts[part].component;
        let mut out = Vec::new();
        for at in own.all_codels() {
            for exclusion in system.exclusions(part, at) {
                out.push(format!("{}: {}", own.codel(at).name, system.describe(&exclusion)));
            }
        }
        out
    }

    fn all() -> String {
        format!("//- /a.gen\n{POM}//- /b.gen\n{NAV}//- /c.gen\n{LOG}")
    }

    #[test]
    fn ports_of_one_name_and_type_meet() {
        assert_eq!(
            excluded(&all(), &[], "pom"),
            [
                "pom_t: `nav_t` of task `t` of `nav` (port `pom.pose`)",
                "pom_t: `nav_go` of activity `go` of `nav` (port `pom.pose`)",
                // The only output of that type.
                "pom_t: `log_f` of function `f` of `log` (port `pom.pose`)",
            ]
        );
        // Readers exclude readers, but not those of their own component again.
        assert_eq!(
            excluded(&all(), &[], "log"),
            [
                "log_f: `pom_t` of task `t` of `pom` (port `pom.pose`)",
                "log_f: `nav_t` of task `t` of `nav` (port `pom.pose`)",
                "log_f: `nav_go` of activity `go` of `nav` (port `pom.pose`)",
            ]
        );
    }

    #[test]
    fn the_configuration_wins_over_names() {
        let second = POM.replace("pom", "gps");
        let files = format!("{}//- /d.gen\n{second}", all());
        // Two of that name: only equal names are connected.
        assert_eq!(
            excluded(&files, &[], "gps"),
            ["gps_t: `nav_t` of task `t` of `nav` (port `gps.pose`)"]
        );
        let connections = [("nav.pose", "pom.pose"), ("log.position", "gps.pose")];
        assert_eq!(
            excluded(&files, &connections, "gps"),
            ["gps_t: `log_f` of function `f` of `log` (port `gps.pose`)"]
        );
    }

    #[test]
    fn other_types_and_interfaces_do_not_meet() {
        let other =
            POM.replace("long", "double").replace("struct s", "struct t").replace("out s", "out t");
        let interface = "struct s { long x; };\ninterface i { port out s pose; };\n";
        let files = format!("//- /a.gen\n{other}//- /b.gen\n{NAV}//- /c.gen\n{interface}");
        assert_eq!(excluded(&files, &[], "nav"), [""; 0]);
    }
}
