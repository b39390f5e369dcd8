//! Two stages on integers, which hardware can match to the bit.
//!
//! They are the sum of DAS, and the multiplications and additions of the covariance.

/// Complex words.
pub type Word = [i16; 2];

/// Delay and sum of 16 words: their mean, with halves rounded up.
///
/// It is the sum in 20 bits, plus 8, with an arithmetic shift by 4 to the right.
pub fn das(snapshot: &[Word; 16]) -> Word {
    let part = |k: usize| {
        let sum: i32 = snapshot.iter().map(|x| i32::from(x[k])).sum();
        ((sum + 8) >> 4) as i16
    };
    [part(0), part(1)]
}

/// An entry of the forward covariance of 16 words: `Σ_l x[l + i]·conj(x[l + j])`.
///
/// The sum is over the 9 subapertures of length 8, and exact in 40 bits.
pub fn covariance(snapshot: &[Word; 16], i: usize, j: usize) -> [i64; 2] {
    let mut sum = [0; 2];
    for l in 0..9 {
        let ([a, b], [c, d]) = (
            snapshot[l + i].map(i64::from),
            snapshot[l + j].map(i64::from),
        );
        sum[0] += a * c + b * d;
        sum[1] += b * c - a * d;
    }
    sum
}

/// Corner cases of snapshots.
///
/// All largest, all smallest, alternating, a single one, halves that are rounded either way, and zeros.
pub fn corners() -> Vec<[Word; 16]> {
    let largest = i16::MAX;
    let mut corners = vec![
        [[largest, largest]; 16],
        [[-largest, -largest]; 16],
        [[0, 0]; 16],
    ];
    let mut alternating = [[largest, -largest]; 16];
    for word in alternating.iter_mut().step_by(2) {
        *word = [-largest, largest];
    }
    corners.push(alternating);
    for value in [1i16, -1, 7, 8, 9, -7, -8, -9, 24, -24] {
        let mut alone = [[0, 0]; 16];
        alone[value.unsigned_abs() as usize % 16] = [value, -value];
        corners.push(alone);
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_round_up() {
        for (sum, mean) in [(7, 0), (8, 1), (24, 2), (-8, 0), (-9, -1), (-24, -1)] {
            let mut snapshot = [[0, 0]; 16];
            snapshot[3] = [sum, 0];
            assert_eq!(das(&snapshot)[0], mean, "{sum}");
        }
        assert_eq!(das(&[[-32767, 32767]; 16]), [-32767, 32767]);
    }

    #[test]
    fn the_covariance_is_hermitian_and_fits() {
        for snapshot in corners() {
            for i in 0..8 {
                for j in 0..8 {
                    let [re, im] = covariance(&snapshot, i, j);
                    let [re_t, im_t] = covariance(&snapshot, j, i);
                    assert_eq!((re, im), (re_t, -im_t));
                    assert!(re.abs() < 1 << 39 && im.abs() < 1 << 39);
                }
            }
        }
        // 9 subapertures, each of power 2·32767².
        assert_eq!(
            covariance(&[[32767, 32767]; 16], 2, 2),
            [9 * 2 * 32767 * 32767, 0]
        );
    }
}
