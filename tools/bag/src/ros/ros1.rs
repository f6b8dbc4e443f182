//! Encoding of ROS 1 messages: little endian, without padding; lengths of texts and lists as 32 bits before them.

use serde::Deserialize;
use serde::de::value::Error;
use serde::de::{self, DeserializeSeed, Error as _, SeqAccess, Visitor};

/// Decodes a message. Allocates no more than the message's length.
///
/// # Errors
/// If the bytes are not a message of this type.
pub(super) fn decode<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Result<T, String> {
    T::deserialize(&mut Decoder { rest: bytes }).map_err(|error| error.to_string())
}

/// The part of a message that is not decoded yet.
struct Decoder<'a> {
    rest: &'a [u8],
}

impl<'a> Decoder<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let split = self.rest.split_at_checked(count);
        let (taken, rest) = split.ok_or_else(|| Error::custom("the message is too short"))?;
        self.rest = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        self.take(N)?.try_into().map_err(Error::custom)
    }

    fn length(&mut self) -> Result<usize, Error> {
        let length = u32::from_le_bytes(self.array()?);
        usize::try_from(length).map_err(Error::custom)
    }
}

/// Methods that decode a number.
macro_rules! numbers {
    ($($method:ident $visit:ident $number:ty;)*) => {$(
        fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
            visitor.$visit(<$number>::from_le_bytes(self.array()?))
        }
    )*};
}

impl<'de> de::Deserializer<'de> for &mut Decoder<'de> {
    type Error = Error;

    numbers! {
        deserialize_u8 visit_u8 u8;
        deserialize_u32 visit_u32 u32;
        deserialize_u64 visit_u64 u64;
        deserialize_i32 visit_i32 i32;
        deserialize_i64 visit_i64 i64;
        deserialize_f64 visit_f64 f64;
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let length = self.length()?;
        let text = std::str::from_utf8(self.take(length)?).map_err(Error::custom)?;
        visitor.visit_borrowed_str(text)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Error> {
        let length = self.length()?;
        self.deserialize_tuple(length, visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(
        self,
        length: usize,
        visitor: V,
    ) -> Result<V::Value, Error> {
        let items = Items {
            decoder: self,
            left: length,
        };
        visitor.visit_seq(items)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Error> {
        self.deserialize_tuple(fields.len(), visitor)
    }

    fn deserialize_any<V: Visitor<'de>>(self, _visitor: V) -> Result<V::Value, Error> {
        Err(Error::custom("no message has a field of this type"))
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i128 u16 u128 f32 char str bytes byte_buf option unit unit_struct newtype_struct tuple_struct map
        enum identifier ignored_any
    }
}

/// The items of a list, or the fields of a message.
struct Items<'a, 'de> {
    decoder: &'a mut Decoder<'de>,
    left: usize,
}

impl<'de> SeqAccess<'de> for Items<'_, 'de> {
    type Error = Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Error> {
        let Some(left) = self.left.checked_sub(1) else {
            return Ok(None);
        };
        self.left = left;
        seed.deserialize(&mut *self.decoder).map(Some)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Deserialize)]
    struct Message {
        name: Vec<String>,
        count: i32,
        values: [f64; 2],
    }

    #[test]
    fn lists_texts_and_numbers_stand_one_after_the_other() {
        let mut bytes = vec![2, 0, 0, 0, 1, 0, 0, 0, b'a', 0, 0, 0, 0];
        bytes.extend((-3_i32).to_le_bytes());
        bytes.extend([0.5_f64, -1.0].iter().flat_map(|value| value.to_le_bytes()));
        let message: Message = decode(&bytes).unwrap();
        assert_eq!(message.name, ["a", ""]);
        assert_eq!((message.count, message.values), (-3, [0.5, -1.0]));
        assert!(decode::<Message>(&bytes[..bytes.len() - 1]).is_err());
    }

    #[test]
    fn a_claimed_length_is_not_believed() {
        assert!(decode::<Vec<f64>>(&[255, 255, 255, 127, 1, 2]).is_err());
    }
}
