//! Random designs, and the same designs in other units.

use crate::Rows;
use nalgebra::{DMatrix, DVector};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Largest and smallest power of ten that a unit is changed by.
const POWERS: i32 = 9;

/// Delays of a link, P(delay = 0, 1, ..).
const LINKS: [&[f64]; 5] = [
    &[1.0],
    &[0.7, 0.14, 0.054, 0.03, 0.02],
    &[0.02, 0.11, 0.16, 0.15, 0.13, 0.1, 0.08],
    &[0.6],
    &[0.0, 0.9, 0.05],
];

/// A design with every matrix at hand.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Whether `a` and `b` are per second; a cycle lasts 0.1 s then.
    pub is_continuous: bool,
    /// `nx x nx`.
    pub a: DMatrix<f64>,
    /// `nx x nu`.
    pub b: DMatrix<f64>,
    /// `ny x nx`.
    pub c: DMatrix<f64>,
    /// `W`.
    pub process_noise: DMatrix<f64>,
    /// `V`.
    pub measurement_noise: DMatrix<f64>,
    /// Weight of the state, or of `Z x`.
    pub q: DMatrix<f64>,
    /// Weight of the input.
    pub r: DMatrix<f64>,
    /// `Z`, with `[tracking]`; its outputs keep their units.
    pub z: Option<DMatrix<f64>>,
    /// Price of a packet, with `[event]`.
    pub send_cost: Option<f64>,
    /// Of both links: indices of [`LINKS`].
    links: [usize; 2],
    /// `N`.
    pub length: usize,
    /// Whether the actuator holds its last input.
    pub holds: bool,
}

/// Factors by which the numbers of states, inputs and outputs are multiplied.
#[derive(Debug, Clone)]
pub struct Units {
    /// One for each state.
    pub states: DVector<f64>,
    /// One for each input.
    pub inputs: DVector<f64>,
    /// One for each output.
    pub outputs: DVector<f64>,
}

impl Units {
    /// Powers of ten from 1e-9 to 1e9 for this design.
    pub fn draw(design: &Drawn, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut powers =
            |count| DVector::from_fn(count, |_, _| 10f64.powi(rng.random_range(-POWERS..=POWERS)));
        Self {
            states: powers(design.a.nrows()),
            inputs: powers(design.b.ncols()),
            outputs: powers(design.c.nrows()),
        }
    }
}

/// The entries of `matrix` times the factors of their rows and columns.
pub fn scaled(matrix: &DMatrix<f64>, rows: &DVector<f64>, columns: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        matrix[(i, j)] * (rows[i % rows.len()] * columns[j % columns.len()])
    })
}

/// The factors of the opposite change.
pub fn inverse(factors: &DVector<f64>) -> DVector<f64> {
    factors.map(f64::recip)
}

impl Drawn {
    /// A random design. Plants decay, grow, or have integrators and undamped oscillations.
    pub fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (states, inputs, outputs) =
            (rng.random_range(1..=5), rng.random_range(1..=2), rng.random_range(1..=3));
        let mut full = |rows, columns| DMatrix::from_fn(rows, columns, |_, _| rng.random_range(-1.0..1.0));
        let square = |root: DMatrix<f64>| {
            &root * root.transpose() + DMatrix::<f64>::identity(root.nrows(), root.nrows()) * 0.1
        };
        let (shape, b, c) = (full(states, states), full(states, inputs), full(outputs, states));
        let (process_noise, measurement_noise) =
            (square(full(states, states)), square(full(outputs, outputs)));
        let (q, r, z) = (square(full(states, states)), square(full(inputs, inputs)), full(1, states));
        let largest = shape.complex_eigenvalues().iter().map(|value| value.norm()).fold(1e-3, f64::max);
        let is_continuous = rng.random_bool(0.3);
        let a = match rng.random_range(0..4) {
            0 if is_continuous => integrators(states, 0.0),
            0 => integrators(states, 1.0),
            _ if is_continuous => shape * (2.0 / largest),
            _ => shape * (rng.random_range(0.5..1.2) / largest),
        };
        let tracks = rng.random_bool(0.2);
        Self {
            is_continuous,
            a,
            b,
            c,
            process_noise,
            measurement_noise,
            q: if tracks { DMatrix::from_element(1, 1, 1.0) } else { q },
            r,
            z: tracks.then_some(z),
            send_cost: rng.random_bool(0.2).then_some(1.0),
            links: [rng.random_range(0..LINKS.len()), rng.random_range(0..LINKS.len())],
            length: rng.random_range(1..=6),
            holds: rng.random_bool(0.4),
        }
    }

    /// The same plant, cost and links, told in other units.
    pub fn told_in(&self, units: &Units) -> Self {
        let (states, inputs, outputs) = (&units.states, &units.inputs, &units.outputs);
        let per_state = inverse(states);
        Self {
            a: scaled(&self.a, states, &per_state),
            b: scaled(&self.b, states, &inverse(inputs)),
            c: scaled(&self.c, outputs, &per_state),
            process_noise: scaled(&self.process_noise, states, states),
            measurement_noise: scaled(&self.measurement_noise, outputs, outputs),
            q: if self.z.is_some() { self.q.clone() } else { scaled(&self.q, &per_state, &per_state) },
            r: scaled(&self.r, &inverse(inputs), &inverse(inputs)),
            z: self.z.as_ref().map(|z| scaled(z, &DVector::from_element(1, 1.0), &per_state)),
            ..self.clone()
        }
    }

    /// The design file.
    pub fn file(&self) -> String {
        let zero = DMatrix::<f64>::zeros(self.a.nrows(), self.a.nrows());
        let [control, sensing] = self.links.map(|link| LINKS[link]);
        let mut file = format!(
            "name = \"drawn\"\n\
             [plant]\n\
             sample_time = 0.1\n\
             {} = {{ a = {}, b = {} }}\n\
             c = {}\n\
             process_noise = {}\n\
             measurement_noise = {}\n\
             initial_mean = {:?}\n\
             initial_covariance = {}\n\
             [cost]\n\
             q = {}\n\
             r = {}\n\
             [network]\n\
             controller_to_actuator.delays = {control:?}\n\
             sensor_to_controller.delays = {sensing:?}\n\
             [controller]\n\
             sequence_length = {}\n\
             default_input = \"{}\"\n\
             scalar = \"f64\"\n",
            if self.is_continuous { "continuous" } else { "discrete" },
            spelled(&self.a),
            spelled(&self.b),
            spelled(&self.c),
            spelled(&self.process_noise),
            spelled(&self.measurement_noise),
            zero.column(0).as_slice(),
            spelled(&zero),
            spelled(&self.q),
            spelled(&self.r),
            self.length,
            if self.holds { "hold" } else { "zero" },
        );
        if let Some(z) = &self.z {
            file += &format!("[tracking]\nz = {}\npreview = 5\n", spelled(z));
        }
        if let Some(price) = self.send_cost {
            file += &format!("[event]\nsend_cost = {price:?}\n");
        }
        file
    }
}

/// A chain of integrators, and an undamped oscillation if there are enough states; `on_diagonal`: 1 per cycle, 0 per second.
fn integrators(states: usize, on_diagonal: f64) -> DMatrix<f64> {
    let mut a = DMatrix::from_fn(states, states, |i, j| match j as isize - i as isize {
        0 => on_diagonal,
        1 => 0.5,
        _ => 0.0,
    });
    if states >= 4 {
        let at = states - 2;
        a.view_mut((at, at), (2, 2)).copy_from_slice(&if on_diagonal == 0.0 {
            [0.0, -3.0, 3.0, 0.0]
        } else {
            [0.6, -0.8, 0.8, 0.6]
        });
    }
    a
}

fn spelled(matrix: &DMatrix<f64>) -> String {
    let rows: Rows = matrix.row_iter().map(|row| row.iter().copied().collect()).collect();
    format!("{rows:?}")
}
