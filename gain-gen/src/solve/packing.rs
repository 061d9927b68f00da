//! The independent numbers of a cost-to-go: upper triangles of `P`, `Y` and the `N_t`, each `N_t` from its first nonzero
//! row on, and all of `S`. A sixth of the whole for long sequences, and no unsymmetric matrix can be formed from them.

use slqg::synthesis::Dimensions;

/// Where the independent numbers stand in a cost-to-go.
pub(crate) struct Packing {
    /// Position and, for symmetric entries, mirrored position.
    entries: Vec<(usize, usize)>,
}

impl Packing {
    pub(crate) fn new(dimensions: &Dimensions) -> Self {
        let (nx, v) = (dimensions.states, dimensions.in_flight_rows());
        let mut entries = Vec::new();
        let mut triangle = |base: usize, size: usize, first: usize| {
            for row in first..size {
                for column in row..size {
                    entries.push((base + row * size + column, base + column * size + row));
                }
            }
        };
        triangle(0, nx, 0);
        let y = nx * nx + nx * v;
        triangle(y, v, 0);
        for t in 0..dimensions.in_flight() {
            triangle(y + (t + 1) * v * v, v, t * dimensions.inputs);
        }
        entries.extend((nx * nx..y).map(|index| (index, index)));
        Self { entries }
    }

    /// How many there are.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    pub(crate) fn pack(&self, value: &[f64]) -> Vec<f64> {
        self.entries.iter().map(|&(index, _)| value[index]).collect()
    }

    pub(crate) fn pack_into(&self, value: &[f64], packed: &mut [f64]) {
        for (number, &(index, _)) in packed.iter_mut().zip(&self.entries) {
            *number = value[index];
        }
    }

    pub(crate) fn unpack(&self, packed: &[f64], value: &mut [f64]) {
        for (number, &(index, mirrored)) in packed.iter().zip(&self.entries) {
            value[index] = *number;
            value[mirrored] = *number;
        }
    }
}
