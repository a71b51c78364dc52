#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <string>

#include "setup/packed_file.hpp"
#include "setup/particle_files.hpp"

namespace drench {
namespace {

constexpr std::size_t number_bytes = 4;   // of each number of a point
constexpr std::size_t place_numbers = 4;  // x, y, z and w

/// Big-endian numbers, one after the other.
class BgeoCursor {
 public:
  BgeoCursor(const std::string& path, const std::string& bytes) : path_(path), bytes_(bytes) {}

  std::size_t left() const { return bytes_.size() - at_; }
  void skip(std::size_t length) {
    if (length > left())
      unreadable_particles(path_, fmt::format("it ends after {} bytes, before its header or points do", bytes_.size()));
    at_ += length;
  }
  std::string text(std::size_t length) {
    skip(length);
    return bytes_.substr(at_ - length, length);
  }
  std::uint32_t number(std::size_t bytes = number_bytes) {
    skip(bytes);
    std::uint32_t value = 0;
    for (std::size_t k = at_ - bytes; k < at_; ++k) value = value << 8 | static_cast<unsigned char>(bytes_[k]);
    return value;
  }

 private:
  const std::string& path_;
  const std::string& bytes_;
  std::size_t at_ = 0;
};

/// Where in a point's numbers the fields that drench reads begin.
struct BgeoLayout {
  std::size_t numbers = place_numbers;
  std::optional<std::size_t> velocity, mass, id;
};

void read_attribute(BgeoCursor& in, const std::string& path, BgeoLayout& layout) {
  const std::string name = in.text(in.number(2));
  const std::size_t size = in.number(2);
  const std::uint32_t type = in.number();
  const bool real = type == 0 || type == 5;  // numbers; a vector
  if (real || type == 1) {
    in.skip(number_bytes * size);  // defaults
  } else if (type == 4) {          // indices of texts
    for (std::uint32_t k = in.number(); k > 0; --k) in.skip(in.number(2));
  } else {
    unreadable_particles(path,
                         fmt::format("its attribute '{}' has type {}; types that are read: 0, 1, 4, 5", name, type));
  }
  if (real && size == 3 && (name == "v" || name == "velocity")) layout.velocity = layout.numbers;
  if (real && size == 1 && name == "mass") layout.mass = layout.numbers;
  if (type == 1 && size == 1 && name == "id") layout.id = layout.numbers;
  layout.numbers += size;
}

}  // namespace

ParticleFile read_bgeo_file(const std::string& path) {
  const std::string bytes = unzipped_file(path);
  BgeoCursor in(path, bytes);
  if (bytes.starts_with("\x7fNSJ"))
    unreadable_particles(path, "it has the format of Houdini 12 and newer; save it as .bhclassic or .ply");
  if (!bytes.starts_with("BgeoV")) unreadable_particles(path, "it is not a .bgeo file");
  in.skip(5);
  if (const std::uint32_t version = in.number(); version != 5)
    unreadable_particles(path, fmt::format("its version is {}; allowed: 5", version));
  std::array<std::uint32_t, 8> counts;  // points, primitives, two of groups, attributes of points, and three more
  for (std::uint32_t& count : counts) count = in.number();
  BgeoLayout layout;
  for (std::uint32_t k = 0; k < counts[4]; ++k) read_attribute(in, path, layout);
  ParticleFile file;
  const std::size_t points = counts[0];
  if (points > in.left() / (number_bytes * layout.numbers))
    unreadable_particles(path, fmt::format("it has {} points by its header, but ends before", points));
  for (std::size_t i = 0; i < points; ++i) {
    std::array<double, 3> place{}, velocity{};
    double mass = 0;
    std::int32_t id = 0;
    for (std::size_t k = 0; k < layout.numbers; ++k) {
      const std::uint32_t bits = in.number();
      const double value = double(std::bit_cast<float>(bits));
      if (k < 3) place[k] = value;
      if (layout.velocity && k >= *layout.velocity && k < *layout.velocity + 3) velocity[k - *layout.velocity] = value;
      if (k == layout.mass) mass = value;
      if (k == layout.id) id = std::bit_cast<std::int32_t>(bits);
    }
    file.position.push_back(place);
    if (layout.velocity) file.velocity.push_back(velocity);
    if (layout.mass) file.mass.push_back(mass);
    if (layout.id) file.id.push_back(id);
  }
  return file;
}

}  // namespace drench
