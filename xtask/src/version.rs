//! Versions of compilers.

/// `1.85`, `1.85.0` and `1.85.0-nightly` as numbers that compare.
pub(crate) fn numbers(version: &str) -> [u32; 3] {
    let mut parts = version.split(['.', '-']).map_while(|part| part.parse().ok());
    std::array::from_fn(|_| parts.next().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_compare_as_numbers() {
        assert!(numbers("1.85.0") == numbers("1.85"));
        assert!(numbers("1.100.0-nightly") > numbers("1.85"));
        assert!(numbers("1.63.0") < numbers("1.85") && numbers("1.85.1") > numbers("1.85"));
    }
}
