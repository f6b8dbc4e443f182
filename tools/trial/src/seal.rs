//! Labels that nobody can change after the fact: a commitment is published before, the label after.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

/// A label under seal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sealed {
    /// What keeps the commitment from being guessed.
    pub nonce: String,
    /// The label, as text.
    pub text: String,
}

impl Sealed {
    /// SHA-256 of nonce, a line feed and text, in hexadecimal digits.
    pub fn commitment(&self) -> String {
        let mut hash = Sha256::new();
        hash.update(self.nonce.as_bytes());
        hash.update(b"\n");
        hash.update(self.text.as_bytes());
        hash.finalize()
            .iter()
            .fold(String::new(), |mut digits, byte| {
                // writing to a text cannot fail
                let _ = write!(digits, "{byte:02x}");
                digits
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_commitment_is_a_plain_sha_256() {
        let sealed = Sealed {
            nonce: "a".to_owned(),
            text: "b\n".to_owned(),
        };
        // printf 'a\nb\n' | sha256sum
        let digits = "911169ddaaf146aff539f58c26c489af3b892dff0fe283c1c264c65ae5aa59a2";
        assert_eq!(sealed.commitment(), digits);
    }
}
