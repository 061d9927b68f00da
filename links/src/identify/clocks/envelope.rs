//! The lower envelope of delays over time: the convex hull from below. Only its corners can bound a line that is below all.

/// A time and a delay, in nanoseconds from an origin.
pub(super) type Point = (f64, f64);

/// Corners of the hull of points with ascending times.
pub(super) fn lower(points: impl Iterator<Item = Point>) -> Vec<Point> {
    let mut corners: Vec<Point> = Vec::new();
    for point in points {
        if corners.last().is_some_and(|last| last.0 == point.0) {
            // Of two at one time the lower one counts.
            if corners.last().is_some_and(|last| last.1 <= point.1) {
                continue;
            }
            corners.pop();
        }
        while let [.., before, last] = corners.as_slice()
            && turns_up(*before, *last, point) <= 0.0
        {
            corners.pop();
        }
        corners.push(point);
    }
    corners
}

/// Above zero if the way over three points turns up in the middle one.
fn turns_up(a: Point, b: Point, c: Point) -> f64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

/// How far all corners are above the line through the origin with a slope, at least.
pub(super) fn height(corners: &[Point], slope: f64) -> f64 {
    corners.iter().map(|(time, delay)| delay - slope * time).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_below_all_points() {
        let points = [(0.0, 5.0), (1.0, 2.0), (1.0, 3.0), (2.0, 9.0), (3.0, 2.5), (4.0, 2.0), (5.0, 7.0)];
        assert_eq!(lower(points.into_iter()), [(0.0, 5.0), (1.0, 2.0), (4.0, 2.0), (5.0, 7.0)]);
        for slope in [-2.0, -0.1, 0.0, 0.3, 5.0] {
            assert_eq!(height(&lower(points.into_iter()), slope), height(&points, slope));
        }
    }
}
