//! Where a whisker was touched: contact points of a log, step by step.
//!
//! A moment leaves a curve of contact points open; the curves of several readings, moved into one frame by the known
//! motion of the base, meet at the contact if it stood still \[routray, section "Contact Uncertainty Reduction via
//! Filtering"\]. Where they do not meet, the tip is sliding, or the contact slipped.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `reading` | one reading with its base and its error |
//! | `meeting` | every point that explains two readings, the base told apart |
//! | `fixed_point` | the one point that explains many readings of any whiskers, with its covariance |
//! | `region` | every point that explains readings with bounded errors |
//! | `baseline` | the closed forms of earlier work |
//! | `refined` | a contact that stood still once more: from when it began, on a base that moved steadily |
//! | `sharpened` | the same from errors that fill a bound |
//! | `stretch` | the log's stretches of contact, thinned |
//! | `segment` | the parts of a stretch during which the contact stood still |
//! | `trace/` | where tip or side went while they slid along a wall, by one least-squares problem |
//! | `space/` | the same in space, from the moments about both transverse axes |
//! | `free` | what a free whisker reads |
//! | `report` | the whole log: a contact for each step, and what happened |

mod baseline;
mod fixed_point;
mod free;
mod meeting;
mod reading;
mod refined;
mod region;
mod report;
mod segment;
mod sharpened;
mod space;
mod stretch;
mod trace;

pub use baseline::Baseline;
pub use fixed_point::{FixedPoint, Touch, fixed_point, fixed_point_since, fixed_points};
pub use meeting::{Meeting, MeetingKind, meetings};
pub use reading::ContactReading;
pub use region::{ContactRegion, contact_region};
pub use report::{ContactKind, ContactReport, ContactStep, contacts, contacts_until};
pub use space::{Band, SpacePoint, SpaceReport, SpaceStep, contact_in_space};
pub use trace::{Trace, TraceNode, TraceOptions, TracePoint, contact_traces};
