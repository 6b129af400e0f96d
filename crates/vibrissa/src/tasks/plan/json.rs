//! A plan as JSON.

use super::Plan;
use serde_json::{Value, json};

/// A plan as the JSON of `plan.json` (SI units, radians; waypoints are seen from where the robot is).
#[must_use]
pub fn to_json(plan: &Plan) -> Value {
    let next = plan.next.as_ref().map(|next| {
        let waypoints = next.motion.waypoints().iter().map(|p| json!({"x": p.x, "y": p.y, "theta": p.theta}));
        json!({
            "name": next.motion.name(),
            "waypoints": waypoints.collect::<Vec<_>>(),
            "way": next.motion.way(),
            "turn": next.motion.turn(),
            "stop_at": next.stop_at,
            "places": next.places,
            "extent": next.extent,
            "information": next.information,
        })
    });
    json!({
        "verdict": plan.verdict.as_str(),
        "words": plan.words(),
        "next": next,
        "places": plan.places,
        "extent": plan.extent,
        "looked_at": plan.looked_at,
        "readings": plan.readings,
    })
}
