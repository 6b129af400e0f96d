//! Transform, bond and diagnostics, on a thread that waits for nobody.

use super::clock::RosClock;
use super::maker::{Maker, reliable};
use crate::config::{BEAT, BOND_PERIOD, DIAGNOSTICS_PERIOD};
use crate::engine::Engine;
use crate::lifecycle::Lifecycle;
use crate::messages::{BondStatus, DiagnosticArray, TFMessage};
use crate::outputs;
use crate::parameters::Parameters;
use ros2_client::dds::Publisher;
use std::time::{Duration, Instant};
use vibrissa_core::Result;

/// What the heart publishes.
pub(super) struct Heart {
    transform: Publisher<TFMessage>,
    bond: Publisher<BondStatus>,
    diagnostics: Publisher<DiagnosticArray>,
}

impl Heart {
    pub(super) fn new(maker: &mut Maker<'_>) -> Result<Self> {
        Ok(Self {
            transform: maker.publisher("/tf", ("tf2_msgs", "TFMessage"), &reliable())?,
            bond: maker.publisher("/bond", ("bond", "Status"), &reliable())?,
            diagnostics: maker.publisher("/diagnostics", ("diagnostic_msgs", "DiagnosticArray"), &reliable())?,
        })
    }
}

/// Beats until the node ends.
pub(super) fn beat(engine: &Engine, node: &RosClock, parameters: &Parameters, heart: &Heart) {
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
