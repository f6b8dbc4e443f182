//! CDR (Common Data Representation) as ROS 2 uses it: four bytes name the encoding, then the message.

use byteorder::{BigEndian, LittleEndian};
use serde::{Deserialize, Serialize};

/// Encapsulation header of plain CDR: little endian, no options.
const LITTLE_ENDIAN: [u8; 4] = [0, 1, 0, 0];

/// Replaces the content of `buffer` by the encoded message.
///
/// # Errors
/// If CDR cannot represent the message's type.
pub(crate) fn encode<T: Serialize>(message: &T, buffer: &mut Vec<u8>) -> Result<(), String> {
    buffer.clear();
    buffer.extend_from_slice(&LITTLE_ENDIAN);
    cdr_encoding::to_writer::<T, LittleEndian, _>(buffer, message).map_err(|e| e.to_string())
}

/// Decodes a message of either byte order. Allocates no more than the message's length.
///
/// # Errors
/// If the bytes are not a message of this type.
pub fn decode<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, String> {
    let Some(([_, encoding, _, _], body)) = bytes.split_first_chunk() else {
        return Err("the message is shorter than its header".to_owned());
    };
    let decoded = match encoding {
        0 => cdr_encoding::from_bytes::<T, BigEndian>(body),
        1 => cdr_encoding::from_bytes::<T, LittleEndian>(body),
        other => return Err(format!("encoding {other} is not plain CDR")),
    };
    match decoded {
        Ok((message, _)) => Ok(message),
        Err(error) => Err(error.to_string()),
    }
}
