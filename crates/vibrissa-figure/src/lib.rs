//! Figures that explain an answer to a person, as SVG text: deterministic, self-contained, safe for colour-blind eyes.
//!
//! Data go in as plain geometry in metres; [`Canvas`] maps a piece of the world onto a panel of the page, y up.

mod axes;
pub mod calibration;
mod canvas;
mod chart;
mod contacts;
mod document;
mod film;
mod legend;
pub mod localization;
pub mod numbers;
mod outlines;
mod places;
pub mod plate;
mod scene;
pub mod simulation;
mod states;
mod style;

pub use calibration::{Plot, calibration_figure, plots_figure};
pub use canvas::{Canvas, Frame, WorldBounds};
pub use contacts::{ContactFigure, contact_figure, contact_legend, contact_panel};
pub use document::{Document, escape};
pub use film::{FilmFrame, localization_film};
pub use legend::{Entry, Sample, legend};
pub use localization::{LocalizationScene, Outline, OutlineRole, localization_figure, wrapped};
pub use plate::{ChartSeries, MapPlate, chart_plate, contact_plate, map_plate, preimage_plate};
pub use scene::{Geometry, Layer, map_figure, scene_figure};
pub use simulation::{HUES, Series, SimulationScene, simulation_figure};
pub use states::{PreimageFigure, preimage_figure, preimage_legend, preimage_panel};

/// The stylesheet that stands in every figure, for pages that hold many of them inline and need it once.
#[must_use]
pub fn stylesheet() -> &'static str {
    style::SHEET
}

use vibrissa_core::{flow, plane, sets};
