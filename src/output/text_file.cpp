#include "output/text_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace drench {

namespace fs = std::filesystem;

fs::path temporary_name(const fs::path& path) {
  return path.parent_path() / ("." + path.filename().string() + ".part");
}

void rename_into_place(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (!error) return;
  std::error_code ignored;
  fs::remove(from, ignored);
  throw std::runtime_error(fmt::format("{}: cannot be written: {}", to.string(), error.message()));
}

void write_atomically(const fs::path& path, const std::string& text) {
  const fs::path temporary = temporary_name(path);
  {
    errno = 0;
    std::ofstream out(temporary, std::ios::binary | std::ios::trunc);
    out << text;
    out.flush();
    if (!out) {
      const std::string why = errno != 0 ? std::strerror(errno) : "the disk may be full";
      std::error_code ignored;
      fs::remove(temporary, ignored);
      throw std::runtime_error(fmt::format("{}: cannot be written: {}", path.string(), why));
    }
  }
  rename_into_place(temporary, path);
}

void sync_to_disk(const fs::path& path) {
  const bool folder = path.empty() || fs::is_directory(path);
  const int file = open(path.empty() ? "." : path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = file >= 0 && fsync(file) == 0;
  const int why = errno;
  if (file >= 0) close(file);
  if (!synced && !folder)
    throw std::runtime_error(fmt::format("{}: cannot be written: {}", path.string(), std::strerror(why)));
}

}  // namespace drench
