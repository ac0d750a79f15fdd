//! Products of matrices, a tile of registers at a time.
//!
//! A tile is a few rows of the result by a few vectors of its columns. Its sums stay in registers
//! while the terms go by, and what is done with them at the end (bias, ReLU, Adam) is done before
//! they are written: nothing passes through memory twice.
//!
//! Every sum is one lane's, added up in one order by fused multiply-adds. So the result does not
//! depend on how wide the processor's vectors are: it is the same to the last bit with AVX-512,
//! with AVX2, with NEON and without any.

use pulp::{Arch, NullaryFnOnce, Simd, WithSimd};

/// Floats in the widest vector.
const LANES: usize = 16;

/// So many columns with the zeros that pad a row to whole vectors.
pub(super) fn padded(columns: usize) -> usize {
    columns.next_multiple_of(LANES)
}

/// Rows of a tile: with four vectors of columns 20 of the 32 vector registers of AVX-512 and NEON
/// hold sums, with two vectors 10 of the 16 of AVX2. 5 divides the 420 inputs and a batch of 50.
const ROWS: usize = 5;

/// A matrix that is computed by tiles.
pub(super) trait Tiled {
    /// How many rows and padded columns it has.
    fn size(&self) -> (usize, usize);

    /// Computes `R` rows from `row` on and `C` vectors of columns from the vector `column` on.
    fn tile<S: Simd, const R: usize, const C: usize>(&mut self, simd: S, row: usize, column: usize);
}

/// Computes a matrix by the instructions of a processor.
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
                        _ => unreachable!("tiles are at most 5 x 4, and 1, 2 or 4 vectors wide"),
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

/// A function of its own for each size of tile: within a greater one the compiler would not keep
/// all the sums in registers.
#[inline(never)]
fn run<S: Simd, T: Tiled, const R: usize, const C: usize>(
    simd: S,
    matrix: &mut T,
    row: usize,
    column: usize,
) {
    simd.vectorize(Tile::<S, T, R, C> { simd, matrix, row, column });
}

/// Adds `left[r] * right[c]` to every sum, term after term.
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

/// A padded slice as vectors.
#[inline(always)]
pub(super) fn vectors<S: Simd>(floats: &[f32]) -> &[S::f32s] {
    S::as_simd_f32s(floats).0
}

/// A padded slice as vectors.
#[inline(always)]
pub(super) fn vectors_mut<S: Simd>(floats: &mut [f32]) -> &mut [S::f32s] {
    S::as_mut_simd_f32s(floats).0
}

/// `N` elements of a slice.
#[inline(always)]
pub(super) fn take<T: Copy, const N: usize>(slice: &[T], start: usize) -> [T; N] {
    let mut elements = [slice[start]; N];
    elements.copy_from_slice(&slice[start..start + N]);
    elements
}
