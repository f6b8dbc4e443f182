//! The Cholesky factor of a 3 by 3 matrix.

/// Inverse of the lower Cholesky factor of a 3 by 3 matrix.
pub(crate) fn inverse_factor(s: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let a = s[0][0].sqrt();
    let b = s[1][0] / a;
    let c = (s[1][1] - b * b).max(f64::MIN_POSITIVE).sqrt();
    let d = s[2][0] / a;
    let e = (s[2][1] - d * b) / c;
    let f = (s[2][2] - d * d - e * e).max(f64::MIN_POSITIVE).sqrt();
    let (ia, ic, r#if) = (1.0 / a, 1.0 / c, 1.0 / f);
    let ib = -b * ia * ic;
    let ie = -e * ic * r#if;
    [
        [ia, 0.0, 0.0],
        [ib, ic, 0.0],
        [-(d * ia + e * ib) * r#if, ie, r#if],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_factor_whitens() {
        let s = [[4.0, 1.0, 0.5], [1.0, 3.0, -0.7], [0.5, -0.7, 2.0]];
        let c = inverse_factor(&s);
        for i in 0..3 {
            for k in 0..3 {
                let mut sum = 0.0;
                for l in 0..3 {
                    for m in 0..3 {
                        sum += c[i][l] * s[l][m] * c[k][m];
                    }
                }
                let wanted = f64::from(u8::from(i == k));
                assert!((sum - wanted).abs() < 1e-12, "{i} {k} {sum}");
            }
        }
    }
}
