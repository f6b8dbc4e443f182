//! Whole numbers as postcard encodes them, for the loops: a third of what its serializer takes.

/// Seven bits a byte, the lowest first; the highest bit says that more follow.
#[inline]
pub(super) fn unsigned(mut value: u64, bytes: &mut Vec<u8>) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

/// Zigzag: 0, −1, 1, −2, … become 0, 1, 2, 3, …
#[inline]
pub(super) fn signed(value: i64, bytes: &mut Vec<u8>) {
    unsigned(((value << 1) ^ (value >> 63)).cast_unsigned(), bytes);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_postcards() {
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
            let wanted = postcard::to_allocvec(&(value, value.cast_unsigned()));
            assert_eq!(Ok(bytes), wanted);
        }
    }
}
