//! What is told of each estimate, and the map.

use super::maker::{Maker, latched, reliable};
use crate::engine::{Engine, Said};
use crate::grid;
use crate::messages::{OccupancyGrid, PoseArray, PoseWithCovarianceStamped};
use crate::outputs;
use crate::parameters::Parameters;
use ros2_client::dds::Publisher;
use vibrissa_core::Result;

/// What the estimate's thread publishes.
pub(super) struct Voices {
    pose: Publisher<PoseWithCovarianceStamped>,
    places: Publisher<PoseArray>,
    /// The map for viewers, where it is wanted.
    map: Option<Publisher<OccupancyGrid>>,
}

impl Voices {
    pub(super) fn new(maker: &mut Maker<'_>) -> Result<Self> {
        let map = ("nav_msgs", "OccupancyGrid");
        Ok(Self {
            pose: maker.publisher("amcl_pose", ("geometry_msgs", "PoseWithCovarianceStamped"), &reliable())?,
            places: maker.publisher("particle_cloud", ("geometry_msgs", "PoseArray"), &reliable())?,
            map: if maker.parameters.publish_map { Some(maker.publisher("map", map, &latched())?) } else { None },
        })
    }
}

/// Estimates until the node ends.
pub(super) fn tell(engine: &Engine, parameters: &Parameters, voices: &Voices) {
    let mut map_told = false;
    engine.run(&mut |told| {
        let report = match told {
            Said::Began(map) => {
                // The map of a file does not change.
                if let (Some(publisher), false) = (&voices.map, map_told) {
                    let _ = publisher.publish(grid::message(map, &parameters.global_frame_id));
                    map_told = true;
                }
                return;
            }
            Said::Estimate(report) => report,
        };
        // A message that cannot be sent now is out of date soon.
        if let Some(pose) = outputs::pose(report, &parameters.global_frame_id) {
            let _ = voices.pose.publish(pose);
        }
        let _ = voices.places.publish(outputs::places(report, &parameters.global_frame_id));
    });
}
