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

/// Factors a panel of `columns` scalar columns (a multiple of three) in place. The diagonal of L is stored inverted; so is
/// every 3×3 block on it, M, above the diagonal, transposed: a triangular solve then waits for three operations a block
/// and not for a chain of eight.
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
        // As LDLᵀ, whose pivots wait for a division each; the three roots then wait for none of them.
        let (a10, a20) = (first[j + 1], first[j + 2]);
        let r0 = 1.0 / pivot(first[j], 0);
        let (q10, q20) = (a10 * r0, a20 * r0);
        let a21 = second[j + 2] - a20 * q10;
        let r1 = 1.0 / pivot(second[j + 1] - a10 * q10, 1);
        let r2 = 1.0 / pivot(third[j + 2] - a20 * q20 - a21 * (a21 * r1), 2);
        let (i0, i1, i2) = (r0.sqrt(), r1.sqrt(), r2.sqrt());
        let (l10, l20, l21) = (a10 * i0, a20 * i0, a21 * i1);
        let from = (j + 3) & !3;
        let fours = first[from..].as_chunks_mut::<4>().0.iter_mut();
        let fours =
            fours.zip(second[from..].as_chunks_mut::<4>().0).zip(third[from..].as_chunks_mut::<4>().0);
        for ((a, b), c) in fours {
            for k in 0..4 {
                a[k] *= i0;
                b[k] = (b[k] - l10 * a[k]) * i1;
                c[k] = (c[k] - l20 * a[k] - l21 * b[k]) * i2;
            }
        }
        // Rows of this block share a group of four with the next: they are written last. Above the diagonal stands what is
        // below it in the block's inverse.
        let m10 = -l10 * i0 * i1;
        (first[j], first[j + 1], first[j + 2]) = (i0, l10, l20);
        (second[j], second[j + 1], second[j + 2]) = (m10, i1, l21);
        (third[j], third[j + 1], third[j + 2]) = (-(l20 * i0 + l21 * m10) * i2, -l21 * i1 * i2, i2);
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

/// Three columns of a panel, from a row (a multiple of four) on, in fours.
#[inline(always)]
fn three_columns(columns: &[f64], stride: usize, from: usize) -> [&[[f64; 4]]; 3] {
    let (a, rest) = columns.split_at(stride);
    let (b, c) = rest.split_at(stride);
    [a[from..].as_chunks::<4>().0, b[from..].as_chunks::<4>().0, c[from..stride].as_chunks::<4>().0]
}

/// w −= C·v over the rows from `from` (a multiple of four) on; C are three columns of a panel.
#[inline(always)]
pub(super) fn subtract_columns(columns: &[f64], stride: usize, from: usize, v: [f64; 3], w: &mut [f64]) {
    let [a, b, c] = three_columns(columns, stride, from);
    for (((w, a), b), c) in w[from..].as_chunks_mut::<4>().0.iter_mut().zip(a).zip(b).zip(c) {
        for k in 0..4 {
            w[k] -= a[k] * v[0] + b[k] * v[1] + c[k] * v[2];
        }
    }
}

/// Cᵀw over the rows from `from` (a multiple of four) on.
#[inline(always)]
pub(super) fn dot_columns(columns: &[f64], stride: usize, from: usize, w: &[f64]) -> [f64; 3] {
    let [a, b, c] = three_columns(columns, stride, from);
    let mut sums = [[0.0; 4]; 3];
    for (((w, a), b), c) in w[from..].as_chunks::<4>().0.iter().zip(a).zip(b).zip(c) {
        for k in 0..4 {
            sums[0][k] += a[k] * w[k];
            sums[1][k] += b[k] * w[k];
            sums[2][k] += c[k] * w[k];
        }
    }
    let [a, b, c] = sums;
    [(a[0] + a[2]) + (a[1] + a[3]), (b[0] + b[2]) + (b[1] + b[3]), (c[0] + c[2]) + (c[1] + c[3])]
}

/// Solves L y = w for the columns of a panel: y replaces the front of `w`, L's rows below take their share off the rest.
#[inline(always)]
pub(super) fn forward_panel(panel: &[f64], stride: usize, columns: usize, w: &mut [f64]) {
    for j in (0..columns).step_by(3) {
        let c = &panel[j * stride..(j + 3) * stride];
        let m = |row: usize, column: usize| c[row * stride + j + column];
        let (w0, w1, w2) = (w[j], w[j + 1], w[j + 2]);
        let (w0, w1, w2) =
            (m(0, 0) * w0, m(1, 0) * w0 + m(1, 1) * w1, (m(2, 0) * w0 + m(2, 1) * w1) + m(2, 2) * w2);
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
        let m = |row: usize, column: usize| c[row * stride + j + column];
        // Rows of this block and above are still zero in `w`.
        let known = dot_columns(c, stride, (j + 3) & !3, w);
        let (v0, v1, v2) = (y[j] - known[0], y[j + 1] - known[1], y[j + 2] - known[2]);
        w[j] = m(0, 0) * v0 + (m(1, 0) * v1 + m(2, 0) * v2);
        w[j + 1] = m(1, 1) * v1 + m(2, 1) * v2;
        w[j + 2] = m(2, 2) * v2;
    }
}
