//! The wires: topics, services, and the threads behind them. The only folder, beside `messages`, that knows `ros2_client`.
//!
//! | thread | does | file |
//! | --- | --- | --- |
//! | wires | takes messages and requests | `inputs`, `services` |
//! | estimate | rows to estimates, which it publishes | `voices` |
//! | heart | transform, bond, diagnostics; it never waits for the others | `heart` |
//! | change | one for each configuring, which may read a large map | `services` |
//!
//! `topic_lines` is no part of the node: it tells a topic as lines. `maker` makes topics and services, `declared` tells parameters to other nodes, `clock` what time it is.

mod clock;
mod declared;
mod heart;
mod inputs;
mod maker;
mod services;
mod topic_lines;
mod voices;

pub use inputs::by_name;
pub use topic_lines::tell_lines;

use crate::engine::Engine;
use crate::messages::Transition;
use crate::parameters::Parameters;
use clock::RosClock;
use declared::options;
use heart::{Heart, beat};
use inputs::Inputs;
use maker::{Maker, dds};
use ros2_client::NodeName;
use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::dds::{Context, ServiceMapping};
use services::Services;
use smol::LocalExecutor;
use smol::channel::{Receiver, Sender};
use std::net::{IpAddr, Ipv4Addr};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::AtomicI64;
use std::thread::JoinHandle;
use vibrissa_core::{Error, Result};
use voices::{Voices, tell};

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

/// Starts a node.
///
/// # Errors
///
/// Names that ROS does not allow, a network that cannot be used; with `autostart` files that cannot be read.
pub fn start(parameters: &Parameters) -> Result<RunningNode> {
    let engine = Arc::new(Engine::new(parameters.clone()));
    let context = join_domain(parameters)?;
    let name = NodeName::new(&parameters.namespace, &parameters.name).map_err(|e| {
        Error::usage("no name of a node").value(format!("{} {}: {e:?}", parameters.namespace, parameters.name))
    })?;
    let node = context.new_node(name, options(parameters)).map_err(|e| dds("make the node", e))?;
    // Fast DDS and Cyclone pack requests differently.
    let cyclone = std::env::var("RMW_IMPLEMENTATION").is_ok_and(|name| name.contains("cyclone"));
    let mapping = if cyclone { ServiceMapping::Cyclone } else { ServiceMapping::Enhanced };
    let mut maker = Maker { node, parameters, mapping };
    let voices = Voices::new(&mut maker)?;
    let heart = Heart::new(&mut maker)?;
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

/// Joins the domain, where it is said so on this machine only.
fn join_domain(parameters: &Parameters) -> Result<Context> {
    let mut builder = DomainParticipantBuilder::new(parameters.domain);
    if parameters.localhost {
        builder = builder.with_only_networks([IpAddr::V4(Ipv4Addr::LOCALHOST)]);
    }
    let participant = builder.build().map_err(|e| dds("join the domain", e))?;
    Context::from_domain_participant(participant).map_err(|e| dds("join the domain", e))
}

fn spawn(name: &str, run: impl FnOnce() + Send + 'static) -> Result<JoinHandle<()>> {
    std::thread::Builder::new().name(name.to_owned()).spawn(run).map_err(|e| dds("start a thread", e))
}

async fn ended(stopped: Receiver<()>) {
    while stopped.recv().await.is_ok() {}
}
