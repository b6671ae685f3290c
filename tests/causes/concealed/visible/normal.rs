//! The normal equations of the visibility's fit: the restarts' motions are eliminated block by block, the parameters
//! stay.

use super::{PARAMETERS, Problem, RESTART, RESTART_DOUBT, Row, Rows, Theta, doubts};

fn inner(x: &[Row], y: &[Row]) -> f64 {
    x.iter().zip(y).map(|(p, q)| p.iter().zip(q).map(|(a, b)| a * b).sum::<f64>()).sum()
}

/// The normal equations of the car's parameters (and of any further columns) after the restarts' motions are
/// eliminated block by block.
pub(super) struct Reduced {
    normal: Vec<Vec<f64>>,
    right: Vec<f64>,
    /// For each block: how its motion follows from the residual and from the parameters.
    motion: Vec<[Vec<f64>; RESTART]>,
}

pub(super) fn reduce(theta: &Theta, columns: &[Rows], restarts: &[Rows], residual: &Rows) -> Reduced {
    let (n, size) = (columns.len(), Problem::per_block());
    let mut normal = vec![vec![0.0; n]; n];
    let mut right = vec![0.0; n];
    let doubts = doubts();
    for j in 0..PARAMETERS.min(n) {
        let precision = 1.0 / (doubts[j] * doubts[j]);
        normal[j][j] += precision;
        right[j] -= theta.car[j] * precision;
    }
    let mut motion = Vec::new();
    for (block, around) in theta.restart.iter().enumerate() {
        let rows = block * size..(block + 1) * size;
        let part = |column: &'_ Rows| -> Vec<Row> { column[rows.clone()].to_vec() };
        let own: Vec<Vec<Row>> = restarts.iter().map(part).collect();
        let cols: Vec<Vec<Row>> = columns.iter().map(part).collect();
        let rest = part(residual);
        let mut inside = vec![vec![0.0; RESTART]; RESTART];
        let mut push = [0.0; RESTART];
        for i in 0..RESTART {
            for j in 0..RESTART {
                inside[i][j] = inner(&own[i], &own[j]);
            }
            let precision = RESTART_DOUBT[i].powi(-2);
            inside[i][i] += precision;
            push[i] = inner(&own[i], &rest) - around[i] * precision;
        }
        let cross: Vec<Vec<f64>> = cols.iter().map(|c| own.iter().map(|o| inner(o, c)).collect()).collect();
        let freed = solve(inside.clone(), push.to_vec());
        let follow: Vec<Vec<f64>> = cross.iter().map(|c| solve(inside.clone(), c.clone())).collect();
        let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
        for i in 0..n {
            for j in 0..n {
                normal[i][j] += inner(&cols[i], &cols[j]) - dot(&cross[i], &follow[j]);
            }
            right[i] += inner(&cols[i], &rest) - dot(&cross[i], &freed);
        }
        motion.push(std::array::from_fn(|k| {
            std::iter::once(freed[k]).chain(follow.iter().map(|f| f[k])).collect()
        }));
    }
    Reduced { normal, right, motion }
}

impl Reduced {
    /// The step of all parameters that the first `n` columns make.
    pub(super) fn step(&self, n: usize) -> Theta {
        let normal = self.normal[..n].iter().map(|row| row[..n].to_vec()).collect();
        let car = solve(normal, self.right[..n].to_vec());
        let restart = self
            .motion
            .iter()
            .map(|m| {
                std::array::from_fn(|k| m[k][0] - m[k][1..].iter().zip(&car).map(|(f, c)| f * c).sum::<f64>())
            })
            .collect();
        Theta {
            car: std::array::from_fn(|j| car[j]),
            restart,
            strength: car.get(PARAMETERS).copied().unwrap_or(0.0),
        }
    }

    /// How much of the cost each column behind the car's parameters would take, alone, and its coefficient.
    pub(super) fn gains(&self) -> Vec<(f64, f64)> {
        let n = PARAMETERS;
        let core: Vec<Vec<f64>> = self.normal[..n].iter().map(|row| row[..n].to_vec()).collect();
        (n..self.right.len())
            .map(|j| {
                let cross: Vec<f64> = (0..n).map(|i| self.normal[i][j]).collect();
                let weights = solve(core.clone(), cross.clone());
                let dot = |x: &[f64]| weights.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
                let schur = self.normal[j][j] - dot(&cross);
                let slope = self.right[j] - dot(&self.right[..n]);
                if schur > 1e-9 * self.normal[j][j] && schur > 0.0 {
                    (slope * slope / schur, slope / schur)
                } else {
                    (0.0, 0.0)
                }
            })
            .collect()
    }
}

/// Solves a symmetric positive system by Cholesky's factors.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            if i == j {
                a[i][i] = (a[i][i] - sum).max(1e-300).sqrt();
            } else {
                a[i][j] = (a[i][j] - sum) / a[j][j];
            }
        }
    }
    for i in 0..n {
        let sum: f64 = (0..i).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|k| a[k][i] * b[k]).sum();
        b[i] = (b[i] - sum) / a[i][i];
    }
    b
}
