//! The dense kernels: plain loops over small tiles, which the compiler turns into the widest vectors that the machine at
//! hand has. A multiplication and an addition are never fused and every sum has one fixed order, so that all machines
//! give the same bytes.

/// Σₖ a[r + k·stride]·b[c + k·stride] over `depth` columns.
#[inline(always)]
pub(super) fn tile<const R: usize, const C: usize>(
    a: &[f64],
    b: &[f64],
    stride: usize,
    depth: usize,
) -> [[f64; R]; C] {
    let mut sums = [[0.0; R]; C];
    for k in 0..depth {
        let (Some(a), Some(b)) = (a[k * stride..].first_chunk::<R>(), b[k * stride..].first_chunk::<C>())
        else {
            break;
        };
        for c in 0..C {
            for r in 0..R {
                sums[c][r] += a[r] * b[c];
            }
        }
    }
    sums
}

/// target[r + c·stride] −= tile[c][r].
#[inline(always)]
fn subtract<const R: usize, const C: usize>(tile: &[[f64; R]; C], target: &mut [f64], stride: usize) {
    for (c, column) in tile.iter().enumerate() {
        if let Some(target) = target[c * stride..].first_chunk_mut::<R>() {
            for r in 0..R {
                target[r] -= column[r];
            }
        }
    }
}

/// A pivot below this share of the diagonal entry that it came from is rounding: nothing determines its unknown.
const SMALLEST_PIVOT: f64 = 1e-15;

/// Factors a panel of `columns` scalar columns (a multiple of three) in place; the diagonal of L is stored inverted.
/// `diagonal` are the diagonal entries before elimination; `damped` is told the scalar columns whose pivot had to be
/// replaced.
#[inline(always)]
pub(super) fn factor_panel(
    panel: &mut [f64],
    stride: usize,
    columns: usize,
    diagonal: &[f64],
    mut damped: impl FnMut(usize),
) {
    for j in (0..columns).step_by(3) {
        let (done, rest) = panel.split_at_mut(j * stride);
        if j > 0 {
            let mut i = j & !3;
            while i + 8 <= stride {
                subtract(&tile::<8, 3>(&done[i..], &done[j..], stride, j), &mut rest[i..], stride);
                i += 8;
            }
            if i < stride {
                subtract(&tile::<4, 3>(&done[i..], &done[j..], stride, j), &mut rest[i..], stride);
            }
        }
        let (first, rest) = rest.split_at_mut(stride);
        let (second, rest) = rest.split_at_mut(stride);
        let third = &mut rest[..stride];
        let mut pivot = |value: f64, k: usize| {
            let before = diagonal[j + k];
            if value > SMALLEST_PIVOT * before {
                return value;
            }
            damped(j + k);
            if before > 0.0 { before } else { 1.0 }
        };
        let i0 = 1.0 / pivot(first[j], 0).sqrt();
        let (l10, l20) = (first[j + 1] * i0, first[j + 2] * i0);
        let i1 = 1.0 / pivot(second[j + 1] - l10 * l10, 1).sqrt();
        let l21 = (second[j + 2] - l20 * l10) * i1;
        let i2 = 1.0 / pivot(third[j + 2] - l20 * l20 - l21 * l21, 2).sqrt();
        (first[j], first[j + 1], first[j + 2]) = (i0, l10, l20);
        (second[j + 1], second[j + 2]) = (i1, l21);
        third[j + 2] = i2;
        let below = j + 3..stride;
        for ((a, b), c) in
            first[below.clone()].iter_mut().zip(&mut second[below.clone()]).zip(&mut third[below])
        {
            *a *= i0;
            *b = (*b - l10 * *a) * i1;
            *c = (*c - l20 * *a - l21 * *b) * i2;
        }
    }
}

/// update −= B·Bᵀ, lower triangle, B the rows of the panel from `own` on.
#[inline(always)]
pub(super) fn downdate(panel: &[f64], stride: usize, own: usize, columns: usize, update: &mut [f64]) {
    let below = stride - own;
    let b = &panel[own..];
    for j in (0..below).step_by(4) {
        let target = &mut update[j * below..];
        let mut i = j;
        while i + 8 <= below {
            subtract(&tile::<8, 4>(&b[i..], &b[j..], stride, columns), &mut target[i..], below);
            i += 8;
        }
        if i < below {
            subtract(&tile::<4, 4>(&b[i..], &b[j..], stride, columns), &mut target[i..], below);
        }
    }
}

/// w −= C·v over the rows from `from` (a multiple of four) on; C are three columns of a panel.
#[inline(always)]
pub(super) fn subtract_columns(columns: &[f64], stride: usize, from: usize, v: [f64; 3], w: &mut [f64]) {
    let [a, b, c] = [0, 1, 2].map(|k| columns[k * stride + from..(k + 1) * stride].as_chunks::<4>().0);
    for (((w, a), b), c) in w[from..].as_chunks_mut::<4>().0.iter_mut().zip(a).zip(b).zip(c) {
        for k in 0..4 {
            w[k] -= a[k] * v[0] + b[k] * v[1] + c[k] * v[2];
        }
    }
}

/// Cᵀw over the rows from `from` (a multiple of four) on.
#[inline(always)]
pub(super) fn dot_columns(columns: &[f64], stride: usize, from: usize, w: &[f64]) -> [f64; 3] {
    let [a, b, c] = [0, 1, 2].map(|k| columns[k * stride + from..(k + 1) * stride].as_chunks::<4>().0);
    let mut sums = [[0.0; 4]; 3];
    for (((w, a), b), c) in w[from..].as_chunks::<4>().0.iter().zip(a).zip(b).zip(c) {
        for k in 0..4 {
            sums[0][k] += a[k] * w[k];
            sums[1][k] += b[k] * w[k];
            sums[2][k] += c[k] * w[k];
        }
    }
    sums.map(|s| (s[0] + s[2]) + (s[1] + s[3]))
}

/// Solves L y = w for the columns of a panel: y replaces the front of `w`, L's rows below take their share off the rest.
#[inline(always)]
pub(super) fn forward_panel(panel: &[f64], stride: usize, columns: usize, w: &mut [f64]) {
    for j in (0..columns).step_by(3) {
        let c = &panel[j * stride..(j + 3) * stride];
        let (l, w0) = (|row: usize, column: usize| c[column * stride + j + row], w[j] * c[j]);
        let w1 = (w[j + 1] - l(1, 0) * w0) * l(1, 1);
        let w2 = (w[j + 2] - l(2, 0) * w0 - l(2, 1) * w1) * l(2, 2);
        // The rows of this block share a group of four with the next: they are written last.
        subtract_columns(c, stride, (j + 3) & !3, [w0, w1, w2], w);
        (w[j], w[j + 1], w[j + 2]) = (w0, w1, w2);
    }
}

/// Solves Lᵀx = y for the columns of a panel; `w`: zeros (padding too) but for the rows below. x replaces its front.
#[inline(always)]
pub(super) fn backward_panel(panel: &[f64], stride: usize, columns: usize, y: &[f64], w: &mut [f64]) {
    for j in (0..columns).step_by(3).rev() {
        let c = &panel[j * stride..(j + 3) * stride];
        let l = |row: usize, column: usize| c[column * stride + j + row];
        // Rows of this block and above are still zero in `w`.
        let known = dot_columns(c, stride, (j + 3) & !3, w);
        let x2 = (y[j + 2] - known[2]) * l(2, 2);
        let x1 = (y[j + 1] - known[1] - l(2, 1) * x2) * l(1, 1);
        let x0 = (y[j] - known[0] - l(1, 0) * x1 - l(2, 0) * x2) * l(0, 0);
        (w[j], w[j + 1], w[j + 2]) = (x0, x1, x2);
    }
}
