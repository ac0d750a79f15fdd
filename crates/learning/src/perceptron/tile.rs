//! Matrix products, computed in tiles of registers.
//!
//! A tile spans a few rows of the result and a few vectors of its columns. The sums of a tile stay
//! in registers while the terms are added, and are finished (with ReLU or Adam) before they are
//! written, so each result passes through memory once.
//!
//! Each sum is computed in one lane, in a fixed order, with fused multiply-adds. The result is
//! therefore independent of the vector width: it is identical to the last bit with AVX-512, AVX2,
//! NEON and no vector instructions.

use pulp::{Arch, NullaryFnOnce, Simd, WithSimd};

/// Number of floats in the widest vector.
const LANES: usize = 16;

/// Returns the number of columns, padded to a whole number of vectors.
pub(super) fn padded(columns: usize) -> usize {
    columns.next_multiple_of(LANES)
}

/// Maximum number of rows in a tile. With four vectors of columns, the sums take 20 of the 32
/// vector registers of AVX-512 and NEON; with two vectors, they take 10 of the 16 registers of
/// AVX2. The 420 inputs and a batch of 50 are both multiples of 5.
const ROWS: usize = 5;

/// A matrix that is computed in tiles.
pub(super) trait Tiled {
    /// Returns the number of rows and the number of padded columns.
    fn size(&self) -> (usize, usize);

    /// Computes `R` rows, starting at `row`, and `C` vectors of columns, starting at vector
    /// `column`.
    fn tile<S: Simd, const R: usize, const C: usize>(&mut self, simd: S, row: usize, column: usize);
}

/// Computes a matrix with the given vector instructions.
pub(super) fn compute(arch: Arch, mut matrix: impl Tiled) {
    arch.dispatch(Tiles(&mut matrix));
}

struct Tiles<'a, T>(&'a mut T);

impl<T: Tiled> WithSimd for Tiles<'_, T> {
    type Output = ();

    fn with_simd<S: Simd>(self, simd: S) {
        let (rows, width) = self.0.size();
        for_each_tile(simd, rows, width / S::F32_LANES, self.0);
    }
}

fn for_each_tile<S: Simd>(simd: S, rows: usize, columns: usize, matrix: &mut impl Tiled) {
    let widest = if S::REGISTER_COUNT >= 32 { 4 } else { 2 };
    let mut column = 0;
    while column < columns {
        let width = match columns - column {
            rest if rest >= widest => widest,
            rest => rest.min(2),
        };
        for row in (0..rows).step_by(ROWS) {
            let height = (rows - row).min(ROWS);
            macro_rules! run {
                ($($r:literal x $c:literal),*) => {
                    match (height, width) {
                        $(($r, $c) => run::<S, _, $r, $c>(simd, matrix, row, column),)*
                        _ => unreachable!("tiles have 1 to 5 rows and 1, 2 or 4 vectors"),
                    }
                };
            }
            run!(
                5 x 4, 4 x 4, 3 x 4, 2 x 4, 1 x 4,
                5 x 2, 4 x 2, 3 x 2, 2 x 2, 1 x 2,
                5 x 1, 4 x 1, 3 x 1, 2 x 1, 1 x 1
            );
        }
        column += width;
    }
}

struct Tile<'a, S, T, const R: usize, const C: usize> {
    simd: S,
    matrix: &'a mut T,
    row: usize,
    column: usize,
}

impl<S: Simd, T: Tiled, const R: usize, const C: usize> NullaryFnOnce for Tile<'_, S, T, R, C> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.matrix.tile::<S, R, C>(self.simd, self.row, self.column);
    }
}

/// Computes a tile. This function is not inlined, so that each tile size has a separate function:
/// in one function with several sizes, the compiler would not keep all sums in registers.
#[inline(never)]
fn run<S: Simd, T: Tiled, const R: usize, const C: usize>(
    simd: S,
    matrix: &mut T,
    row: usize,
    column: usize,
) {
    simd.vectorize(Tile::<S, T, R, C> { simd, matrix, row, column });
}

/// Adds `left[r] * right[c]` to `sums[r][c]` for each pair of items of `left` and `right`, in order.
/// Returns the sums.
#[inline(always)]
pub(super) fn add_products<S: Simd, const R: usize, const C: usize>(
    simd: S,
    mut sums: [[S::f32s; C]; R],
    left: impl Iterator<Item = [f32; R]>,
    right: impl Iterator<Item = [S::f32s; C]>,
) -> [[S::f32s; C]; R] {
    for (left, right) in left.zip(right) {
        for r in 0..R {
            let left = simd.splat_f32s(left[r]);
            for c in 0..C {
                sums[r][c] = simd.mul_add_f32s(left, right[c], sums[r][c]);
            }
        }
    }
    sums
}

/// Returns a padded slice as vectors.
#[inline(always)]
pub(super) fn vectors<S: Simd>(floats: &[f32]) -> &[S::f32s] {
    S::as_simd_f32s(floats).0
}

/// Returns a padded slice as mutable vectors.
#[inline(always)]
pub(super) fn vectors_mut<S: Simd>(floats: &mut [f32]) -> &mut [S::f32s] {
    S::as_mut_simd_f32s(floats).0
}

/// Returns `N` elements of a slice, starting at `start`.
#[inline(always)]
pub(super) fn take<T: Copy, const N: usize>(slice: &[T], start: usize) -> [T; N] {
    let mut elements = [slice[start]; N];
    elements.copy_from_slice(&slice[start..start + N]);
    elements
}
