#pragma once
// Compressed files, by zlib.

#include <string>

namespace drench {

/// The bytes of a file, unpacked where it is gzipped. SetupError: it cannot be opened or unpacked.
std::string unzipped_file(const std::string& path);

/// The `size` bytes of an archive's entry that were deflated to `packed`. Empty: they cannot be unpacked.
std::string inflated(const std::string& packed, std::size_t size);
/// The checksum of an archive's entry (CRC-32).
unsigned long checksum_of(const std::string& bytes);

}  // namespace drench
