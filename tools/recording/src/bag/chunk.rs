//! Unpacking of one chunk, its checksum compared.

use std::io::Read;

use mcap::McapError;
use mcap::records::ChunkHeader;

/// Largest chunk (bytes, packed or unpacked) and largest other record that is read.
pub(super) const LARGEST_CHUNK: u64 = 256 << 20;

/// Unpacks a chunk and compares its checksum.
pub(super) fn unpack(
    header: &ChunkHeader,
    data: &[u8],
    unpacked: &mut Vec<u8>,
) -> Result<(), McapError> {
    let size = header.uncompressed_size;
    if size > LARGEST_CHUNK {
        return Err(McapError::ChunkTooLarge(size));
    }
    unpacked.clear();
    // One byte more than promised is enough to see that the promise is wrong.
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
