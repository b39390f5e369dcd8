//! Embedded pictures: addresses that contain the PNG.

/// The 64 digits of RFC 4648.
const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// The `data:` address of a PNG.
pub fn embedded(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", base64(png))
}

/// Base64 with padding, RFC 4648 section 4.
///
/// Each digit holds six bits; four digits hold three bytes.
pub fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |k: usize| u32::from(three.get(k).copied().unwrap_or_default());
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= three.len() { digit.into() } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::base64::Engine;
    use ::base64::engine::general_purpose::STANDARD;

    #[test]
    fn digits_are_those_of_the_standard() {
        let bytes: Vec<u8> = (0..=255u8).map(|k| k.wrapping_mul(151)).collect();
        for length in [0, 1, 2, 3, 4, 5, 256] {
            assert_eq!(base64(&bytes[..length]), STANDARD.encode(&bytes[..length]));
        }
        assert_eq!(embedded(b"foob"), "data:image/png;base64,Zm9vYg==");
    }
}
