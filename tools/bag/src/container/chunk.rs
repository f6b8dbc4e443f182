//! Decompression of one chunk, with its checksum.

use std::io::{self, Read};

use mcap::McapError;
use mcap::records::ChunkHeader;

/// Largest chunk (compressed or not) and largest other record that is read (bytes).
pub(super) const MAX_CHUNK_BYTES: u64 = 256 << 20;

/// A chunk that claims to be so many times as long as its compressed data gets no memory in advance.
const MOST_RATIO: u64 = 1000;

/// Decompresses `data`, by the name that a container gives to the compression.
///
/// # Errors
/// If the compression is none of them, or the data do not begin like it.
pub(super) fn decoder<'a>(compression: &[u8], data: &'a [u8]) -> io::Result<Box<dyn Read + 'a>> {
    Ok(match compression {
        b"" | b"none" => Box::new(data),
        b"lz4" => Box::new(lz4::Decoder::new(data)?),
        b"zstd" => Box::new(zstd::Decoder::new(data)?),
        b"bz2" => Box::new(bzip2::read::BzDecoder::new(data)),
        _ => return Err(io::ErrorKind::Unsupported.into()),
    })
}

/// Decompresses a chunk as far as it goes: after an error, `unpacked` has what stands before the damage.
///
/// # Errors
/// If the chunk is damaged, or compressed in an unknown way.
pub(super) fn unpack_as_far(
    compression: &[u8],
    data: &[u8],
    unpacked: &mut Vec<u8>,
) -> io::Result<()> {
    let decoder = decoder(compression, data)?;
    decoder.take(MAX_CHUNK_BYTES).read_to_end(unpacked)?;
    Ok(())
}

/// Decompresses a chunk into `unpacked` and verifies its size and checksum.
///
/// # Errors
/// If the chunk is damaged, too large or compressed in an unknown way.
pub(super) fn unpack(
    header: &ChunkHeader,
    data: &[u8],
    unpacked: &mut Vec<u8>,
) -> Result<(), McapError> {
    let size = header.uncompressed_size;
    if size > MAX_CHUNK_BYTES {
        return Err(McapError::ChunkTooLarge(size));
    }
    unpacked.clear();
    if header.compression == "zstd" && data.len() as u64 >= size / MOST_RATIO {
        // In one piece, without a window of its own.
        unpacked.reserve(usize::try_from(size).unwrap_or(usize::MAX));
        zstd::bulk::Decompressor::new()?.decompress_to_buffer(data, unpacked)?;
    } else {
        // One byte more than the header claims is enough to detect a wrong claim.
        let limit = size + 1;
        let decoder = decoder(header.compression.as_bytes(), data);
        let unsupported = |_| McapError::UnsupportedCompression(header.compression.clone());
        decoder
            .map_err(unsupported)?
            .take(limit)
            .read_to_end(unpacked)?;
    }
    if unpacked.len() as u64 != size {
        return Err(McapError::UnexpectedEoc);
    }
    let (saved, calculated) = (header.uncompressed_crc, crc32fast::hash(unpacked));
    if saved != 0 && saved != calculated {
        return Err(McapError::BadChunkCrc { saved, calculated });
    }
    Ok(())
}
