//! The factor graph as JSON.

use super::told::{ContactFactor, FactorGraph, LegFactor};
use crate::plane::{Pose2, Vec2};
use serde_json::{Value, json};

/// The factor graph as the JSON of `graph.json` (SI units, radians).
#[must_use]
pub fn graph_to_json(graph: &FactorGraph) -> Value {
    let pose = |p: &Pose2| json!([p.x, p.y, p.theta]);
    let point = |p: Vec2| json!([p.x, p.y]);
    let leg = |leg: &LegFactor| {
        json!({
            "step": pose(&leg.step),
            "by_share": leg.by_share.map(|(place, turn)| [place.x, place.y, turn]),
            "place_std": leg.place_std,
            "turn_std": leg.turn_std,
        })
    };
    let contact = |contact: &ContactFactor| {
        let ((later, p), (earlier, q)) = (contact.later, contact.earlier);
        json!({
            "later": later, "later_point": point(p), "earlier": earlier, "earlier_point": point(q),
            "earlier_normal": point(contact.normal), "std": contact.std,
        })
    };
    json!({
        "poses": graph.poses.iter().map(pose).collect::<Vec<_>>(),
        "covariances": graph.covariances,
        "shares": graph.shares.map(|share| share.value),
        "shares_std": graph.shares.map(|share| share.std),
        "shares_prior_std": graph.share_stds,
        "legs": graph.legs.iter().map(leg).collect::<Vec<_>>(),
        "contacts": graph.contacts.iter().map(contact).collect::<Vec<_>>(),
        "cost": graph.cost,
    })
}
