//! Maps from files: the reader of each format, chosen by the file's extension.

mod dxf;
mod geojson;
mod svg;

pub use crate::grid::from_grid;
pub use dxf::from_dxf;
pub use geojson::{from_geojson, to_geojson};
pub use svg::from_svg;

#[cfg(any(feature = "mcap", feature = "ros-map"))]
use crate::config::GridOptions;
use crate::config::budgets::MAP_BYTES;
#[cfg(feature = "ros-map")]
use crate::grid::MapServerFile;
#[cfg(any(feature = "mcap", feature = "ros-map"))]
use crate::grid::OccupancyGrid;
#[cfg(feature = "ros-map")]
use crate::text::cannot_open;
use crate::text::{read_bytes, suggestion, text_of};
use crate::world::Map;
use crate::{Error, Result};
#[cfg(feature = "ros-map")]
use std::io::ErrorKind;
use std::path::Path;

/// Reads a map file; its extension says the format: `.geojson` (or `.json`), `.svg`, `.dxf`, `.yaml` (ROS `map_server`,
/// see [`from_grid`]) or `.mcap` (the last `nav_msgs/OccupancyGrid` of a recording).
///
/// # Errors
///
/// A file that cannot be read, another format, or a fault in the file; the message names file, line and remedy.
pub fn read(path: impl AsRef<Path>) -> Result<Map> {
    let path = path.as_ref();
    match extension_of(path).as_str() {
        "geojson" | "json" | "svg" | "dxf" => from_bytes(read_bytes(path, "map", MAP_BYTES)?, path),
        #[cfg(feature = "ros-map")]
        "yaml" | "yml" => from_grid_file(&OccupancyGrid::read_map_server(path)?, path),
        #[cfg(feature = "mcap")]
        "mcap" => from_grid_file(&crate::ros::read_grid(path)?, path),
        extension => Err(unknown_format(path, extension)),
    }
}

/// Reads a map from the bytes of one file; the extension of its name says the format, as for [`read`]. For those who have bytes and no
/// files. A map in two files takes [`from_bytes_beside`].
///
/// # Errors
///
/// As [`read`], with the file's name as it is given.
pub fn from_bytes(bytes: Vec<u8>, name: impl AsRef<Path>) -> Result<Map> {
    from_bytes_beside(bytes, name, |_| None)
}

/// Reads a map from the bytes of a file; `beside` gives the bytes of another file that it names, which is the image of a `.yaml`.
///
/// # Errors
///
/// As [`read`], with the files' names as they are given.
pub fn from_bytes_beside(
    bytes: Vec<u8>,
    name: impl AsRef<Path>,
    beside: impl FnOnce(&Path) -> Option<Vec<u8>>,
) -> Result<Map> {
    let path = name.as_ref();
    #[cfg(not(feature = "ros-map"))]
    drop(beside);
    let reader = match extension_of(path).as_str() {
        "geojson" | "json" => from_geojson,
        "svg" => from_svg,
        "dxf" => return dxf::from_bytes(&bytes, path),
        #[cfg(feature = "ros-map")]
        "yaml" | "yml" => {
            let file = MapServerFile::parse(&text_of(bytes, path, "map")?, &path.to_string_lossy())?;
            let image = file.image_beside(path);
            let bytes = beside(&image).ok_or_else(|| cannot_open(&image, "map image", &ErrorKind::NotFound.into()))?;
            return from_grid_file(&file.grid(&bytes, &image.to_string_lossy())?, path);
        }
        #[cfg(all(feature = "mcap", feature = "ros-map"))]
        "mcap" => return from_grid_file(&crate::ros::grid_in(bytes.as_slice(), &path.to_string_lossy())?, path),
        extension => return Err(unknown_format(path, extension)),
    };
    reader(&text_of(bytes, path, "map")?, &path.to_string_lossy())
}

fn extension_of(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase()
}

#[cfg(any(feature = "mcap", feature = "ros-map"))]
fn from_grid_file(grid: &OccupancyGrid, path: &Path) -> Result<Map> {
    from_grid(grid, &GridOptions::default()).map_err(|error| error.in_file(path))
}

fn unknown_format(path: &Path, extension: &str) -> Error {
    let readable = ".geojson, .svg, .dxf, .yaml, .mcap";
    let convert = "draw or export the outline as SVG or GeoJSON";
    let error = match extension {
        "pgm" | "png" => Error::data("an image alone is no map: its scale and place are not known")
            .remedy("give the .yaml file beside it; docs/ros.md shows one"),
        "yaml" | "yml" | "mcap" => Error::data(format!("this build does not read `.{extension}`"))
            .remedy("build it with the features `ros-map` and `mcap`"),
        "dwg" => Error::data("DWG drawings are not read").remedy("save the drawing as DXF"),
        "" => Error::data("the map file has no extension, so its format is unknown")
            .remedy("rename it to end in .geojson, .svg, .dxf, .yaml or .mcap"),
        _ => {
            let error = Error::data(format!("maps in the format `.{extension}` are not read"));
            match suggestion(extension, ["geojson", "svg", "dxf", "yaml", "mcap"]) {
                Some(near) => error.remedy(format!("did you mean `.{near}`?")),
                None => error.remedy(convert),
            }
        }
    };
    error.in_file(path).allowed(readable)
}
