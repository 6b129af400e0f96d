//! How topics and services are made: names, types, qualities of service.

use crate::config::{DEPTH, SENSOR_DEPTH};
use crate::parameters::Parameters;
use ros2_client::dds::{Node, Publisher, Server, ServiceMapping, Subscription};
use ros2_client::qos::{Durability, History, WhenFull};
use ros2_client::{Message, MessageTypeName, Name, QosProfile, ServiceTypeName};
use vibrissa_core::{Error, Result};

/// A fault of the network, with what to do.
pub(super) fn dds(what: &str, error: impl core::fmt::Debug) -> Error {
    Error::data(format!("cannot {what}"))
        .value(format!("{error:?}"))
        .remedy("check the network interfaces, ROS_DOMAIN_ID and the names of node and topics")
}

/// As sensors publish: best effort.
pub(super) fn sensor_data() -> QosProfile {
    QosProfile::subscription_default().history(History::KeepLast { depth: SENSOR_DEPTH })
}

/// Reliable; a reader that does not keep up never makes the node wait.
pub(super) fn reliable() -> QosProfile {
    QosProfile::publisher_default().reliability_reliable(WhenFull::Fail).history(History::KeepLast { depth: DEPTH })
}

/// Reliable, and the last message is said again to those who come later: as maps are told.
pub(super) fn latched() -> QosProfile {
    reliable().durability(Durability::TransientLocal).history(History::KeepLast { depth: 1 })
}

/// The topics and services of a node while it is being made.
pub(super) struct Maker<'a> {
    pub(super) node: Node,
    pub(super) parameters: &'a Parameters,
    pub(super) mapping: ServiceMapping,
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

    pub(super) fn publisher<M: Message>(
        &mut self,
        name: &str,
        kind: (&str, &str),
        qos: &QosProfile,
    ) -> Result<Publisher<M>> {
        let topic = self.topic(name, kind, qos)?;
        self.node.create_publisher(&topic, None).map_err(|e| dds(&format!("publish {name}"), e))
    }

    pub(super) fn subscription<M: Message + 'static>(
        &mut self,
        name: &str,
        kind: (&str, &str),
        qos: &QosProfile,
    ) -> Result<Subscription<M>> {
        let topic = self.topic(name, kind, qos)?;
        self.node.create_subscription(&topic, None).map_err(|e| dds(&format!("subscribe to {name}"), e))
    }

    pub(super) fn server<Req, Resp>(&mut self, name: &str, kind: (&str, &str)) -> Result<Server<Req, Resp>>
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
