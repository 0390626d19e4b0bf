//! Payloads in CDR, from and to the bytes of the [glue](dotgen_codegen::codels::glue).

use dotgen_analysis::model::{Component, Param, Service, ServiceId, Spec, TypeId, TypeKind};
use dotgen_codegen::codels::cdr::{CdrReader, CdrWriter, Unions};
use dotgen_codegen::codels::value::{Reader, ValueError, Values, is_input, is_output};
use dotgen_codegen::template::throws::service_throws;
use serde_json::Value;

pub type GoalId = [u8; 16];

/// The status of a goal that succeeded.
pub const SUCCEEDED: i8 = 4;
/// The status of a goal that was cancelled.
pub const CANCELED: i8 = 5;
/// The status of a goal that ended with an exception.
pub const ABORTED: i8 = 6;

/// A moment since 1970.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Stamp {
    /// Seconds.
    pub sec: i32,
    /// Nanoseconds after the second.
    pub nanosec: u32,
}

/// A goal, with the moment of its acceptance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GoalInfo {
    pub id: GoalId,
    /// The moment.
    pub stamp: Stamp,
}

/// The end of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RequestEnd<'a> {
    /// The outputs, as bytes of the glue.
    Done(&'a [u8]),
    /// An exception.
    Failed {
        /// The full name.
        exception: &'a str,
        /// The members, as bytes of the glue.
        detail: &'a [u8],
    },
}

/// Payloads of one component.
#[derive(Debug, Clone, Copy)]
pub struct Payloads<'s> {
    spec: &'s Spec,
    component: &'s Component,
    values: Values<'s>,
}

type Bytes = Result<Vec<u8>, ValueError>;

impl<'s> Payloads<'s> {
    /// The payloads of a component.
    pub fn new(spec: &'s Spec, component: &'s Component) -> Self {
        Payloads { spec, component, values: Values::new(spec) }
    }

    /// The message of the data of a port.
    ///
    /// # Errors
    /// The bytes are not a value of the type.
    pub fn message(&self, ty: TypeId, data: &[u8]) -> Bytes {
        let mut out = writer();
        out.value(self.values, ty, &mut Reader::new(data))?;
        Ok(out.finish())
    }

    /// The data of a port in a message.
    ///
    /// # Errors
    /// The message is malformed.
    pub fn data(&self, ty: TypeId, message: &[u8]) -> Bytes {
        let mut out = Vec::new();
        reader(message)?.value(self.values, ty, &mut out)?;
        Ok(out)
    }

    /// The inputs in a request of a function or attribute.
    ///
    /// # Errors
    /// The request is malformed.
    pub fn inputs(&self, service: ServiceId, request: &[u8]) -> Bytes {
        self.read_inputs(service, &mut reader(request)?)
    }

    /// The response of a function or attribute.
    ///
    /// # Errors
    /// The bytes are not outputs of the service, or not members of the exception.
    pub fn response(&self, service: ServiceId, outcome: RequestEnd<'_>) -> Bytes {
        let mut out = writer();
        self.outcome(service, outcome, &mut out)?;
        Ok(out.finish())
    }

    /// The id and the inputs in a request of an activity.
    ///
    /// # Errors
    /// The request is malformed.
    pub fn goal(
        &self,
        service: ServiceId,
        request: &[u8],
    ) -> Result<(GoalId, Vec<u8>), ValueError> {
        let mut from = reader(request)?;
        let id = goal_id(&mut from)?;
        Ok((id, self.read_inputs(service, &mut from)?))
    }

    /// The response to a request of the result of an activity.
    ///
    /// # Errors
    /// The bytes are not outputs of the service, or not members of the exception.
    pub fn result(&self, service: ServiceId, status: i8, outcome: RequestEnd<'_>) -> Bytes {
        let mut out = writer();
        out.number(status.to_ne_bytes());
        self.outcome(service, outcome, &mut out)?;
        Ok(out.finish())
    }

    fn read_inputs(&self, service: ServiceId, from: &mut CdrReader<'_>) -> Bytes {
        let mut out = Vec::new();
        for param in self.params(service, is_input) {
            from.value(self.values, param.ty, &mut out)?;
        }
        Ok(out)
    }

    /// Writes outputs, which are zero after an exception, the name of the exception and its members.
    fn outcome(
        &self,
        service: ServiceId,
        outcome: RequestEnd<'_>,
        to: &mut CdrWriter,
    ) -> Result<(), ValueError> {
        let (exception, detail) = match outcome {
            RequestEnd::Done(outputs) => {
                let mut from = Reader::new(outputs);
                for param in self.params(service, is_output) {
                    to.value(self.values, param.ty, &mut from)?;
                }
                ("", &[][..])
            }
            RequestEnd::Failed { exception, detail } => {
                for param in self.params(service, is_output) {
                    let zero = self.values.encode(param.ty, &Value::Null)?;
                    to.value(self.values, param.ty, &mut Reader::new(&zero))?;
                }
                (exception, detail)
            }
        };
        to.text(exception.as_bytes());
        for ty in service_throws(self.component, service) {
            let resolved = self.spec.resolve_alias(ty);
            if !matches!(&self.spec.ty(resolved).kind, TypeKind::Exception { members } if !members.is_empty())
            {
                continue;
            }
            let is_raised = self.spec.full_name(ty).as_deref() == Some(exception);
            to.number(u32::from(is_raised).to_ne_bytes());
            if is_raised {
                to.value(self.values, ty, &mut Reader::new(detail))?;
            }
        }
        Ok(())
    }

    fn params(
        &self,
        service: ServiceId,
        is_wanted: fn(&Param) -> bool,
    ) -> impl Iterator<Item = &'s Param> {
        let service: Option<&'s Service> = self.component.services.get(service);
        let params = service.map_or(&[][..], |service| service.params.as_slice());
        params.iter().filter(move |param| is_wanted(param))
    }
}

/// The response to a request of an activity.
pub fn accepted(is_accepted: bool, stamp: Stamp) -> Vec<u8> {
    let mut out = writer();
    out.number([u8::from(is_accepted)]);
    write_stamp(stamp, &mut out);
    out.finish()
}

/// The id in a request of the result of an activity.
///
/// # Errors
/// The request is malformed.
pub fn result_of(request: &[u8]) -> Result<GoalId, ValueError> {
    goal_id(&mut reader(request)?)
}

/// The feedback of an activity: its state.
pub fn feedback(id: GoalId, state: &str) -> Vec<u8> {
    let mut out = writer();
    write_id(id, &mut out);
    out.text(state.as_bytes());
    out.finish()
}

/// The goal in a request to cancel. An id of zeros means all goals, a stamp all goals accepted until then.
///
/// # Errors
/// The request is malformed.
pub fn cancel(request: &[u8]) -> Result<GoalInfo, ValueError> {
    let mut from = reader(request)?;
    let id = goal_id(&mut from)?;
    let sec = i32::from_ne_bytes(from.number()?);
    let nanosec = u32::from_ne_bytes(from.number()?);
    let stamp = Stamp { sec, nanosec };
    Ok(GoalInfo { id, stamp })
}

/// The response to a request to cancel: 0 if goals are cancelled, 1 if that is refused, 2 if no goal has the
/// id, 3 if the goal has ended.
pub fn canceling(code: i8, goals: &[GoalInfo]) -> Vec<u8> {
    let mut out = writer();
    out.number(code.to_ne_bytes());
    write_length(goals.len(), &mut out);
    for goal in goals {
        write_goal(*goal, &mut out);
    }
    out.finish()
}

/// The status of goals.
pub fn statuses(goals: &[(GoalInfo, i8)]) -> Vec<u8> {
    let mut out = writer();
    write_length(goals.len(), &mut out);
    for (goal, status) in goals {
        write_goal(*goal, &mut out);
        out.number(status.to_ne_bytes());
    }
    out.finish()
}

fn writer() -> CdrWriter {
    CdrWriter::new(Unions::Branches)
}

fn reader(bytes: &[u8]) -> Result<CdrReader<'_>, ValueError> {
    CdrReader::new(bytes, Unions::Branches)
}

fn goal_id(from: &mut CdrReader<'_>) -> Result<GoalId, ValueError> {
    let mut out = GoalId::default();
    for byte in &mut out {
        [*byte] = from.number()?;
    }
    Ok(out)
}

fn write_id(id: GoalId, to: &mut CdrWriter) {
    for byte in id {
        to.number([byte]);
    }
}

fn write_length(length: usize, to: &mut CdrWriter) {
    to.number(u32::try_from(length).unwrap_or(u32::MAX).to_ne_bytes());
}

fn write_stamp(stamp: Stamp, to: &mut CdrWriter) {
    to.number(stamp.sec.to_ne_bytes());
    to.number(stamp.nanosec.to_ne_bytes());
}

fn write_goal(goal: GoalInfo, to: &mut CdrWriter) {
    write_id(goal.id, to);
    write_stamp(goal.stamp, to);
}
