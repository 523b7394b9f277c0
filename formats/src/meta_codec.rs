//! The metadata section: a codec byte, then the metadata in that codec.

use crate::Meta;
use bincode::config::{Config, standard};

/// Codec byte: bincode 2, `config::standard()`, through serde.
const BINCODE_2_STANDARD: u8 = 1;

/// Most bytes that a metadata section may hold, and that decoding it may allocate.
pub const META_LIMIT: usize = 16 << 20;

/// Why metadata cannot be encoded or decoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MetaFault {
    /// No codec byte.
    #[error("it is empty; expected a codec byte and the encoded metadata")]
    Empty,
    /// A codec that this library does not have.
    #[error("its codec is {found}; this library knows codec {BINCODE_2_STANDARD}")]
    Codec {
        /// The codec byte.
        found: u8,
    },
    /// Larger than allowed.
    #[error("it takes {found} bytes; at most {META_LIMIT} are allowed")]
    TooLarge {
        /// Bytes.
        found: u64,
    },
    /// Not what the codec writes.
    #[error("it does not decode: {cause}")]
    Decode {
        /// The codec's words.
        cause: String,
    },
    /// The codec could not write it.
    #[error("it does not encode: {cause}")]
    Encode {
        /// The codec's words.
        cause: String,
    },
    /// Bytes follow the metadata.
    #[error("the metadata ends after {consumed} of {found} bytes; expected it to fill the section")]
    Unconsumed {
        /// Bytes that the metadata took.
        consumed: usize,
        /// Bytes of the section.
        found: usize,
    },
    /// Decodes, but the writer would encode the same metadata in other bytes.
    #[error("its encoding is not the one that the codec writes")]
    NotCanonical,
}

fn config() -> impl Config {
    standard().with_limit::<META_LIMIT>()
}

/// The bytes of the metadata section.
///
/// # Errors
/// [`MetaFault::TooLarge`], or what the codec reports.
pub(crate) fn encode(meta: &Meta) -> Result<Vec<u8>, MetaFault> {
    let mut bytes = vec![BINCODE_2_STANDARD];
    bincode::serde::encode_into_std_write(meta, &mut bytes, config()).map_err(|error| MetaFault::Encode {
        cause: error.to_string(),
    })?;
    // The limit also covers what decoding allocates, which only decoding can tell.
    decode_bytes(&bytes)?;
    Ok(bytes)
}

/// The metadata in the bytes of its section.
///
/// Guarantee: [`encode`] gives the same bytes back.
///
/// # Errors
/// Any [`MetaFault`] but `Encode`.
pub(crate) fn decode(bytes: &[u8]) -> Result<Meta, MetaFault> {
    let meta = decode_bytes(bytes)?;
    if encode(&meta)? == bytes {
        Ok(meta)
    } else {
        Err(MetaFault::NotCanonical)
    }
}

fn decode_bytes(bytes: &[u8]) -> Result<Meta, MetaFault> {
    let (codec, payload) = bytes.split_first().ok_or(MetaFault::Empty)?;
    if *codec != BINCODE_2_STANDARD {
        return Err(MetaFault::Codec { found: *codec });
    }
    if bytes.len() > META_LIMIT {
        return Err(MetaFault::TooLarge {
            found: bytes.len() as u64,
        });
    }
    let (meta, consumed) = bincode::serde::decode_from_slice(payload, config()).map_err(|error| MetaFault::Decode {
        cause: error.to_string(),
    })?;
    if consumed != payload.len() {
        return Err(MetaFault::Unconsumed {
            consumed: consumed + 1,
            found: bytes.len(),
        });
    }
    Ok(meta)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meta() -> Meta {
        Meta {
            part_names: vec!["body".into()],
            options: vec![("a".into(), "b".into())],
            ..Meta::default()
        }
    }

    #[test]
    fn what_is_encoded_decodes_to_the_same() {
        assert_eq!(decode(&encode(&meta()).unwrap()), Ok(meta()));
    }

    #[test]
    fn every_prefix_and_one_more_byte_are_refused() {
        let mut bytes = encode(&meta()).unwrap();
        for len in 0..bytes.len() {
            assert!(decode(&bytes[..len]).is_err(), "{len}");
        }
        bytes.push(0);
        assert!(matches!(decode(&bytes), Err(MetaFault::Unconsumed { .. })));
    }

    #[test]
    fn another_codec_is_named() {
        let mut bytes = encode(&meta()).unwrap();
        bytes[0] = 9;
        assert_eq!(decode(&bytes), Err(MetaFault::Codec { found: 9 }));
    }

    #[test]
    fn a_hostile_length_is_refused_before_it_is_allocated() {
        let bytes = [BINCODE_2_STANDARD, 253, 255, 255, 255, 255, 255, 255, 255, 127];
        assert!(matches!(decode(&bytes), Err(MetaFault::Decode { .. })));
    }

    #[test]
    fn a_longer_spelling_of_the_same_length_is_refused() {
        let mut bytes = encode(&Meta::default()).unwrap();
        assert_eq!(bytes[1], 0);
        bytes.splice(1..2, [251, 0, 0]);
        assert_eq!(decode(&bytes), Err(MetaFault::NotCanonical));
    }

    #[test]
    fn more_than_the_limit_is_not_written() {
        let meta = Meta {
            generator: "x".repeat(META_LIMIT),
            ..Meta::default()
        };
        assert!(encode(&meta).is_err());
    }
}
