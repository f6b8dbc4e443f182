//! Decompression of one chunk, with its checksum.

use std::io::Read;

use mcap::McapError;
use mcap::records::ChunkHeader;

/// Largest chunk (compressed or not) and largest other record that is read (bytes).
pub(super) const MAX_CHUNK_BYTES: u64 = 256 << 20;

/// Decompresses what there is of a chunk whose end is missing.
pub(super) fn unpack_as_far(compression: &[u8], data: &[u8], unpacked: &mut Vec<u8>) {
    let decoder: Box<dyn Read> = match compression {
        b"" => Box::new(data),
        b"lz4" => match lz4::Decoder::new(data) {
            Ok(decoder) => Box::new(decoder),
            Err(_) => return,
        },
        b"zstd" => match zstd::Decoder::new(data) {
            Ok(decoder) => Box::new(decoder),
            Err(_) => return,
        },
        _ => return,
    };
    // What was decompressed before an error stays.
    let _ = decoder.take(MAX_CHUNK_BYTES).read_to_end(unpacked);
}

/// Decompresses a chunk into `unpacked` and verifies its size and checksum.
///
/// # Errors
/// If the chunk is damaged, too large or compressed in another way than LZ4 or Zstandard.
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
    // One byte more than the header claims is enough to detect a wrong claim.
    let limit = size + 1;
    match header.compression.as_str() {
        "" => data.take(limit).read_to_end(unpacked)?,
        "lz4" => lz4::Decoder::new(data)?.take(limit).read_to_end(unpacked)?,
        "zstd" => zstd::Decoder::new(data)?
            .take(limit)
            .read_to_end(unpacked)?,
        other => return Err(McapError::UnsupportedCompression(other.to_owned())),
    };
    if unpacked.len() as u64 != size {
        return Err(McapError::UnexpectedEoc);
    }
    let (saved, calculated) = (header.uncompressed_crc, crc32fast::hash(unpacked));
    if saved != 0 && saved != calculated {
        return Err(McapError::BadChunkCrc { saved, calculated });
    }
    Ok(())
}
