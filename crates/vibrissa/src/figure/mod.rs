//! Figures that explain an answer to a person, as SVG text: deterministic, self-contained, safe for colour-blind eyes.
//!
//! Data go in as plain geometry in metres; [`Canvas`] maps a piece of the world onto a panel of the page, y up.

mod axes;
mod canvas;
mod document;
mod legend;
pub mod localization;
mod scene;
mod style;

pub use canvas::{Canvas, Frame, WorldBounds};
pub use document::{Document, escape};
pub use legend::{Entry, Sample};
pub use localization::{LocalizationScene, Outline, OutlineRole, localization_figure};
pub use scene::{Geometry, Layer, scene_figure};
