//! Planar geometry: vectors, rigid motions, curves, and fast look-up among many of them.

mod arc;
mod bounds;
mod convex;
mod curve;
mod intersect;
mod pose2;
mod segment;
mod segment_tree;
mod vec2;
mod winding;

pub use arc::arc_to_cubics;
pub use bounds::Bounds;
pub use convex::{ConvexPolygon, union_area};
pub use curve::{Curve, CurvePoint};
pub use intersect::segment_contact;
pub use pose2::{Pose2, Twist2, wrap_angle};
pub use segment::Segment;
pub use segment_tree::{Intersection, NearestEdge, SegmentTree};
pub use vec2::Vec2;
pub use winding::WindingTree;
