//! The wires: topics, services, and the threads behind them. The only file, beside `messages`, that knows `ros2_client`.
//!
//! | thread | does |
//! | --- | --- |
//! | wires | takes messages and requests |
//! | estimate | rows to estimates, which it publishes |
//! | heart | transform, bond, diagnostics; it never waits for the others |
//! | change | one for each configuring, which may read a large map |

use crate::config::{BEAT, BOND_PERIOD, DEPTH, DIAGNOSTICS_PERIOD, SENSOR_DEPTH};
use crate::engine::{Engine, one_line};
use crate::lifecycle::Lifecycle;
use crate::messages::{
    BondStatus, ChangeStateRequest, ChangeStateResponse, Clock, DiagnosticArray, Empty, Float64MultiArray,
    GetAvailableStatesResponse, GetAvailableTransitionsResponse, GetStateResponse, JointState, Odometry, PoseArray,
    PoseWithCovarianceStamped, TFMessage, Time, Transition, TransitionEvent, WrenchStamped,
};
use crate::outputs;
use crate::parameters::{Parameters, ReadingsType};
use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::dds::{Context, Node, Publisher, ServiceMapping, Subscription};
use ros2_client::qos::{History, WhenFull};
use ros2_client::{Message, MessageTypeName, Name, NodeName, NodeOptions, ParameterValue, QosProfile, ServiceTypeName};
use smol::LocalExecutor;
use smol::channel::{Receiver, Sender};
use std::net::{IpAddr, Ipv4Addr};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use vibrissa_core::flow::sensor_log::{Channel, Quantity};
use vibrissa_core::{Error, Result};

/// A node that runs.
pub struct RunningNode {
    engine: Arc<Engine>,
    stop: Sender<()>,
    threads: Vec<JoinHandle<()>>,
}

impl RunningNode {
    /// What the node is without its wires.
    #[must_use]
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Waits until the node is shut down.
    pub fn wait(self) {
        for thread in self.threads {
            // A thread that panicked has said so.
            let _ = thread.join();
        }
    }

    /// Ends the node.
    pub fn stop(self) {
        let _ = self.engine.change(&Transition { id: 0, label: "shutdown".to_owned() });
        self.stop.close();
        self.wait();
    }
}

fn dds(what: &str, error: impl core::fmt::Debug) -> Error {
    Error::data(format!("cannot {what}"))
        .value(format!("{error:?}"))
        .remedy("check the network interfaces, ROS_DOMAIN_ID and the names of node and topics")
}

fn sensor_data() -> QosProfile {
    QosProfile::subscription_default().history(History::KeepLast { depth: SENSOR_DEPTH })
}

/// Reliable; a reader that does not keep up never makes the node wait.
fn reliable() -> QosProfile {
    QosProfile::publisher_default().reliability_reliable(WhenFull::Fail).history(History::KeepLast { depth: DEPTH })
}

/// The topics and services of a node while it is being made.
struct Maker<'a> {
    node: Node,
    parameters: &'a Parameters,
    mapping: ServiceMapping,
}

impl Maker<'_> {
    fn name(&self, topic: &str) -> Result<Name> {
        let name = self.parameters.topic(topic);
        let namespace = self.parameters.namespace.trim_end_matches('/');
        let full = if name.starts_with('/') { name.to_owned() } else { format!("{namespace}/{name}") };
        Name::parse(&full).map_err(|error| Error::usage("no name of a topic").value(format!("{full}: {error:?}")))
    }

    fn topic(&mut self, name: &str, kind: (&str, &str), qos: &QosProfile) -> Result<ros2_client::dds::rustdds::Topic> {
        let full = self.name(name)?;
        self.node
            .create_topic(&full, MessageTypeName::new(kind.0, kind.1), qos)
            .map_err(|e| dds(&format!("make the topic {name}"), e))
    }

    fn publisher<M: Message>(&mut self, name: &str, kind: (&str, &str)) -> Result<Publisher<M>> {
        let topic = self.topic(name, kind, &reliable())?;
        self.node.create_publisher(&topic, None).map_err(|e| dds(&format!("publish {name}"), e))
    }

    fn subscription<M: Message + 'static>(
        &mut self,
        name: &str,
        kind: (&str, &str),
        qos: &QosProfile,
    ) -> Result<Subscription<M>> {
        let topic = self.topic(name, kind, qos)?;
        self.node.create_subscription(&topic, None).map_err(|e| dds(&format!("subscribe to {name}"), e))
    }

    fn server<Req, Resp>(&mut self, name: &str, kind: (&str, &str)) -> Result<ros2_client::dds::Server<Req, Resp>>
    where
        Req: Message + Clone + 'static,
        Resp: Message + 'static,
    {
        let full = self.name(name)?;
        let kind = ServiceTypeName::new(kind.0, kind.1);
        self.node
            .create_server(self.mapping, &full, &kind, reliable(), reliable())
            .map_err(|e| dds(&format!("offer the service {name}"), e))
    }
}

/// What the estimate's thread and the heart publish.
struct Voices {
    pose: Publisher<PoseWithCovarianceStamped>,
    places: Publisher<PoseArray>,
}

struct Heart {
    transform: Publisher<TFMessage>,
    bond: Publisher<BondStatus>,
    diagnostics: Publisher<DiagnosticArray>,
}

/// Starts a node.
///
/// # Errors
///
/// Names that ROS does not allow, a network that cannot be used; with `autostart` files that cannot be read.
pub fn start(parameters: &Parameters) -> Result<RunningNode> {
    let engine = Arc::new(Engine::new(parameters.clone()));
    let mut builder = DomainParticipantBuilder::new(parameters.domain);
    if parameters.localhost {
        builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
    }
    let participant = builder.build().map_err(|e| dds("join the domain", e))?;
    let context = Context::from_domain_participant(participant).map_err(|e| dds("join the domain", e))?;
    let name = NodeName::new(&parameters.namespace, &parameters.name).map_err(|e| {
        Error::usage("no name of a node").value(format!("{} {}: {e:?}", parameters.namespace, parameters.name))
    })?;
    let node = context.new_node(name, options(parameters)).map_err(|e| dds("make the node", e))?;
    // Fast DDS and Cyclone pack requests differently.
    let cyclone = std::env::var("RMW_IMPLEMENTATION").is_ok_and(|name| name.contains("cyclone"));
    let mapping = if cyclone { ServiceMapping::Cyclone } else { ServiceMapping::Enhanced };
    let mut maker = Maker { node, parameters, mapping };
    let voices = Voices {
        pose: maker.publisher("amcl_pose", ("geometry_msgs", "PoseWithCovarianceStamped"))?,
        places: maker.publisher("particle_cloud", ("geometry_msgs", "PoseArray"))?,
    };
    let heart = Heart {
        transform: maker.publisher("/tf", ("tf2_msgs", "TFMessage"))?,
        bond: maker.publisher("/bond", ("bond", "Status"))?,
        diagnostics: maker.publisher("/diagnostics", ("diagnostic_msgs", "DiagnosticArray"))?,
    };
    let inputs = Inputs::new(&mut maker)?;
    let services = Services::new(&mut maker)?;
    let mut node = maker.node;
    let spinner = node.spinner().map_err(|e| dds("follow the network", e))?;
    let node = Arc::new(RosClock { node, simulated: AtomicI64::new(0) });
    let (stop, stopped) = smol::channel::bounded::<()>(1);
    let threads = vec![
        spawn("estimate", {
            let (engine, parameters) = (Arc::clone(&engine), parameters.clone());
            move || tell(&engine, &parameters, &voices)
        })?,
        spawn("heart", {
            let (engine, node, parameters) = (Arc::clone(&engine), Arc::clone(&node), parameters.clone());
            move || beat(&engine, &node, &parameters, &heart)
        })?,
        spawn("wires", {
            let (engine, node, stop) = (Arc::clone(&engine), Arc::clone(&node), stop.clone());
            move || {
                let executor = Rc::new(LocalExecutor::new());
                executor.spawn(async move { spinner.spin().await }).detach();
                inputs.listen(&executor, &engine, &node);
                services.serve(&executor, &engine, &node, &stop);
                smol::block_on(executor.run(ended(stopped)));
            }
        })?,
    ];
    let running = RunningNode { engine, stop, threads };
    if parameters.autostart {
        for label in ["configure", "activate"] {
            if let Err(error) = running.engine.change(&Transition { id: 0, label: label.to_owned() }) {
                running.stop();
                return Err(error);
            }
        }
    }
    Ok(running)
}

fn spawn(name: &str, run: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>> {
    std::thread::Builder::new().name(name.to_owned()).spawn(run).map_err(|e| dds("start a thread", e))
}

async fn ended(stopped: Receiver<()>) {
    while stopped.recv().await.is_ok() {}
}

/// The parameters as others read them; they are set at the start.
fn options(parameters: &Parameters) -> NodeOptions {
    let text = |text: &str| ParameterValue::String(text.to_owned());
    let path = |path: &std::path::Path| ParameterValue::String(path.display().to_string());
    let [x, y, yaw] = parameters.initial_pose;
    let declared = [
        ("map", path(&parameters.map)),
        ("robot", path(parameters.robot.as_deref().unwrap_or(std::path::Path::new("")))),
        ("method", text(parameters.method.name())),
        ("delay", ParameterValue::Double(parameters.delay)),
        ("rate", ParameterValue::Double(parameters.rate)),
        ("global_frame_id", text(&parameters.global_frame_id)),
        ("odom_frame_id", text(&parameters.odom_frame_id)),
        ("tf_broadcast", ParameterValue::Boolean(parameters.tf_broadcast)),
        ("transform_tolerance", ParameterValue::Double(parameters.transform_tolerance)),
        ("set_initial_pose", ParameterValue::Boolean(parameters.set_initial_pose)),
        ("initial_pose.x", ParameterValue::Double(x)),
        ("initial_pose.y", ParameterValue::Double(y)),
        ("initial_pose.yaw", ParameterValue::Double(yaw)),
        ("use_sim_time", ParameterValue::Boolean(parameters.use_sim_time)),
    ];
    let options = declared.iter().fold(NodeOptions::new().enable_rosout(false), |options, (name, value)| {
        options.declare_parameter(name, value.clone())
    });
    options.parameter_validator(Box::new(move |name, value| {
        let unchanged = declared.iter().any(|(known, old)| *known == name && old == value);
        match unchanged || name == "use_sim_time" {
            true => Ok(()),
            false => Err("set at the start of the node: --ros-args -p NAME:=VALUE".to_owned()),
        }
    }))
}

/// Estimates until the node ends.
fn tell(engine: &Engine, parameters: &Parameters, voices: &Voices) {
    engine.run(&mut |report| {
        // A message that cannot be sent now is out of date soon.
        if let Some(pose) = outputs::pose(report, &parameters.global_frame_id) {
            let _ = voices.pose.publish(pose);
        }
        let _ = voices.places.publish(outputs::places(report, &parameters.global_frame_id));
    });
}

/// The time of ROS: the system's, or that of the topic `/clock` (which `ros2_client` would read under another type than ROS sends).
struct RosClock {
    node: Node,
    simulated: AtomicI64,
}

impl RosClock {
    /// Now (ns).
    fn nanoseconds(&self) -> i64 {
        match self.node.get_parameter("use_sim_time") {
            Some(ParameterValue::Boolean(true)) => self.simulated.load(Ordering::Relaxed),
            _ => self.node.time_now_not_simulated().to_nanos(),
        }
    }

    /// Now (s).
    fn now(&self) -> f64 {
        self.nanoseconds() as f64 * 1e-9
    }
}

/// Beats until the node ends.
fn beat(engine: &Engine, node: &RosClock, parameters: &Parameters, heart: &Heart) {
    let instance = format!("{}-{}", parameters.name, std::process::id());
    let (mut beats, mut sent, mut bonded, mut faulted) = (0_u64, f64::NEG_INFINITY, false, None);
    let every = |period: f64| (period / BEAT).round().max(1.0) as u64;
    let began = Instant::now();
    loop {
        let pulse = engine.pulse();
        if let Some((t, _)) = pulse.map_from_odom.filter(|(t, _)| parameters.tf_broadcast && *t != sent) {
            sent = t;
            let ahead = parameters.transform_tolerance;
            if let Some(message) =
                outputs::transform(&pulse, &parameters.global_frame_id, &parameters.odom_frame_id, ahead)
            {
                let _ = heart.transform.publish(message);
            }
        }
        let lives = pulse.state == Lifecycle::Active;
        if (lives && beats.is_multiple_of(every(BOND_PERIOD))) || (bonded && !lives) {
            let _ = heart.bond.publish(outputs::bond(node.now(), &parameters.name, &instance, lives));
            bonded = lives;
        }
        if beats.is_multiple_of(every(DIAGNOSTICS_PERIOD)) {
            let _ = heart.diagnostics.publish(outputs::diagnostics(&pulse, node.now(), &parameters.name));
        }
        if pulse.fault != faulted {
            if let Some(fault) = &pulse.fault {
                eprintln!("{}: {fault}", parameters.name);
            }
            faulted = pulse.fault;
        }
        if pulse.state == Lifecycle::Finalized {
            return;
        }
        beats += 1;
        let due = Duration::from_secs_f64(BEAT * beats as f64);
        std::thread::sleep(due.saturating_sub(began.elapsed()));
    }
}

/// What the node listens to.
struct Inputs {
    odometry: Subscription<Odometry>,
    initial_pose: Subscription<PoseWithCovarianceStamped>,
    readings: Readings,
    clock: Subscription<Clock>,
    frame: String,
}

enum Readings {
    Array(Subscription<Float64MultiArray>),
    Joints(Subscription<JointState>),
    Wrench(Subscription<WrenchStamped>),
}

impl Inputs {
    fn new(maker: &mut Maker<'_>) -> Result<Self> {
        let sensor = sensor_data();
        Ok(Self {
            odometry: maker.subscription("odom", ("nav_msgs", "Odometry"), &sensor)?,
            initial_pose: maker.subscription(
                "initialpose",
                ("geometry_msgs", "PoseWithCovarianceStamped"),
                &reliable(),
            )?,
            readings: match maker.parameters.readings_type {
                ReadingsType::Array => {
                    Readings::Array(maker.subscription("readings", ("std_msgs", "Float64MultiArray"), &sensor)?)
                }
                ReadingsType::Joints => {
                    Readings::Joints(maker.subscription("readings", ("sensor_msgs", "JointState"), &sensor)?)
                }
                ReadingsType::Wrench => {
                    Readings::Wrench(maker.subscription("readings", ("geometry_msgs", "WrenchStamped"), &sensor)?)
                }
            },
            clock: maker.subscription("/clock", ("rosgraph_msgs", "Clock"), &sensor)?,
            frame: maker.parameters.global_frame_id.clone(),
        })
    }

    fn listen(self, executor: &Rc<LocalExecutor<'static>>, engine: &Arc<Engine>, node: &Arc<RosClock>) {
        let Self { odometry, initial_pose, readings, clock, frame } = self;
        let to = Arc::clone(node);
        each(executor, clock, move |message| {
            let Time { sec, nanosec } = message.clock;
            to.simulated.store(i64::from(sec) * 1_000_000_000 + i64::from(nanosec), Ordering::Relaxed);
        });
        let stamped = {
            let node = Arc::clone(node);
            move |stamp: &Time| stamp.seconds().unwrap_or_else(|| node.now())
        };
        let (to, stamp) = (Arc::clone(engine), stamped.clone());
        each(executor, odometry, move |message| {
            to.odometry(stamp(&message.header.stamp), message.pose.pose.plane());
        });
        let to = Arc::clone(engine);
        each(executor, initial_pose, move |message| {
            let c = message.pose.covariance;
            let said = message.header.frame_id.trim_start_matches('/');
            match message.pose.pose.plane() {
                Some(pose) if said.is_empty() || said == frame => {
                    to.initial_pose(pose, [c[0][0], c[1][1], c[5][5]]);
                }
                Some(_) => eprintln!("initialpose is in the frame \"{said}\" and was left out; it must be \"{frame}\""),
                None => eprintln!("initialpose holds no pose in the plane and was left out"),
            }
        });
        let (to, stamp) = (Arc::clone(engine), stamped);
        match readings {
            Readings::Array(subscription) => {
                each(executor, subscription, move |message| to.readings(stamp(&Time::default()), Some(message.data)));
            }
            Readings::Joints(subscription) => each(executor, subscription, move |message| {
                let values = by_name(&message, &to.channels());
                to.readings(stamp(&message.header.stamp), values);
            }),
            Readings::Wrench(subscription) => each(executor, subscription, move |message| {
                to.readings(stamp(&message.header.stamp), Some(vec![message.wrench.torque.z]));
            }),
        }
    }
}

/// Hands each message of a subscription on; what cannot be decoded is left out.
fn each<M: Message + 'static>(
    executor: &LocalExecutor<'static>,
    subscription: Subscription<M>,
    take: impl Fn(M) + 'static,
) {
    let run = async move {
        loop {
            if let Ok((message, _)) = subscription.async_take().await {
                take(message);
            }
        }
    };
    executor.spawn(run).detach();
}

/// The readings in a `JointState`: positions under the names of channels, or moments as efforts under the names of whiskers.
#[must_use]
pub fn by_name(message: &JointState, channels: &[Channel]) -> Option<Vec<f64>> {
    let find = |name: &str| message.name.iter().position(|one| one == name);
    let one = |channel: &Channel| {
        let position = find(&channel.column()).and_then(|index| message.position.get(index).copied());
        let effort = || match channel.quantity {
            Quantity::Moment => find(&channel.whisker).and_then(|index| message.effort.get(index).copied()),
            _ => None,
        };
        position.or_else(effort)
    };
    channels.iter().map(one).collect()
}

/// The services of a managed node and AMCL's.
struct Services {
    change: ros2_client::dds::Server<ChangeStateRequest, ChangeStateResponse>,
    state: ros2_client::dds::Server<Empty, GetStateResponse>,
    states: ros2_client::dds::Server<Empty, GetAvailableStatesResponse>,
    changes: ros2_client::dds::Server<Empty, GetAvailableTransitionsResponse>,
    graph: ros2_client::dds::Server<Empty, GetAvailableTransitionsResponse>,
    anywhere: ros2_client::dds::Server<Empty, Empty>,
    events: Publisher<TransitionEvent>,
}

impl Services {
    fn new(maker: &mut Maker<'_>) -> Result<Self> {
        let node = maker.parameters.name.clone();
        let own = |name: &str| format!("{node}/{name}");
        let package = "lifecycle_msgs";
        Ok(Self {
            change: maker.server(&own("change_state"), (package, "ChangeState"))?,
            state: maker.server(&own("get_state"), (package, "GetState"))?,
            states: maker.server(&own("get_available_states"), (package, "GetAvailableStates"))?,
            changes: maker.server(&own("get_available_transitions"), (package, "GetAvailableTransitions"))?,
            graph: maker.server(&own("get_transition_graph"), (package, "GetAvailableTransitions"))?,
            anywhere: maker.server("reinitialize_global_localization", ("std_srvs", "Empty"))?,
            events: maker.publisher(&own("transition_event"), (package, "TransitionEvent"))?,
        })
    }

    fn serve(
        self,
        executor: &Rc<LocalExecutor<'static>>,
        engine: &Arc<Engine>,
        node: &Arc<RosClock>,
        stop: &Sender<()>,
    ) {
        let Self { change, state, states, changes, graph, anywhere, events } = self;
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
    server: ros2_client::dds::Server<Req, Resp>,
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
