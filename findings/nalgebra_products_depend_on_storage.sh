#!/bin/sh
# nalgebra 0.34.2: the product of two f32 matrices with static dimensions is not the product of the same matrices with dynamic ones.
#
# Above 5 x 5, dynamic matrices go to the crate `matrixmultiply`, whose kernels fuse products and sums where the processor can.
# Static ones are multiplied by plain loops. Both are right to rounding; they are not the same bits, and which ones the dynamic product has
# depends on the processor that it runs on.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir src
cat > Cargo.toml <<'END'
[package]
name = "finding"
version = "0.0.0"
edition = "2021"

[dependencies]
nalgebra = "=0.34.2"

[workspace]
END
cat > src/main.rs <<'END'
use nalgebra::{DMatrix, SMatrix};

/// Entries of 100 products of random N x N matrices that differ, of how many.
fn differing<const N: usize>() -> (usize, usize) {
    let mut seed = 1u32;
    let mut next = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    let mut count = 0;
    for _ in 0..100 {
        let a = SMatrix::<f32, N, N>::from_fn(|_, _| next());
        let b = SMatrix::<f32, N, N>::from_fn(|_, _| next());
        let with_static = a * b;
        let dynamic = |m: &SMatrix<f32, N, N>| DMatrix::from_column_slice(N, N, m.as_slice());
        let with_dynamic = dynamic(&a) * dynamic(&b);
        let pairs = with_static.iter().zip(with_dynamic.iter());
        count += pairs.filter(|(x, y)| x.to_bits() != y.to_bits()).count();
    }
    (count, 100 * N * N)
}

fn main() {
    for (size, (count, all)) in [(4, differing::<4>()), (6, differing::<6>()), (8, differing::<8>())] {
        println!("{size} x {size}: {count} of {all} entries differ");
    }
}
END
cargo run --quiet --release > seen
echo "nalgebra 0.34.2, products with static against dynamic dimensions:"
cat seen
grep -q '^4 x 4: 0 of' seen || { echo "changed: small products differ, too"; exit 1; }
if grep -q '^6 x 6: 0 of' seen; then
    echo "changed: they agree (or this processor has no fused multiply-add)"
    exit 1
fi
