//! Probabilities of the normal and the chi-square distribution, and Wilson's interval.

use serde::Serialize;

/// Two-sided 95 % of the standard normal distribution.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;

/// A share of packets with the interval that holds the true one with 95 %.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Share {
    /// How many packets.
    pub packets: u64,
    /// Of all packets.
    pub probability: f64,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end of the interval.
    pub high: f64,
}

impl Share {
    /// `packets` of `all`, with Wilson's interval: the `p` with `(phat - p)^2 <= z^2 p (1-p) / n`.
    pub fn new(packets: u64, all: u64) -> Self {
        let (n, z2) = (all as f64, NORMAL_95 * NORMAL_95);
        let probability = packets as f64 / n;
        let middle = (probability + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half =
            NORMAL_95 / (1.0 + z2 / n) * (probability * (1.0 - probability) / n + z2 / (4.0 * n * n)).sqrt();
        // Where nothing or everything was seen, an end is known without rounding.
        let low = if packets == 0 { 0.0 } else { (middle - half).max(0.0) };
        let high = if packets == all { 1.0 } else { (middle + half).min(1.0) };
        Self { packets, probability, low, high }
    }

    /// Widens the interval to that of another share too.
    pub(super) fn hold(&mut self, other: &Self) {
        (self.low, self.high) = (self.low.min(other.low), self.high.max(other.high));
    }
}

/// P(|Z| >= |z|) of a standard normal Z.
pub fn two_sided(z: f64) -> f64 {
    libm::erfc(z.abs() / std::f64::consts::SQRT_2)
}

/// P(X >= `x`) of a chi-square X with `freedom` degrees of freedom. As these are whole, the incomplete gamma function is a
/// finite sum: `erfc(sqrt(h)) + e^-h sum h^(i-1/2) / Gamma(i+1/2)` for odd, `e^-h sum h^i / i!` for even, `h = x/2`.
pub fn chi_square(x: f64, freedom: usize) -> f64 {
    if x <= 0.0 || freedom == 0 {
        return 1.0;
    }
    let half = x / 2.0;
    let (start, shift) = if freedom.is_multiple_of(2) { (0.0, 0.0) } else { (libm::erfc(half.sqrt()), 0.5) };
    let terms = (0..freedom / 2).map(|i| {
        let power = i as f64 + shift;
        (power * half.ln() - half - libm::lgamma(power + 1.0)).exp()
    });
    (start + terms.sum::<f64>()).min(1.0)
}

/// A p-value for readers, with the sign before it.
pub(super) fn readable(p_value: f64) -> String {
    match p_value {
        0.001.. => format!("= {p_value:.3}"),
        1e-12.. => format!("= {p_value:.1e}"),
        _ => "< 1e-12".to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_the_chi_square_distribution_agree() {
        // 5 % and 1 % points to five digits.
        for (freedom, at_5, at_1) in [
            (1, 3.84146, 6.63490),
            (2, 5.99146, 9.21034),
            (3, 7.81473, 11.3449),
            (10, 18.3070, 23.2093),
            (101, 125.458, 136.971),
        ] {
            assert!((chi_square(at_5, freedom) - 0.05).abs() < 1e-5, "{freedom}");
            assert!((chi_square(at_1, freedom) - 0.01).abs() < 1e-5, "{freedom}");
        }
        assert_eq!((chi_square(0.0, 3), chi_square(1e4, 4)), (1.0, 0.0));
        assert!((two_sided(NORMAL_95) - 0.05).abs() < 1e-12);
    }

    #[test]
    fn ends_of_an_interval_solve_its_equation() {
        for (packets, all) in [(1, 10), (37, 1000), (70_000, 100_000)] {
            let share = Share::new(packets, all);
            for end in [share.low, share.high] {
                let squared = (share.probability - end).powi(2);
                let bound = NORMAL_95.powi(2) * end * (1.0 - end) / all as f64;
                assert!((squared - bound).abs() < 1e-12, "{share:?}");
            }
        }
        let (none, every) = (Share::new(0, 100), Share::new(100, 100));
        assert_eq!((none.low, every.high), (0.0, 1.0));
        assert!((none.high - 0.036_993_5).abs() < 1e-6 && (every.low - 0.963_006_5).abs() < 1e-6);
    }
}
