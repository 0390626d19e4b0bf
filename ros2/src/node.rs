//! The endpoints of a component.

use dotgen_analysis::model::{
    Component, Param, Port, PortDir, PortId, Scope, ScopeKind, Service, ServiceId, ServiceKind,
    Spec, TypeKind,
};
use dotgen_analysis::phrase::Phrase;
use dotgen_codegen::codels::value::{is_input, is_output};
use dotgen_codegen::template::throws::service_throws;

use crate::common;
use crate::conversion::{Conversion, Conversions};
use crate::description::{Base, CANCEL_GOAL, Count, Field, STATUS_ARRAY, Types};
use crate::mapping::{Mapping, Obstacle, Place, distinct};
use crate::masquerade;
use crate::names;
use crate::refusal::Refusal;
use crate::wire::{self, Kind, NodeId, Qos};

/// The part of a component that an endpoint serves, as index of its ports or services.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Part {
    Port(PortId),
    /// A function or attribute.
    Service(ServiceId),
    /// An activity: its requests.
    SendGoal(ServiceId),
    /// An activity: its replies.
    GetResult(ServiceId),
    /// An activity: its interruption.
    CancelGoal(ServiceId),
    /// An activity: its states.
    Feedback(ServiceId),
    /// An activity: the status of its goals.
    Status(ServiceId),
}

/// A publisher, subscription or service of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Endpoint {
    /// The part of the component.
    pub part: Part,
    pub kind: Kind,
    /// The name with its namespace: `/demo/pose`.
    pub topic: String,
    /// The type: `or_t3d/msg/Pos`.
    pub type_name: String,
    /// The hash of the type.
    pub hash: String,
    /// The quality of service.
    pub qos: Qos,
    /// True for a `multiple` port: only its instances exist in ROS 2.
    pub multiple: bool,
}

impl Endpoint {
    /// The endpoint of an instance of a `multiple` port.
    ///
    /// # Errors
    /// In words: the instance has no name in ROS 2.
    pub fn instance(&self, name: &str) -> Result<Endpoint, String> {
        Ok(Endpoint {
            topic: self.topic.clone() + &names::topic([name])?,
            multiple: false,
            ..self.clone()
        })
    }

    /// The Zenoh key. For a `multiple` port, the key expression of all its instances.
    pub fn key(&self, domain: u32) -> String {
        let all = if self.multiple { "/*" } else { "" };
        let topic = format!("{}{all}", self.topic);
        wire::key(domain, &topic, &self.type_name, &self.hash)
    }

    /// The liveliness token, by the node and the number of the endpoint in its session.
    pub fn token(&self, node: NodeId<'_>, number: u32) -> String {
        let Endpoint { kind, topic, type_name, hash, qos, .. } = self;
        node.endpoint_token(number, *kind, topic, type_name, hash, *qos)
    }
}

/// A component as a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Node {
    /// The name. The namespace is empty.
    pub name: String,
    /// The ROS domain.
    pub domain: u32,
    /// What it offers, in order of declaration, ports first.
    pub endpoints: Vec<Endpoint>,
    /// Ports and services that it does not offer.
    pub refused: Vec<Refusal>,
    /// The descriptions of all types.
    pub types: Types,
    /// Conversions of ports with common messages, by rules and pragmas.
    pub conversions: Conversions,
}

/// Lists the endpoints of a component. Ports with a conversion, or a type that masquerades as a common
/// message, have its message.
///
/// # Errors
/// The component itself has no name in ROS 2, or its package has no name.
pub fn endpoints(
    spec: &Spec,
    component: &Component,
    domain: u32,
    mut conversions: Conversions,
) -> Result<Node, Vec<Refusal>> {
    let mut mapping = Mapping::new(spec);
    let offered = offer(&mut mapping, spec, component, &mut conversions);
    let (endpoints, refused) = offered.map_err(|error| vec![error])?;
    Ok(Node {
        name: component.name.to_string(),
        domain,
        endpoints,
        refused,
        types: mapping.types,
        conversions,
    })
}

/// Adds the types of a component to a mapping, and lists its endpoints. Adds the conversions of pragmas.
pub(crate) fn offer(
    mapping: &mut Mapping<'_>,
    spec: &Spec,
    component: &Component,
    conversions: &mut Conversions,
) -> Result<(Vec<Endpoint>, Vec<Refusal>), Refusal> {
    let part = || format!("component `{}`", component.name);
    let name =
        names::topic([component.name.as_str()]).map_err(|why| Obstacle { why, src: component.src });
    let package = name.and_then(|_| mapping.package(&[module(component)], component.src));
    let package = package.map_err(|error| refusal(part(), error))?;
    let mut offer = Offer { mapping, spec, component, package, endpoints: Vec::new() };
    let mut refused = Vec::new();
    for (index, port) in component.ports.iter_enumerated() {
        let masked = match conversions.remove(&index) {
            Some(conversion) => Ok(Some(conversion)),
            None => masquerade::conversion(spec, port),
        };
        let masked = masked.map_err(|why| Obstacle { why, src: port.src });
        let offered = masked.and_then(|conversion| {
            offer.port(index, port, conversion.as_ref())?;
            conversions.extend(conversion.map(|conversion| (index, conversion)));
            Ok(())
        });
        if let Err(error) = offered {
            let part = format!("port `{}.{}`", component.name, port.name);
            refused.push(refusal(part, error));
        }
    }
    for (index, service) in component.services.iter_enumerated() {
        if let Err(error) = offer.service(index, service) {
            let part = format!("service `{}.{}`", component.name, service.name);
            refused.push(refusal(part, error));
        }
    }
    Ok((offer.endpoints, refused))
}

fn refusal(part: String, obstacle: Obstacle) -> Refusal {
    Refusal { part, why: obstacle.why, src: obstacle.src }
}

/// The scope that a component is for its declarations.
fn module(component: &Component) -> Scope {
    Scope { kind: ScopeKind::Module, name: component.name.clone() }
}

/// The endpoints of a component, as far as they are found.
struct Offer<'a, 's> {
    mapping: &'a mut Mapping<'s>,
    spec: &'a Spec,
    component: &'a Component,
    package: String,
    endpoints: Vec<Endpoint>,
}

impl Offer<'_, '_> {
    fn port(
        &mut self,
        index: PortId,
        port: &Port,
        conversion: Option<&Conversion>,
    ) -> Result<(), Obstacle> {
        let obstacle = |why| Obstacle { why, src: port.src };
        let topic = [self.component.name.as_str(), port.name.as_str()];
        let topic = names::topic(topic).map_err(obstacle)?;
        let message = if let Some(conversion) = conversion {
            common::add(&conversion.message, &mut self.mapping.types);
            conversion.message.clone()
        } else {
            let place = Place {
                package: self.package.clone(),
                local: names::camel(&port.name).map_err(obstacle)?,
                src: port.src,
            };
            self.mapping.message(port.data, &place)?
        };
        // A port keeps its data: who joins later reads it too.
        let (kind, qos) = match port.dir {
            PortDir::Out => (Kind::Publisher, Qos::Latched),
            PortDir::In => (Kind::Subscription, Qos::Volatile),
        };
        self.add(Part::Port(index), kind, topic, &message, qos);
        if let Some(last) = self.endpoints.last_mut() {
            last.multiple = port.multiple;
        }
        Ok(())
    }

    fn service(&mut self, index: ServiceId, service: &Service) -> Result<(), Obstacle> {
        let obstacle = |why| Obstacle { why, src: service.src };
        let topic = [self.component.name.as_str(), service.name.as_str()];
        let topic = names::topic(topic).map_err(obstacle)?;
        let is_action = service.kind == ServiceKind::Activity;
        let local = names::service(&service.name, is_action).map_err(obstacle)?;
        let folder = if is_action { "action" } else { "srv" };
        let name = format!("{}/{folder}/{local}", self.package);
        let origin = Phrase::words("service ").and_name(service.name.as_str());
        self.mapping.claim(&name, origin, service.src)?;
        let inputs = self.params(service, is_input, &local)?;
        let mut outputs = self.params(service, is_output, &local)?;
        self.exceptions(index, &mut outputs)?;
        distinct(&inputs, service.src)?;
        distinct(&outputs, service.src)?;
        if !is_action {
            self.mapping.types.service(&name, inputs, outputs);
            let part = Part::Service(index);
            self.add(part, Kind::Server, topic, &name, Qos::Volatile);
            return Ok(());
        }
        let state = vec![Field::new("state", Base::String)];
        self.mapping.types.action(&name, inputs, outputs, state);
        let of = |text: &str| format!("{name}_{text}");
        let (server, publisher) = (Kind::Server, Kind::Publisher);
        let (volatile, latched) = (Qos::Volatile, Qos::Latched);
        let all = [
            (Part::SendGoal(index), server, "send_goal", of("SendGoal"), volatile),
            (Part::GetResult(index), server, "get_result", of("GetResult"), volatile),
            (Part::CancelGoal(index), server, "cancel_goal", CANCEL_GOAL.to_owned(), volatile),
            (Part::Feedback(index), publisher, "feedback", of("FeedbackMessage"), volatile),
            (Part::Status(index), publisher, "status", STATUS_ARRAY.to_owned(), latched),
        ];
        for (part, kind, word, ty, qos) in all {
            self.add(part, kind, format!("{topic}/_action/{word}"), &ty, qos);
        }
        Ok(())
    }

    /// Fields for the parameters of one direction.
    fn params(
        &mut self,
        service: &Service,
        is_wanted: fn(&Param) -> bool,
        local: &str,
    ) -> Result<Vec<Field>, Obstacle> {
        let wanted = service.params.iter().filter(|param| is_wanted(param));
        wanted
            .map(|param| {
                let place = Place {
                    package: self.package.clone(),
                    local: local.to_owned(),
                    src: param.src,
                };
                self.mapping.field(&param.name, param.ty, &place)
            })
            .collect()
    }

    /// The fields that say how a service ended.
    fn exceptions(&mut self, service: ServiceId, out: &mut Vec<Field>) -> Result<(), Obstacle> {
        if out.iter().any(|field| field.name == "exception") {
            return Err(Obstacle {
                why: "an output becomes `exception`, a field of every response: rename it"
                    .to_owned(),
                src: self.component.services[service].src,
            });
        }
        out.push(Field::new("exception", Base::String));
        for ty in service_throws(self.component, service) {
            let known_type = self.spec.ty(self.spec.resolve_alias(ty));
            let has_members =
                matches!(&known_type.kind, TypeKind::Exception { members } if !members.is_empty());
            if !has_members {
                continue;
            }
            let full = self.spec.full_name(ty).unwrap_or_default();
            let place =
                Place { package: self.package.clone(), local: String::new(), src: known_type.src };
            let mut field = self.mapping.field(&full.replace("::", "_"), ty, &place)?;
            field.ty.count = Count::AtMost(1);
            out.push(field);
        }
        Ok(())
    }

    fn add(&mut self, part: Part, kind: Kind, topic: String, type_name: &str, qos: Qos) {
        self.endpoints.push(Endpoint {
            part,
            kind,
            topic,
            type_name: type_name.to_owned(),
            hash: self.mapping.types.hash(type_name),
            qos,
            multiple: false,
        });
    }
}
