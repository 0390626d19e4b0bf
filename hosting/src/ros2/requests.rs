//! Services and actions: requests to the engine, and its answers.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex, MutexGuard};

use dotgen_codegen::codels::value::{Values, is_output};
use dotgen_ros2::cdr::{self, GoalId, GoalInfo, Payloads, RequestEnd, Stamp};
use dotgen_ros2::node::Part;
use dotgen_runtime::hosts::{Message, OutsideRequest, RequestReply};
use serde_json::Value;
use zenoh::query::Query;

use super::replies::{Asked, Replies};
use super::topics::{Topic, now};
use crate::children::RunInbox;
use crate::clients::MAX_WAITING;
use crate::components::KnownComponent;
use dotgen_analysis::model::ServiceId;
use dotgen_timing::system::{self, ComponentId};

/// Maximum number of goals of an activity, with those that have ended: the oldest of these are forgotten.
const GOALS: usize = 128;

/// Maximum number of requests that wait for the result of a goal.
const RESULT_REQUESTS: usize = 16;

/// The status of a goal that the component has not accepted yet.
const ACCEPTED: i8 = 1;
/// The status of a goal that is executed.
const EXECUTING: i8 = 2;
/// The status of a goal that is interrupted on request.
const CANCELING: i8 = 3;

/// The requests of ROS 2 clients to all components of a run.
pub(super) struct Requests {
    pub(super) known: BTreeMap<ComponentId, KnownComponent>,
    pub(super) inbox: RunInbox,
    pub(super) replies: Replies,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    /// The requests that have not ended, by their numbers.
    pending: HashMap<u64, Pending>,
    /// By component and service.
    activities: HashMap<(ComponentId, ServiceId), Activity>,
}

struct Pending {
    component: ComponentId,
    service: ServiceId,
    wants: Wants,
}

enum Wants {
    Response(Asked),
    Goal(GoalId),
}

#[derive(Default)]
struct Activity {
    status: Option<Topic>,
    feedback: Option<Topic>,
    /// In order of acceptance.
    goals: Vec<Goal>,
}

struct Goal {
    info: GoalInfo,
    number: u64,
    status: i8,
    /// The response to requests of the result, when the goal has ended.
    result: Option<Vec<u8>>,
    waiting: Vec<Asked>,
}

impl Activity {
    fn publish(&self) {
        let all: Vec<_> = self.goals.iter().map(|goal| (goal.info, goal.status)).collect();
        if let Some(topic) = &self.status {
            topic.put(cdr::statuses(&all));
        }
    }
}

impl Requests {
    pub(super) fn new(
        known: BTreeMap<ComponentId, KnownComponent>,
        inbox: RunInbox,
    ) -> Arc<Requests> {
        Arc::new(Requests { known, inbox, replies: Replies::new(), state: Mutex::default() })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Adds the topic of the status of an activity.
    pub(super) fn add_status(&self, component: ComponentId, service: ServiceId, topic: Topic) {
        let mut state = self.state();
        let activity = state.activities.entry((component, service)).or_default();
        activity.status = Some(topic);
        activity.publish();
    }

    /// Adds the topic of the feedback of an activity.
    pub(super) fn add_feedback(&self, component: ComponentId, service: ServiceId, topic: Topic) {
        let mut state = self.state();
        let activity = state.activities.entry((component, service)).or_default();
        activity.feedback = Some(topic);
    }

    /// Removes the topics of a component from the graph.
    pub(super) fn leave(&self, component: ComponentId) {
        for (place, activity) in &mut self.state().activities {
            if place.0 == component {
                (activity.status, activity.feedback) = (None, None);
            }
        }
    }

    /// Handles a request to an endpoint with a key.
    pub(super) fn hear(&self, component: ComponentId, part: Part, key: &str, query: Query) {
        let Some((asked, payload)) = Asked::read(query, key, &self.replies) else {
            return;
        };
        match part {
            Part::Service(service) => self.call(component, service, asked, &payload),
            Part::SendGoal(service) => self.send_goal(component, service, asked, &payload),
            Part::GetResult(service) => self.get_result(component, service, asked, &payload),
            Part::CancelGoal(service) => self.cancel(component, service, asked, &payload),
            Part::Port(_) | Part::Feedback(_) | Part::Status(_) => {}
        }
    }

    fn payloads(&self, component: ComponentId) -> Payloads<'_> {
        let known = &self.known[&component];
        Payloads::new(&known.spec, known.component())
    }

    /// The service in the system, and the number of a further request to the component.
    fn admit(
        &self,
        state: &State,
        component: ComponentId,
        service: ServiceId,
    ) -> Result<(system::ServiceId, u64), String> {
        let known = &self.known[&component];
        let wanted = known.services.get(usize::from(service)).copied().flatten();
        let wanted = wanted.ok_or("this service cannot be requested in this run")?;
        let all = state.pending.values();
        if all.filter(|pending| pending.component == component).count() >= MAX_WAITING {
            return Err(format!(
                "too many requests: {MAX_WAITING} of `{}` have not ended; wait for some of them",
                known.component().name
            ));
        }
        Ok((wanted, self.inbox.number()))
    }

    fn call(&self, component: ComponentId, service: ServiceId, asked: Asked, payload: &[u8]) {
        let inputs = match self.payloads(component).inputs(service, payload) {
            Ok(input) => input,
            Err(why) => return self.replies.error(asked, why.to_string()),
        };
        let mut state = self.state();
        let (wanted, id) = match self.admit(&state, component, service) {
            Ok(pair) => pair,
            Err(why) => return self.replies.error(asked, why),
        };
        let pending = Pending { component, service, wants: Wants::Response(asked) };
        state.pending.insert(id, pending);
        self.bring(id, wanted, inputs);
    }

    fn bring(&self, id: u64, service: system::ServiceId, inputs: Vec<u8>) {
        let request = OutsideRequest { id, service, inputs };
        // After the end of the run, the queries end with the session.
        self.inbox.bring(Message::OutsideRequest(request));
    }

    /// A goal is accepted before the component decides, as a refusal has no reason in ROS 2.
    fn send_goal(&self, component: ComponentId, service: ServiceId, asked: Asked, payload: &[u8]) {
        let (goal, inputs) = match self.payloads(component).goal(service, payload) {
            Ok(goal) => goal,
            Err(why) => return self.replies.error(asked, why.to_string()),
        };
        let mut state = self.state();
        let admitted = self.admit(&state, component, service);
        let activity = state.activities.entry((component, service)).or_default();
        let stamp = now();
        let is_known = activity.goals.iter().any(|candidate| candidate.info.id == goal);
        if activity.goals.len() >= GOALS
            && admitted.is_ok()
            && !is_known
            && let Some(oldest) = activity.goals.iter().position(|goal| goal.result.is_some())
        {
            activity.goals.remove(oldest);
        }
        let (Ok((wanted, number)), false, true) =
            (admitted, is_known, activity.goals.len() < GOALS)
        else {
            return self.replies.send(asked, cdr::accepted(false, stamp));
        };
        activity.goals.push(Goal {
            info: GoalInfo { id: goal, stamp },
            number,
            status: ACCEPTED,
            result: None,
            waiting: Vec::new(),
        });
        activity.publish();
        self.replies.send(asked, cdr::accepted(true, stamp));
        let pending = Pending { component, service, wants: Wants::Goal(goal) };
        state.pending.insert(number, pending);
        self.bring(number, wanted, inputs);
    }

    fn get_result(&self, component: ComponentId, service: ServiceId, asked: Asked, payload: &[u8]) {
        let id = match cdr::result_of(payload) {
            Ok(bytes) => bytes,
            Err(why) => return self.replies.error(asked, why.to_string()),
        };
        let mut state = self.state();
        let activity = state.activities.entry((component, service)).or_default();
        let goal = activity.goals.iter_mut().find(|goal| goal.info.id == id);
        let Some(goal) = goal else {
            let unknown = self.result(component, service, 0, FORGOTTEN);
            return self.replies.send(asked, unknown);
        };
        if let Some(bytes) = &goal.result {
            self.replies.send(asked, bytes.clone());
        } else {
            // The oldest request has most likely been given up.
            if goal.waiting.len() >= RESULT_REQUESTS {
                goal.waiting.remove(0);
            }
            goal.waiting.push(asked);
        }
    }

    fn cancel(&self, component: ComponentId, service: ServiceId, asked: Asked, payload: &[u8]) {
        let wanted = match cdr::cancel(payload) {
            Ok(cancel) => cancel,
            Err(why) => return self.replies.error(asked, why.to_string()),
        };
        let mut state = self.state();
        let activity = state.activities.entry((component, service)).or_default();
        let (is_one, is_timed) = (wanted.id != [0; 16], wanted.stamp != Stamp::default());
        let time = |stamp: Stamp| (stamp.sec, stamp.nanosec);
        let is_wanted = |goal_info: GoalInfo| {
            let earlier = is_timed && time(goal_info.stamp) <= time(wanted.stamp);
            (is_one && goal_info.id == wanted.id) || earlier || (!is_one && !is_timed)
        };
        let mut canceling = Vec::new();
        for goal in &mut activity.goals {
            if is_wanted(goal.info) && goal.result.is_none() {
                goal.status = CANCELING;
                canceling.push(goal.info);
                self.inbox.bring(Message::Abort(goal.number));
            }
        }
        let is_known = activity.goals.iter().any(|goal| goal.info.id == wanted.id);
        let code = match (canceling.is_empty(), is_one, is_known) {
            (false, ..) => 0,
            (true, false, _) => 1,
            (true, true, false) => 2,
            (true, true, true) => 3,
        };
        activity.publish();
        self.replies.send(asked, cdr::canceling(code, &canceling));
    }

    /// The result of a goal. One that has no form, which only a codel with wrong data can cause, is that of
    /// a failure without detail.
    fn result(
        &self,
        component: ComponentId,
        service: ServiceId,
        status: i8,
        outcome: RequestEnd<'_>,
    ) -> Vec<u8> {
        let payloads = self.payloads(component);
        let result = payloads.result(service, status, outcome);
        let result = result.or_else(|_| payloads.result(service, cdr::ABORTED, UNREADABLE));
        result.unwrap_or_default()
    }

    /// Publishes the new state of an activity as feedback.
    pub(super) fn entered(&self, id: u64, entered: &str) {
        let state = self.state();
        let pending = state.pending.get(&id);
        let Some(Pending { component, service, wants: Wants::Goal(goal) }) = pending else {
            return;
        };
        let activity = state.activities.get(&(*component, *service));
        if let Some(topic) = activity.and_then(|activity| activity.feedback.as_ref()) {
            topic.put(cdr::feedback(*goal, entered));
        }
    }

    /// Passes an answer of the engine on.
    pub(super) fn answer(&self, id: u64, answer: &RequestReply) {
        let mut state = self.state();
        let Some(Pending { component, service, .. }) = state.pending.get(&id) else {
            return;
        };
        let (component, service) = (*component, *service);
        let zeros;
        let outcome = match answer {
            RequestReply::Accepted => {
                let activity = state.activities.entry((component, service)).or_default();
                let goal = activity.goals.iter_mut().find(|goal| goal.number == id);
                if let Some(goal) = goal.filter(|goal| goal.status == ACCEPTED) {
                    goal.status = EXECUTING;
                    activity.publish();
                }
                return;
            }
            RequestReply::Done(outputs) if outputs.is_empty() => {
                zeros = self.zeros(component, service);
                RequestEnd::Done(&zeros)
            }
            RequestReply::Done(outputs) => RequestEnd::Done(outputs),
            RequestReply::Failed { exception, detail } => RequestEnd::Failed { exception, detail },
        };
        match state.pending.remove(&id).map(|pending| pending.wants) {
            Some(Wants::Response(asked)) => {
                let payloads = self.payloads(component);
                let response = payloads.response(service, outcome);
                let response = response.or_else(|_| payloads.response(service, UNREADABLE));
                self.replies.send(asked, response.unwrap_or_default());
            }
            Some(Wants::Goal(goal)) => {
                let activity = state.activities.entry((component, service)).or_default();
                if let Some(goal) =
                    activity.goals.iter_mut().find(|candidate| candidate.info.id == goal)
                {
                    let was_canceled = goal.status == CANCELING;
                    goal.status = match outcome {
                        // The state `stop` ends an activity like any other state.
                        RequestEnd::Done(_) if was_canceled => cdr::CANCELED,
                        RequestEnd::Done(_) => cdr::SUCCEEDED,
                        RequestEnd::Failed { exception, .. }
                            if was_canceled && exception == "::genom::interrupted" =>
                        {
                            cdr::CANCELED
                        }
                        RequestEnd::Failed { .. } => cdr::ABORTED,
                    };
                    let result = self.result(component, service, goal.status, outcome);
                    for asked in goal.waiting.drain(..) {
                        self.replies.send(asked, result.clone());
                    }
                    goal.result = Some(result);
                }
                activity.publish();
            }
            None => {}
        }
    }

    /// The outputs of a service of a simulated component.
    fn zeros(&self, component: ComponentId, service: ServiceId) -> Vec<u8> {
        let known = &self.known[&component];
        let values = Values::new(&known.spec);
        let service = &known.component().services[service];
        let outputs = service.params.iter().filter(|param| is_output(param));
        let zeros = outputs.filter_map(|output| values.encode(output.ty, &Value::Null).ok());
        zeros.collect::<Vec<_>>().concat()
    }
}

const FORGOTTEN: RequestEnd<'_> = RequestEnd::Failed { exception: "", detail: &[] };

const UNREADABLE: RequestEnd<'_> =
    RequestEnd::Failed { exception: "::dotgen::unreadable", detail: &[] };
