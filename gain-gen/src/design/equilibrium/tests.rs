//! Random plants in random units, built around equilibria that are known.

use super::*;

/// splitmix64: the same numbers on every machine.
struct Draws(u64);

impl Draws {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Within -1 and 1.
    fn number(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Within `least..=most`.
    fn between(&mut self, least: usize, most: usize) -> usize {
        least + (self.bits() % (most - least + 1) as u64) as usize
    }

    fn matrix(&mut self, rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| self.number())
    }

    /// With zeros, one entry in three.
    fn sparse(&mut self, rows: usize, columns: usize) -> DMatrix<f64> {
        DMatrix::from_fn(rows, columns, |_, _| if self.between(0, 2) == 0 { 0.0 } else { self.number() })
    }

    fn vector(&mut self, size: usize) -> DVector<f64> {
        DVector::from_fn(size, |_, _| self.number())
    }

    /// Factors from 1e-6 to 1e6: units.
    fn units(&mut self, count: usize) -> DVector<f64> {
        DVector::from_fn(count, |_, _| 10f64.powf(6.0 * self.number()))
    }
}

fn plant(a: DMatrix<f64>, b: DMatrix<f64>) -> Plant {
    let states = a.nrows();
    let square = || DMatrix::identity(states, states);
    Plant {
        sample_time: 1.0,
        a,
        b,
        c: square(),
        process_noise: square(),
        measurement_noise: square(),
        initial_mean: DVector::zeros(states),
        initial_covariance: square(),
        continuous: None,
    }
}

/// A plant, its tracked outputs and the price of its inputs.
struct Rig {
    plant: Plant,
    z: DMatrix<f64>,
    r: DMatrix<f64>,
}

impl Rig {
    /// Up to five states, three inputs and four outputs.
    fn drawn(draws: &mut Draws, sparse: bool) -> Self {
        let (states, inputs) = (draws.between(1, 5), draws.between(1, 3));
        let outputs = draws.between(1, states.min(4));
        let mut matrix = |rows, columns| {
            if sparse { draws.sparse(rows, columns) } else { draws.matrix(rows, columns) }
        };
        let (a, mut b, mut z) = (matrix(states, states), matrix(states, inputs), matrix(outputs, states));
        // No row and no column of zeros.
        (0..inputs).for_each(|input| b[(input % states, input)] += 2.0);
        (0..outputs).for_each(|output| z[(output, output)] += 2.0);
        let root = draws.matrix(inputs, inputs);
        let r = &root * root.transpose() + DMatrix::<f64>::identity(inputs, inputs) * 0.1;
        Rig { plant: plant(a, b), z, r }
    }

    /// Bends the plant until it rests at the state `x` with the input `u`.
    fn bend(&mut self, x: &DVector<f64>, u: &DVector<f64>) {
        let defect = &self.plant.a * x + &self.plant.b * u - x;
        self.plant.a -= defect * x.transpose() / x.norm_squared();
    }

    /// The same in other units.
    fn scaled(&self, states: &DVector<f64>, inputs: &DVector<f64>, outputs: &DVector<f64>) -> Self {
        let diagonal = |units: &DVector<f64>| DMatrix::from_diagonal(units);
        let inverse = |units: &DVector<f64>| DMatrix::from_diagonal(&units.map(f64::recip));
        Rig {
            plant: plant(
                diagonal(states) * &self.plant.a * inverse(states),
                diagonal(states) * &self.plant.b * inverse(inputs),
            ),
            z: diagonal(outputs) * &self.z * inverse(states),
            r: inverse(inputs) * &self.r * inverse(inputs),
        }
    }

    fn equilibria(&self) -> Equilibria {
        Equilibria::of(&self.plant, &self.z, &self.r)
    }

    /// The state and the input that are said to hold `value`.
    fn at(&self, equilibria: &Equilibria, value: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
        let solution = &equilibria.solution * value;
        let (states, inputs) = (self.plant.states(), self.plant.inputs());
        (solution.rows(0, states).into_owned(), solution.rows(states, inputs).into_owned())
    }

    /// Largest miss of `A x + B u = x` and `Z x = value`, row by row in parts of the terms that are summed up.
    fn miss(&self, x: &DVector<f64>, u: &DVector<f64>, value: &DVector<f64>) -> f64 {
        let Plant { a, b, .. } = &self.plant;
        let part = |miss: DVector<f64>, terms: DVector<f64>| {
            miss.iter().zip(&terms).map(|(miss, terms)| miss.abs() / (terms + 1e-300)).fold(0.0, f64::max)
        };
        let of_state = part(a * x + b * u - x, a.abs() * x.abs() + b.abs() * u.abs() + x.abs());
        of_state.max(part(&self.z * x - value, self.z.abs() * x.abs() + value.abs()))
    }
}

/// A plant that is bent to rest at a state with an input, both drawn, and its tracked outputs there.
fn resting(draws: &mut Draws, sparse: bool) -> (Rig, DVector<f64>) {
    let mut rig = Rig::drawn(draws, sparse);
    let (x, u) = (draws.vector(rig.plant.states()), draws.vector(rig.plant.inputs()));
    rig.bend(&x, &u);
    let value = &rig.z * x;
    (rig, value)
}

#[test]
fn known_equilibria_are_found_in_any_units() {
    let mut draws = Draws(1);
    for case in 0..2000 {
        let (rig, value) = resting(&mut draws, case % 2 == 0);
        let units = [rig.plant.states(), rig.plant.inputs(), rig.z.nrows()].map(|count| draws.units(count));
        let value = value.component_mul(&units[2]);
        let rig = rig.scaled(&units[0], &units[1], &units[2]);
        let equilibria = rig.equilibria();
        assert!(equilibria.hold(&value), "{case}: {value}, nearest {}", equilibria.nearest(&value));
        let (x, u) = rig.at(&equilibria, &value);
        let miss = rig.miss(&x, &u, &value);
        assert!(miss < 1e-10, "{case}: {miss:e}");
    }
}

#[test]
fn an_integrator_rests_anywhere_without_input() {
    let mut draws = Draws(5);
    for case in 0..1000 {
        let mut rig = Rig::drawn(&mut draws, case % 2 == 0);
        let x = draws.vector(rig.plant.states());
        rig.bend(&x, &DVector::zeros(rig.plant.inputs()));
        let equilibria = rig.equilibria();
        let value = &rig.z * x;
        assert!(equilibria.hold(&value), "{case}: {value}, nearest {}", equilibria.nearest(&value));
        let (x, u) = rig.at(&equilibria, &value);
        assert!(rig.miss(&x, &u, &value) < 1e-9, "{case}");
        assert!(u.amax() <= 1e-9 * x.amax().max(value.amax()), "{case}: {u}");
    }
}

#[test]
fn points_beside_the_known_ones_are_refused() {
    let (mut draws, mut refused) = (Draws(2), 0);
    while refused < 1000 {
        let (rig, value) = resting(&mut draws, false);
        let outputs = rig.z.nrows();
        if outputs <= rig.plant.inputs() {
            continue;
        }
        let units = [rig.plant.states(), rig.plant.inputs(), outputs].map(|count| draws.units(count));
        let value = value.component_mul(&units[2]);
        let equilibria = rig.scaled(&units[0], &units[1], &units[2]).equilibria();
        assert_eq!(equilibria.dimensions(), rig.plant.inputs());
        let mut beside = value.clone();
        beside[draws.between(0, outputs - 1)] *= 1.001;
        assert!(!equilibria.hold(&beside), "{value} and {beside}");
        let nearest = equilibria.nearest(&beside);
        assert!(equilibria.hold(&nearest));
        // No farther than the point known, after scaling.
        let distance = |point: &DVector<f64>| (point - &beside).component_mul(&equilibria.scale).norm();
        assert!(distance(&nearest) <= distance(&value) * (1.0 + 1e-9));
        refused += 1;
    }
}

#[test]
fn of_several_inputs_the_cheapest_is_taken() {
    let (mut draws, mut checked) = (Draws(3), 0);
    while checked < 500 {
        let (rig, value) = resting(&mut draws, checked % 2 == 0);
        let (states, inputs) = (rig.plant.states(), rig.plant.inputs());
        if inputs <= rig.z.nrows() {
            continue;
        }
        let (x, u) = rig.at(&rig.equilibria(), &value);
        assert!(rig.miss(&x, &u, &value) < 1e-9);
        // Along any direction in which the plant still rests and z stays, u'Ru does not fall.
        let mut system = DMatrix::zeros(states + rig.z.nrows(), states + inputs);
        let still = &rig.plant.a - DMatrix::<f64>::identity(states, states);
        system.view_mut((0, 0), (states, states)).copy_from(&still);
        system.view_mut((0, states), (states, inputs)).copy_from(&rig.plant.b);
        system.view_mut((states, 0), (rig.z.nrows(), states)).copy_from(&rig.z);
        let free = Factors::of(&system, 1.0).kernel;
        assert!(free.ncols() > 0);
        let slope = free.rows(states, inputs).tr_mul(&(&rig.r * &u));
        assert!(slope.amax() <= 1e-9 * (&rig.r * &u).amax().max(1.0), "{slope}");
        checked += 1;
    }
}

#[test]
fn two_inputs_share_by_price() {
    // Two heaters with the same effect, one four times as expensive: it gives a fifth.
    let rig = Rig {
        plant: plant(DMatrix::from_element(1, 1, 0.9), DMatrix::from_row_slice(1, 2, &[0.1, 0.1])),
        z: DMatrix::identity(1, 1),
        r: DMatrix::from_diagonal(&DVector::from_vec(vec![1.0, 4.0])),
    };
    let input = rig.equilibria().input();
    assert!((input - DMatrix::from_column_slice(2, 1, &[0.8, 0.2])).amax() < 1e-12);
}

#[test]
fn a_cart_rests_anywhere_without_input_but_never_while_it_moves() {
    let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.02, 0.0, 0.99]);
    let b = DMatrix::from_column_slice(2, 1, &[2e-4, 0.02]);
    let rig = Rig { plant: plant(a, b), z: DMatrix::identity(2, 2), r: DMatrix::identity(1, 1) };
    let equilibria = rig.equilibria();
    assert_eq!(equilibria.input(), DMatrix::zeros(1, 2));
    let [rest, moving] = [[0.3, 0.0], [0.3, 1e-3]].map(|value| DVector::from_column_slice(&value));
    assert!(equilibria.hold(&rest));
    assert!(!equilibria.hold(&moving));
    assert!((equilibria.nearest(&moving) - rest).amax() < 1e-12);
}

#[test]
fn a_position_that_nobody_looks_at_may_drift_nowhere() {
    // Only the velocity is tracked. Without friction it would be held by no input, but the position would run away.
    let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.02, 0.0, 1.0]);
    let b = DMatrix::from_column_slice(2, 1, &[2e-4, 0.02]);
    let z = DMatrix::from_row_slice(1, 2, &[0.0, 1.0]);
    let equilibria = Rig { plant: plant(a, b), z, r: DMatrix::identity(1, 1) }.equilibria();
    assert_eq!(equilibria.dimensions(), 0);
    assert!(equilibria.hold(&DVector::zeros(1)));
    assert!(!equilibria.hold(&DVector::repeat(1, 1e-6)));
    assert_eq!(equilibria.input(), DMatrix::zeros(1, 1));
}

#[test]
fn zero_can_always_be_held() {
    let mut draws = Draws(4);
    for case in 0..200 {
        let rig = Rig::drawn(&mut draws, case % 2 == 0);
        let equilibria = rig.equilibria();
        assert!(equilibria.hold(&DVector::zeros(rig.z.nrows())));
    }
}
