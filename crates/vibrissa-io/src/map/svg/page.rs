//! The page: from user units to metres, y up.

use crate::text::line_at;
use crate::{Error, Result};
use kurbo::Affine;
use roxmltree::Node;
use std::str::FromStr;
use svgtypes::{Length, LengthUnit, ViewBox};

/// How large one user unit is without further notice (m).
const MILLIMETRE: f64 = 1e-3;

/// Where the page lies in the map.
pub(super) struct Page {
    /// From user units of the root element to metres.
    pub(super) map_from_user: Affine,
    pub(super) warnings: Vec<String>,
}

pub(super) fn page(root: Node<'_, '_>) -> Result<Page> {
    let view = root.attribute("viewBox").map(|text| view_box(root, text)).transpose()?;
    let (width, height) = (length(root, "width")?, length(root, "height")?);
    let mut warnings = Vec::new();
    let physical = [width, height].map(|l| l.and_then(metres));
    let Some(view) = view else {
        if physical.iter().any(Option::is_some) {
            warnings.push("the drawing has a size but no viewBox; one user unit is taken as 1 mm".to_owned());
        }
        let bottom = height.map_or(0.0, |h| metres(h).map_or(h.number, |m| m / MILLIMETRE));
        return Ok(Page { map_from_user: flip(0.0, bottom, MILLIMETRE), warnings });
    };
    let scales = [physical[0].map(|w| w / view.w), physical[1].map(|h| h / view.h)];
    let scale = match scales {
        [Some(a), Some(b)] => {
            if (a - b).abs() > 1e-3 * a.max(b) {
                warnings.push(format!(
                    "width and height stretch the viewBox unequally ({:.4} and {:.4} mm per unit); the smaller is taken",
                    a / MILLIMETRE,
                    b / MILLIMETRE
                ));
            }
            a.min(b)
        }
        [Some(one), None] | [None, Some(one)] => one,
        [None, None] => MILLIMETRE,
    };
    if [width, height].into_iter().flatten().any(|l| l.unit == LengthUnit::Px) {
        warnings.push(
            "the drawing's size is in px, which says nothing about metres; one user unit is taken as 1 mm".into(),
        );
    }
    Ok(Page { map_from_user: flip(view.x, view.y + view.h, scale), warnings })
}

/// The map that puts (left, bottom) at the origin, x right and y up.
fn flip(left: f64, bottom: f64, scale: f64) -> Affine {
    Affine::new([scale, 0.0, 0.0, -scale, -left * scale, bottom * scale])
}

fn view_box(root: Node<'_, '_>, text: &str) -> Result<ViewBox> {
    let view = ViewBox::from_str(text).ok().filter(|v| v.w > 0.0 && v.h > 0.0);
    view.filter(|v| (v.x + v.y + v.w + v.h).is_finite()).ok_or_else(|| {
        at(root, Error::data("the viewBox is not four numbers with positive width and height").value(text))
    })
}

fn length(root: Node<'_, '_>, attribute: &str) -> Result<Option<Length>> {
    let Some(text) = root.attribute(attribute).filter(|text| *text != "auto") else { return Ok(None) };
    match Length::from_str(text.trim()) {
        Ok(length) if length.number > 0.0 && length.number.is_finite() => Ok(Some(length)),
        _ => {
            let error = Error::data(format!("the drawing's {attribute} is not a positive length")).value(text);
            Err(at(root, error.allowed("a number with mm, cm, in, pt, pc or no unit")))
        }
    }
}

fn at(root: Node<'_, '_>, error: Error) -> Error {
    error.at_line(line_at(root.document().input_text().as_bytes(), root.range().start))
}

/// The length in metres when its unit is a physical one.
fn metres(length: Length) -> Option<f64> {
    let millimetres = match length.unit {
        LengthUnit::Mm => 1.0,
        LengthUnit::Cm => 10.0,
        LengthUnit::In => 25.4,
        LengthUnit::Pt => 25.4 / 72.0,
        LengthUnit::Pc => 25.4 / 6.0,
        _ => return None,
    };
    Some(length.number * millimetres * MILLIMETRE)
}
