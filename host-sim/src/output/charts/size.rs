//! The size of a picture: the backend draws on fine pixels, a file has units of length.

use super::FINE;

/// The picture with other attributes for its size; its view box keeps the proportions.
pub(crate) fn sized(svg: &str, size: &str) -> String {
    match (svg.find(" width="), svg.find(" viewBox=")) {
        (Some(old), Some(view)) if old < view => format!("{}{size}{}", &svg[..old], &svg[view..]),
        _ => svg.to_string(),
    }
}

/// The picture with its size in units of length instead of the backend's fine pixels.
pub(crate) fn in_units(svg: &str) -> String {
    let value = |name: &str| -> Option<u32> {
        let (_, rest) = svg.split_once(name)?;
        rest.split('"').next()?.parse().ok()
    };
    match (value(" width=\""), value(" height=\"")) {
        (Some(width), Some(height)) => {
            sized(svg, &format!(" width=\"{}\" height=\"{}\"", width / FINE, height / FINE))
        }
        _ => svg.to_string(),
    }
}
