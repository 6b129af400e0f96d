//! The services of a managed node, AMCL's, and the next motion.

use super::clock::RosClock;
use super::maker::{Maker, reliable};
use crate::engine::{Engine, one_line};
use crate::lifecycle::Lifecycle;
use crate::messages::{
    ChangeStateRequest, ChangeStateResponse, Empty, GetAvailableStatesResponse, GetAvailableTransitionsResponse,
    GetStateResponse, TransitionEvent, TriggerResponse,
};
use ros2_client::Message;
use ros2_client::dds::{Publisher, Server};
use smol::LocalExecutor;
use smol::channel::Sender;
use std::rc::Rc;
use std::sync::Arc;
use vibrissa::tasks::plan::to_json;
use vibrissa_core::Result;

/// The services of a managed node, AMCL's, and the next motion.
pub(super) struct Services {
    change: Server<ChangeStateRequest, ChangeStateResponse>,
    state: Server<Empty, GetStateResponse>,
    states: Server<Empty, GetAvailableStatesResponse>,
    changes: Server<Empty, GetAvailableTransitionsResponse>,
    graph: Server<Empty, GetAvailableTransitionsResponse>,
    anywhere: Server<Empty, Empty>,
    plan: Server<Empty, TriggerResponse>,
    events: Publisher<TransitionEvent>,
}

impl Services {
    pub(super) fn new(maker: &mut Maker<'_>) -> Result<Self> {
        let node = maker.parameters.name.clone();
        let own = |name: &str| format!("{node}/{name}");
        let package = "lifecycle_msgs";
        Ok(Self {
            change: maker.server(&own("change_state"), (package, "ChangeState"))?,
            state: maker.server(&own("get_state"), (package, "GetState"))?,
            states: maker.server(&own("get_available_states"), (package, "GetAvailableStates"))?,
            changes: maker.server(&own("get_available_transitions"), (package, "GetAvailableTransitions"))?,
            graph: maker.server(&own("get_transition_graph"), (package, "GetAvailableTransitions"))?,
            plan: maker.server(&own("plan"), ("std_srvs", "Trigger"))?,
            anywhere: maker.server("reinitialize_global_localization", ("std_srvs", "Empty"))?,
            events: maker.publisher(&own("transition_event"), (package, "TransitionEvent"), &reliable())?,
        })
    }

    pub(super) fn serve(
        self,
        executor: &Rc<LocalExecutor<'static>>,
        engine: &Arc<Engine>,
        node: &Arc<RosClock>,
        stop: &Sender<()>,
    ) {
        let Self { change, state, states, changes, graph, anywhere, plan, events } = self;
        let to = Arc::clone(engine);
        answer(executor, state, move |_| GetStateResponse { current_state: to.state().message() });
        answer(executor, states, |_| GetAvailableStatesResponse {
            available_states: Lifecycle::ALL.map(Lifecycle::message).to_vec(),
        });
        let to = Arc::clone(engine);
        answer(executor, changes, move |_| GetAvailableTransitionsResponse {
            available_transitions: to.state().changes(),
        });
        answer(executor, graph, |_| GetAvailableTransitionsResponse { available_transitions: Lifecycle::graph() });
        let to = Arc::clone(engine);
        answer(executor, anywhere, move |_| {
            to.anywhere();
            Empty::default()
        });
        let to = Arc::clone(engine);
        let run = async move {
            loop {
                let Ok((id, _)) = plan.async_receive_request().await else { continue };
                let asked = Arc::clone(&to);
                let response = match smol::unblock(move || asked.plan()).await {
                    Ok(plan) => TriggerResponse { success: plan.next.is_some(), message: to_json(&plan).to_string() },
                    Err(error) => TriggerResponse { success: false, message: one_line(&error) },
                };
                let _ = plan.async_send_response(id, response).await;
            }
        };
        executor.spawn(run).detach();
        let (to, node, stop) = (Arc::clone(engine), Arc::clone(node), stop.clone());
        let run = async move {
            loop {
                let Ok((id, request)) = change.async_receive_request().await else { continue };
                let doing = Arc::clone(&to);
                // Reading a large map takes long: messages and other requests go on.
                let done = smol::unblock(move || doing.change(&request.transition)).await;
                let success = done.is_ok();
                match done {
                    Ok(description) => {
                        let _ = events.publish(TransitionEvent {
                            timestamp: u64::try_from(node.nanoseconds()).unwrap_or(0),
                            transition: description.transition,
                            start_state: description.start_state,
                            goal_state: description.goal_state,
                        });
                    }
                    Err(error) => eprintln!("{}", one_line(&error)),
                }
                let _ = change.async_send_response(id, ChangeStateResponse { success }).await;
                if to.state() == Lifecycle::Finalized {
                    stop.close();
                }
            }
        };
        executor.spawn(run).detach();
    }
}

/// Answers each request.
fn answer<Req, Resp>(
    executor: &LocalExecutor<'static>,
    server: Server<Req, Resp>,
    reply: impl Fn(Req) -> Resp + 'static,
) where
    Req: Message + Clone + 'static,
    Resp: Message + 'static,
{
    let run = async move {
        loop {
            if let Ok((id, request)) = server.async_receive_request().await {
                let _ = server.async_send_response(id, reply(request)).await;
            }
        }
    };
    executor.spawn(run).detach();
}
