//! Products of matrices of a few rows, written out: at these sizes nalgebra's general product costs several times
//! the multiplications.

use nalgebra::SMatrix;

/// Matrix, as columns, times vector.
#[inline]
pub(super) fn product<const M: usize, const N: usize>(
    columns: &[[f64; M]; N],
    vector: &[f64; N],
) -> [f64; M] {
    let mut product = [0.0; M];
    for (column, factor) in columns.iter().zip(vector) {
        for (sum, element) in product.iter_mut().zip(column) {
            *sum += element * factor;
        }
    }
    product
}

/// The same with each column of another matrix. (An array's own `map` is not always unrolled.)
#[inline]
pub(super) fn products<const L: usize, const M: usize, const N: usize>(
    columns: &[[f64; L]; M],
    vectors: &[[f64; M]; N],
) -> [[f64; L]; N] {
    let mut products = [[0.0; L]; N];
    for (result, vector) in products.iter_mut().zip(vectors) {
        *result = product(columns, vector);
    }
    products
}

/// Matrix times matrix.
#[inline]
pub(super) fn times<const N: usize>(a: &SMatrix<f64, N, N>, b: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    SMatrix::from_data(nalgebra::ArrayStorage(products(&a.data.0, &b.data.0)))
}

/// Scalar product.
#[inline]
pub(super) fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
