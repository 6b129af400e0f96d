//! Whisker mechanics, the plane, intervals and sensing.

#![allow(clippy::duplicate_mod, reason = "each file is a test of its own, with the helpers that it takes")]

mod beam_bending_plane;
mod beam_field;
mod beam_field_inverse;
mod beam_field_side;
mod beam_field_stable;
mod beam_jacobi;
mod beam_modes;
mod beam_normal;
mod beam_oracle;
mod beam_press;
mod beam_press_leaning;
mod beam_press_rods;
mod beam_rod;
mod beam_rod_beyond;
mod beam_rod_search;
mod beam_tip;
mod beam_tip_chart;
mod beam_tip_model;
mod beam_vectors;
mod plane_curve;
mod plane_pose2;
mod plane_segment_tree;
mod plane_winding;
mod sensing;
mod sets_laws;
