//! Commitments: the hash of a label is published before the trial, the label afterwards.

use std::fmt::Write as _;

use sha2::{Digest, Sha256};

/// A sealed label.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sealed {
    /// Random text that prevents guessing the label from its commitment.
    pub nonce: String,
    /// The label, as text.
    pub text: String,
}

impl Sealed {
    /// SHA-256 of the nonce, a line feed and the text, in hexadecimal digits.
    pub fn commitment(&self) -> String {
        sha256(&format!("{}\n{}", self.nonce, self.text))
    }
}

/// SHA-256 of a text, in hexadecimal digits.
pub fn sha256(text: &str) -> String {
    Sha256::digest(text.as_bytes())
        .iter()
        .fold(String::new(), |mut digits, byte| {
            // Writing to a string cannot fail.
            let _ = write!(digits, "{byte:02x}");
            digits
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_commitment_is_the_sha_256_of_nonce_and_text() {
        let sealed = Sealed {
            nonce: "a".to_owned(),
            text: "b\n".to_owned(),
        };
        // printf 'a\nb\n' | sha256sum
        let digits = "911169ddaaf146aff539f58c26c489af3b892dff0fe283c1c264c65ae5aa59a2";
        assert_eq!(sealed.commitment(), digits);
    }
}
