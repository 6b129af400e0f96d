//! Figures as PNG and PDF beside the SVG, with a font of our own: text looks the same on every machine.

use clap::ValueEnum;
use vibrissa::{Error, Result};

/// A format that figures are written in beside SVG.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Picture {
    /// Pixels, 288 to the inch
    Png,
    /// Vectors, for papers
    Pdf,
}

impl Picture {
    /// The end of a file's name.
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Pdf => "pdf",
        }
    }

    /// The figure in this format.
    ///
    /// # Errors
    ///
    /// A figure that is no SVG or too large to draw, or a build without the feature `pictures`.
    #[cfg(feature = "pictures")]
    pub(crate) fn of(self, svg: &str) -> Result<Vec<u8>> {
        let tree = drawing::parsed(svg)?;
        match self {
            Self::Png => drawing::png(&tree),
            Self::Pdf => drawing::pdf(&tree),
        }
    }

    /// As with the feature `pictures`, which this build lacks.
    #[cfg(not(feature = "pictures"))]
    pub(crate) fn of(self, _svg: &str) -> Result<Vec<u8>> {
        Err(Error::usage(format!("--pictures {}: this build writes SVG only", self.extension()))
            .remedy("install the command with its default features, among them `pictures`"))
    }
}

/// Fails early where this build writes no pictures.
pub(crate) fn check(pictures: &[Picture]) -> Result<()> {
    match pictures.first() {
        Some(first) if cfg!(not(feature = "pictures")) => first.of("").map(|_| ()),
        _ => Ok(()),
    }
}

#[cfg(feature = "pictures")]
mod drawing {
    use super::{Error, Result};
    use resvg::tiny_skia::{Pixmap, Transform};
    use resvg::usvg::{Options, Tree, fontdb::Database};
    use std::sync::Arc;

    /// Pixels for each page unit, of which 96 make an inch.
    const SCALE: f32 = 3.0;
    /// Fonts of every picture; `fonts/LICENSE` says where they come from.
    const FONTS: [&[u8]; 2] =
        [include_bytes!("../../fonts/DejaVuSans.ttf"), include_bytes!("../../fonts/DejaVuSans-Bold.ttf")];
    const FAMILY: &str = "DejaVu Sans";

    /// The figure with its text laid out.
    pub(super) fn parsed(svg: &str) -> Result<Tree> {
        let mut fonts = Database::new();
        FONTS.iter().for_each(|font| fonts.load_font_data(font.to_vec()));
        fonts.set_sans_serif_family(FAMILY);
        let options = Options { font_family: FAMILY.into(), fontdb: Arc::new(fonts), ..Options::default() };
        Tree::from_str(svg, &options).map_err(|error| Error::data(format!("cannot draw the figure ({error})")))
    }

    pub(super) fn png(tree: &Tree) -> Result<Vec<u8>> {
        let [width, height] = [tree.size().width(), tree.size().height()].map(|side| (SCALE * side).ceil() as u32);
        let too_large = || Error::data(format!("cannot draw a figure of {width} by {height} pixels"));
        let mut pixels = Pixmap::new(width, height).ok_or_else(too_large)?;
        resvg::render(tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
        pixels.encode_png().map_err(|error| Error::data(format!("cannot write the figure as PNG ({error})")))
    }

    pub(super) fn pdf(tree: &Tree) -> Result<Vec<u8>> {
        svg2pdf::to_pdf(tree, svg2pdf::ConversionOptions::default(), svg2pdf::PageOptions::default())
            .map_err(|error| Error::data(format!("cannot write the figure as PDF ({error})")))
    }
}
