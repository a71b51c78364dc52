#include <fmt/format.h>

#include <bit>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "setup/packed_file.hpp"
#include "setup/particle_files.hpp"

namespace drench {
namespace {

static_assert(std::endian::native == std::endian::little);

/// What a member of the archive holds: rows of numbers.
struct NpyArray {
  std::size_t rows = 0, columns = 1;
  std::vector<double> values;  // row by row
};

/// A little-endian number.
std::size_t little_endian(const std::string& bytes, std::size_t at, std::size_t length) {
  std::size_t value = 0;
  for (std::size_t k = length; k-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

template <class Number>
double number_at(const char* from) {
  Number value;
  std::memcpy(&value, from, sizeof(value));
  return double(value);
}

/// Reads .npz: a .zip of one .npy per array.
class NpzReader {
 public:
  explicit NpzReader(const std::string& path) : path_(path), bytes_(unzipped_file(path)) { list_members(); }

  /// Whole numbers, one a row; none if there is no such array of whole numbers.
  std::vector<std::int64_t> ids(const std::string& name) const {
    const auto member = members_.find(name + ".npy");
    if (member == members_.end()) return {};
    const std::string bytes = content(member->second), type = value_of(bytes.substr(0, 1000), "descr");
    if (type != "'<i8'" && type != "'<u8'" && type != "'<i4'" && type != "'<u4'") return {};
    const NpyArray found = parsed(name, bytes, true);
    if (found.columns != 1) return {};
    std::vector<std::int64_t> numbers;
    for (const double value : found.values) numbers.push_back(id_of(value));
    return numbers;
  }
  /// An array of so many columns; without rows if there is none of that name.
  NpyArray array(const std::string& name, std::size_t columns) const {
    const auto member = members_.find(name + ".npy");
    if (member == members_.end()) return {};
    NpyArray found = parsed(name, content(member->second));
    if (found.columns != columns)
      refuse(fmt::format("its array '{}' has {} columns; allowed: {}", name, found.columns, columns));
    return found;
  }
  [[noreturn]] void refuse(const std::string& why) const { unreadable_particles(path_, why); }

 private:
  struct Member {
    std::size_t at = 0, packed = 0, size = 0;  // of its header; bytes
    unsigned method = 0;                       // 0: as they are; 8: deflated
    unsigned long checksum = 0;
  };

  std::size_t number(std::size_t at, std::size_t length) const {
    if (at > bytes_.size() || length > bytes_.size() - at) refuse("it ends too early");
    return little_endian(bytes_, at, length);
  }
  /// The list of members stands at the end of the archive.
  void list_members() {
    constexpr std::size_t length = 22;  // of the record at the end, without a comment
    const std::size_t end = bytes_.rfind("PK\5\6");
    if (!bytes_.starts_with("PK") || end == std::string::npos || bytes_.size() - end < length)
      refuse("it is not an archive of NumPy's savez");
    std::size_t at = number(end + 16, 4);
    for (std::size_t k = number(end + 10, 2); k > 0; --k) {
      if (number(at, 4) != 0x02014b50) refuse("its list of arrays is broken");
      const std::size_t name = number(at + 28, 2);
      const Member member{number(at + 42, 4), number(at + 20, 4), number(at + 24, 4),
                          static_cast<unsigned>(number(at + 10, 2)), number(at + 16, 4)};
      number(at + 46, name);
      members_[bytes_.substr(at + 46, name)] = member;
      at += 46 + name + number(at + 30, 2) + number(at + 32, 2);
    }
  }
  std::string content(const Member& m) const {
    constexpr std::size_t none = 0xffffffff;  // as the list says it of 4 GB and more
    if (m.packed >= none || m.size >= none || m.at >= none) refuse("it has arrays of 4 GB or more");
    const std::size_t begin = m.at + 30 + number(m.at + 26, 2) + number(m.at + 28, 2);
    if (begin > bytes_.size() || m.packed > bytes_.size() - begin) refuse("it ends too early");
    const std::string packed = bytes_.substr(begin, m.packed);
    // What deflate packs shrinks to a thousandth at best.
    const bool sound = m.method == 8 ? m.size / 1100 <= m.packed : m.method == 0 && m.size == m.packed;
    std::string whole;
    if (sound) whole = m.method == 8 ? inflated(packed, m.size) : packed;
    if (whole.empty() || checksum_of(whole) != m.checksum) refuse("one of its arrays cannot be unpacked");
    return whole;
  }
  /// The number or the text behind a key of the array's header, a Python dictionary.
  static std::string value_of(const std::string& header, const std::string& key) {
    const std::size_t found = header.find("'" + key + "':");
    if (found == std::string::npos) return {};
    const std::size_t begin = header.find_first_not_of(' ', found + key.size() + 3);
    if (begin == std::string::npos) return {};
    const std::size_t end = header[begin] == '(' ? header.find(')', begin) : header.find_first_of(",}", begin);
    return end == std::string::npos ? std::string() : header.substr(begin, end - begin);
  }
  /// Of real numbers, or of `whole` ones.
  NpyArray parsed(const std::string& name, const std::string& bytes, bool whole = false) const {
    const auto wrong = [&](const std::string& why) { refuse(fmt::format("its array '{}' {}", name, why)); };
    if (!bytes.starts_with("\x93NUMPY") || bytes.size() < 12) wrong("is not an array of NumPy");
    const std::size_t length_bytes = bytes[6] == 1 ? 2 : 4;
    const std::size_t header_length = little_endian(bytes, 8, length_bytes);
    const std::size_t begin = 8 + length_bytes + header_length;
    if (begin > bytes.size()) wrong("ends within its header");
    const std::string header = bytes.substr(8 + length_bytes, header_length), type = value_of(header, "descr");
    if (!whole && type != "'<f4'" && type != "'<f8'")
      wrong(fmt::format("has the type {}; allowed: float32, float64", type));
    const std::size_t width = type[3] == '8' ? 8 : 4;
    const auto number = [&](const char* from) {
      if (type == "'<u4'") return number_at<std::uint32_t>(from);
      if (whole) return width == 8 ? number_at<std::int64_t>(from) : number_at<std::int32_t>(from);
      return width == 8 ? number_at<double>(from) : number_at<float>(from);
    };
    NpyArray array;
    const std::string shape = value_of(header, "shape");
    unsigned long long rows = 0, columns = 1;
    const int sides = std::sscanf(shape.c_str(), "(%llu, %llu", &rows, &columns);
    if (sides < 1 || shape.find(',') != shape.rfind(',') || columns < 1 || columns > 3)
      wrong(fmt::format("has the shape {}); allowed: (N, 3), of masses (N)", shape));
    array.rows = rows;
    array.columns = columns;
    const std::size_t count = (bytes.size() - begin) / width;
    if (array.rows != count / array.columns || count % array.columns != 0) wrong("has another length than its shape");
    const bool by_columns = value_of(header, "fortran_order") == "True";
    for (std::size_t i = 0; i < array.rows; ++i)
      for (std::size_t c = 0; c < array.columns; ++c) {
        const char* const from =
            bytes.data() + begin + width * (by_columns ? c * array.rows + i : i * array.columns + c);
        array.values.push_back(number(from));
      }
    return array;
  }

  std::string path_, bytes_;
  std::map<std::string, Member> members_;
};

std::vector<Vec3> rows_of(const NpyArray& array) {
  std::vector<Vec3> rows;
  for (std::size_t i = 0; i < array.rows; ++i)
    rows.push_back({array.values[3 * i], array.values[3 * i + 1], array.values[3 * i + 2]});
  return rows;
}

}  // namespace

ParticleFile read_npz_file(const std::string& path) {
  const NpzReader archive(path);
  const NpyArray position = archive.array("position", 3);
  const NpyArray velocity = archive.array("velocity", 3), mass = archive.array("mass", 1);
  if (position.rows == 0) archive.refuse("it has no array 'position' of shape (N, 3) with particles in it");
  for (const NpyArray& other : {velocity, mass})
    if (other.rows != 0 && other.rows != position.rows)
      archive.refuse(
          fmt::format("its arrays have {} positions, but {} velocities or masses", position.rows, other.rows));
  ParticleFile file{rows_of(position), rows_of(velocity), mass.values};
  file.id = archive.ids("id");
  if (file.id.size() != position.rows) file.id.clear();
  return file;
}

}  // namespace drench
