//! Products of matrices of a few rows, written out: at these sizes nalgebra's general product costs several times
//! the multiplications.

use nalgebra::SMatrix;

/// Matrix, as columns, times vector.
#[inline]
pub(super) fn product<const N: usize>(columns: &[[f64; N]; N], vector: &[f64; N]) -> [f64; N] {
    let mut product = [0.0; N];
    for (column, factor) in columns.iter().zip(vector) {
        for (sum, element) in product.iter_mut().zip(column) {
            *sum += element * factor;
        }
    }
    product
}

/// Matrix times matrix.
#[inline]
pub(super) fn times<const N: usize>(a: &SMatrix<f64, N, N>, b: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    SMatrix::from_data(nalgebra::ArrayStorage(b.data.0.map(|column| product(&a.data.0, &column))))
}

/// Scalar product.
#[inline]
pub(super) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
