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

/// y −= v·x.
#[inline(always)]
pub(super) fn axpy(v: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y -= v * x;
    }
}

/// Σ aᵢbᵢ, in eight interleaved sums.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_chunks, a_rest) = a.as_chunks::<8>();
    let (b_chunks, b_rest) = b.as_chunks::<8>();
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for k in 0..8 {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    ((sums[0] + sums[4]) + (sums[2] + sums[6])) + ((sums[1] + sums[5]) + (sums[3] + sums[7])) + rest
}
