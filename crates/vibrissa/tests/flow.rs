//! From moments to state sets, and the paper.

#![allow(clippy::duplicate_mod, reason = "each file is a test of its own, with the helpers that it takes")]

mod flow_adjoint;
mod flow_contact_intersection;
mod flow_contact_set;
mod flow_reading_preimage;
mod flow_tip_preimage;
mod flow_trajectory;
mod flow_virtual_sensor;
mod paper_errata;
mod paper_tables;
mod possibilistic;
mod state_set_forward;
mod state_set_side;
