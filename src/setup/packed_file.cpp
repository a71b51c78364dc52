#include "setup/packed_file.hpp"

#include <zlib.h>

#include <memory>
#include <vector>

#include "setup/particle_files.hpp"

namespace drench {

std::string unzipped_file(const std::string& path) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
  if (!file) unreadable_particles(path, "it cannot be opened");
  std::string bytes;
  std::vector<char> part(1 << 20);
  int count = 0;
  while ((count = gzread(file.get(), part.data(), static_cast<unsigned>(part.size()))) > 0)
    bytes.append(part.data(), static_cast<std::size_t>(count));
  int error = Z_OK;
  gzerror(file.get(), &error);
  if (count < 0 || error != Z_OK) unreadable_particles(path, "it cannot be unpacked");
  return bytes;
}

unsigned long checksum_of(const std::string& bytes) {
  return crc32_z(crc32(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
}

std::string inflated(const std::string& packed, std::size_t size) {
  constexpr int raw = -MAX_WBITS;  // no header: the archive has its own
  z_stream stream{};
  if (inflateInit2(&stream, raw) != Z_OK) return {};
  std::string bytes(size, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(size);
  const int end = inflate(&stream, Z_FINISH);
  const bool whole = end == Z_STREAM_END && stream.total_out == size;
  inflateEnd(&stream);
  return whole ? bytes : std::string();
}

}  // namespace drench
