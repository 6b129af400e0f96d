//! What the node listens to.

use super::clock::RosClock;
use super::maker::{Maker, latched, reliable, sensor_data};
use crate::engine::Engine;
use crate::messages::{
    Clock, Float64MultiArray, JointState, OccupancyGrid, Odometry, PoseWithCovarianceStamped, Time, WrenchStamped,
};
use crate::parameters::ReadingsType;
use ros2_client::Message;
use ros2_client::dds::Subscription;
use smol::LocalExecutor;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use vibrissa_core::Result;
use vibrissa_core::flow::sensor_log::{Channel, Quantity};

/// What the node listens to.
pub(super) struct Inputs {
    odometry: Subscription<Odometry>,
    initial_pose: Subscription<PoseWithCovarianceStamped>,
    readings: Readings,
    clock: Subscription<Clock>,
    /// The map, where it comes as a message.
    map: Option<Subscription<OccupancyGrid>>,
    frame: String,
}

enum Readings {
    Array(Subscription<Float64MultiArray>),
    Joints(Subscription<JointState>),
    Wrench(Subscription<WrenchStamped>),
}

impl Inputs {
    pub(super) fn new(maker: &mut Maker<'_>) -> Result<Self> {
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
            map: match maker.parameters.map_topic.clone() {
                Some(topic) => Some(maker.subscription(&topic, ("nav_msgs", "OccupancyGrid"), &latched())?),
                None => None,
            },
            frame: maker.parameters.global_frame_id.clone(),
        })
    }

    pub(super) fn listen(self, executor: &Rc<LocalExecutor<'static>>, engine: &Arc<Engine>, node: &Arc<RosClock>) {
        let Self { odometry, initial_pose, readings, clock, map, frame } = self;
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
        if let Some(map) = map {
            let to = Arc::clone(engine);
            each(executor, map, move |grid| {
                let to = Arc::clone(&to);
                // Tracing a large grid takes long: messages and requests go on.
                smol::unblock(move || to.map_message(&grid)).detach();
            });
        }
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
pub(super) fn each<M: Message + 'static>(
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
