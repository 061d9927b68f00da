//! `tracking.reference`: a trajectory that is known beforehand, as points in time.

use super::DesignError;
use super::document::{Field, Section, counted};
use nalgebra::DVector;

/// Part of a time by which a cycle may begin too early for a point and still be its cycle: 250 cycles of 0.02 s are
/// 5 s, whatever is rounded on the way.
const ROUNDING: f64 = 1e-9;

/// z^Ref of thesis (4.2), as a function of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Time in s, and the nz values of the tracked outputs then. At least one point; the first is at 0, and times
    /// ascend strictly.
    pub points: Vec<(f64, DVector<f64>)>,
    /// What holds between two points.
    pub interpolation: Interpolation,
}

/// What holds between two points. After the last one its value holds either way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// The value of the point before.
    Step,
    /// A straight line.
    Linear,
}

impl Reference {
    /// The nz values at `time_s`, in s; the first ones before time 0.
    ///
    /// A time that is too short for a point by 1e-9 of itself or less is taken as the point's.
    ///
    /// # Panics
    /// If there is no point.
    pub fn at(&self, time_s: f64) -> DVector<f64> {
        let now = time_s * (1.0 + ROUNDING);
        let next = self.points.partition_point(|&(time, _)| time <= now).max(1);
        let (since, value) = &self.points[next - 1];
        match (self.interpolation, self.points.get(next)) {
            (Interpolation::Linear, Some((until, target))) => {
                let passed = ((time_s - since) / (until - since)).clamp(0.0, 1.0);
                value * (1.0 - passed) + target * passed
            }
            _ => value.clone(),
        }
    }

    /// `outputs`: nz. `None`: the reference is not part of the design.
    pub(super) fn read(tracking: &Section<'_>, outputs: usize) -> Result<Option<Self>, DesignError> {
        let interpolation = tracking.optional("interpolation", "\"step\" or \"linear\"");
        let points = "points in time, [[time in s, z_1, ..], ..]: one value per row of tracking.z";
        let Some(field) = tracking.optional("reference", points) else {
            return match interpolation {
                None => Ok(None),
                Some(field) => {
                    let found = "found without tracking.reference".to_string();
                    Err(field.reject_with(found, "give the points to interpolate, or leave it out".into()))
                }
            };
        };
        let interpolation = match interpolation {
            None => Interpolation::Step,
            Some(field) => {
                field.choice(&[("step", Interpolation::Step), ("linear", Interpolation::Linear)])?
            }
        };
        Ok(Some(Reference { points: points_of(&field, outputs)?, interpolation }))
    }
}

fn points_of(field: &Field<'_>, outputs: usize) -> Result<Vec<(f64, DVector<f64>)>, DesignError> {
    let rows = field.matrix()?;
    if rows.ncols() != 1 + outputs {
        let found = format!(
            "found rows of {}, but tracking.z has {}",
            counted(rows.ncols(), "number"),
            counted(outputs, "row")
        );
        let allowed = format!("give rows of {}: a time in s, then one value per tracked output", 1 + outputs);
        return Err(field.reject_with(found, allowed));
    }
    let start = rows[(0, 0)];
    if start != 0.0 {
        let found = format!("found the time {start} s in row 1");
        return Err(field.reject_with(found, "begin at time 0".into()));
    }
    for row in 1..rows.nrows() {
        let (before, time) = (rows[(row - 1, 0)], rows[(row, 0)]);
        if time <= before {
            let found = format!("found the time {time} s in row {} after {before} s", row + 1);
            return Err(field.reject_with(found, "give times that ascend strictly".into()));
        }
    }
    Ok(rows.row_iter().map(|row| (row[0], row.columns(1, outputs).transpose().into_owned())).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(points: &[(f64, [f64; 2])], interpolation: Interpolation) -> Reference {
        let points = points.iter().map(|(time, value)| (*time, DVector::from_column_slice(value))).collect();
        Reference { points, interpolation }
    }

    #[test]
    fn a_step_applies_from_the_cycle_at_its_time_whatever_is_rounded() {
        // Products of cycles and sample times fall on either side of the time as it is written.
        for (sample_time, cycles) in [(0.02, 250), (0.1, 3), (0.005, 69), (1.0 / 3.0, 2), (1e-4, 123_457)] {
            let time = format!("{:.10}", sample_time * f64::from(cycles)).parse().unwrap();
            let steps = reference(&[(0.0, [1.0, 0.0]), (time, [2.0, 5.0])], Interpolation::Step);
            let value = |cycle: i32| steps.at(f64::from(cycle) * sample_time)[0];
            assert_eq!([-1, 0, cycles - 1].map(value), [1.0; 3], "{sample_time}");
            assert_eq!([cycles, cycles + 1, 100 * cycles].map(value), [2.0; 3], "{sample_time}");
        }
    }

    #[test]
    fn a_step_between_two_cycles_applies_from_the_later_one() {
        let steps = reference(&[(0.0, [0.0; 2]), (0.051, [1.0; 2])], Interpolation::Step);
        assert_eq!([4, 5, 6].map(|cycle| steps.at(f64::from(cycle) * 0.01)[1]), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn lines_join_the_points_and_the_last_value_holds() {
        let points = [(0.0, [1.0, 0.0]), (2.0, [3.0, -8.0]), (3.0, [3.0, 0.0])];
        let lines = reference(&points, Interpolation::Linear);
        for (time, value) in [
            (-1.0, [1.0, 0.0]),
            (0.0, [1.0, 0.0]),
            (0.5, [1.5, -2.0]),
            (2.0, [3.0, -8.0]),
            (2.75, [3.0, -2.0]),
            (3.0, [3.0, 0.0]),
            (1e9, [3.0, 0.0]),
        ] {
            assert!((lines.at(time) - DVector::from_column_slice(&value)).amax() < 1e-12, "{time}");
        }
    }
}
