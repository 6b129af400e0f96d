//! A whisker in contact with a map: the boundaries, what holds the whisker, and two ways to follow a contact from pose
//! to pose.
//!
//! | file | what it knows |
//! | --- | --- |
//! | `boundary`, `corner` | the map's boundaries as chains of one-sided pieces, corners between them, ends of walls |
//! | `simplification` | many short edges as few, for estimation |
//! | `clearance` | how far places are from all of them |
//! | `hold` | what holds a whisker: tip, side or both, on a piece or a corner |
//! | `stance` | the whisker's base on the map, and the map as the whisker sees it |
//! | `quantity` | what is read |
//! | `follow/` | for estimation: readings with derivatives by the pose, without friction |
//! | [`quasi_static`] | for simulation: any whisker, with friction, on the stable branch of equilibria |
//!
//! Both ways solve the same equations of equilibrium by Newton's method, with what differs in their purpose:
//!
//! | | `follow` | [`quasi_static`] |
//! | --- | --- | --- |
//! | whisker | uniform in closed form or by table; others by table, at the tip | any, in closed form or by marching |
//! | friction | none | Coulomb's, stick and slip |
//! | force | over `EI / s²`, with the arc length `s` of the contact; may pull a little | over `EI / L²`; pushes |
//! | two contacts | followed, and looked for | none: the simulator's discrete rod goes on |
//! | where the branch ends | looks for where the whisker comes to rest | says why: the discrete rod goes on |
//! | accuracy | one Newton step beyond 2e-5 of the length (table: 1e-3) | to rounding |
//! | derivatives | by the pose of the base | none |
//!
//! They share boundaries, holds and stance and nothing of their iterations, and the tests of this room compare them.
//! The independent check of both is the simulator's discrete rod, which knows neither holds nor corners.

mod boundary;
mod clearance;
mod corner;
pub(crate) mod follow;
mod hold;
mod quantity;
pub mod quasi_static;
mod simplification;
mod stance;
#[cfg(test)]
mod tests;

pub use boundary::{Boundaries, Piece, Spot, WallKnowledge};
pub use corner::Corner;
pub use follow::{Bending, BentWhisker, FeltMoment, Followed};
pub use hold::{Hold, Push, Support, TwoContacts};
pub use quantity::SensedQuantity;
pub use stance::Stance;
