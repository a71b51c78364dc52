#pragma once
// Compressed files, by zlib.

#include <string>

namespace drench {

/// The bytes of a file, unpacked where it is gzipped. SetupError: it cannot be opened or unpacked.
std::string unzipped_file(const std::string& path);

/// The deflated bytes of an archive's entry as they were, `size` of them. Empty: they cannot be unpacked, or are
/// others.
std::string inflated(const std::string& packed, std::size_t size, unsigned long checksum);
/// The checksum of an archive's entry (CRC-32).
unsigned long checksum_of(const std::string& bytes);

}  // namespace drench
