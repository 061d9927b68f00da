//! What a sample of numbers comes to: mean, standard error, quantiles.

/// Arithmetic mean; NaN of nothing.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard error of the mean; NaN of fewer than two values.
pub fn standard_error(values: &[f64]) -> f64 {
    let mean = mean(values);
    let count = values.len() as f64;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (variance / count).sqrt()
}

/// The value below which a fraction of the values lies, interpolated linearly between ranks; NaN of nothing.
pub fn quantile(values: &[f64], fraction: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let rank = fraction * last as f64;
    let below = rank.floor() as usize;
    let weight = rank - below as f64;
    let (low, high) = (sorted[below], sorted[(below + 1).min(last)]);
    if weight == 0.0 { low } else { low + weight * (high - low) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate_between_ranks() {
        let values = [4.0, 1.0, 3.0, 2.0];
        assert_eq!(quantile(&values, 0.0), 1.0);
        assert_eq!(quantile(&values, 0.5), 2.5);
        assert_eq!(quantile(&values, 1.0), 4.0);
        assert!(quantile(&[], 0.5).is_nan());
    }

    #[test]
    fn the_standard_error_of_the_mean_falls_with_the_number_of_values() {
        let few = [1.0, 3.0];
        assert_eq!(standard_error(&few), 1.0);
        assert!(standard_error(&few.repeat(100)) < 0.1);
    }
}
