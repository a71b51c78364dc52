#include "setup/point_cache.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <system_error>

#include "scene/motion.hpp"
#include "scene/scalars.hpp"
#include "setup/setup_error.hpp"

namespace drench {
namespace {

constexpr std::string_view pc2_magic("POINTCACHE2\0", 12);
constexpr std::size_t number_bytes = 4, pc2_header = 32, mdd_header = 8;
constexpr double least_interval = 1e-6;  // s

std::uint32_t bits_at(const std::string& bytes, std::size_t at, bool big_endian) {
  std::uint32_t bits = 0;
  for (std::size_t b = 0; b < number_bytes; ++b)
    bits = bits << 8 | static_cast<unsigned char>(bytes[at + (big_endian ? b : number_bytes - 1 - b)]);
  return bits;
}

std::int64_t integer_at(const std::string& bytes, std::size_t at, bool big_endian) {
  return static_cast<std::int32_t>(bits_at(bytes, at, big_endian));
}

double float_at(const std::string& bytes, std::size_t at, bool big_endian) {
  return static_cast<double>(std::bit_cast<float>(bits_at(bytes, at, big_endian)));
}

}  // namespace

PointCache::PointCache(const std::string& path, double fps)
    : path_(path), file_(path, std::ios::binary | std::ios::ate), big_endian_(point_cache_ending(path) == ".mdd") {
  std::error_code error;
  if (std::filesystem::is_directory(path, error) || !file_) fail("it cannot be opened");
  size_ = static_cast<std::uint64_t>(file_.tellg());
  const bool has_magic = size_ >= pc2_magic.size() && bytes(0, pc2_magic.size()) == pc2_magic;
  if (!big_endian_ && !has_magic)
    fail("it does not begin with POINTCACHE2; allowed: a .pc2 file, for example from Blender or 3ds Max");
  if (big_endian_ && has_magic) fail("it is a .pc2 file; allowed: the ending .pc2");
  if (const std::size_t header = big_endian_ ? mdd_header : pc2_header; size_ < header)
    fail(fmt::format("it ends within its header, after {} bytes; export it again", size_));
  if (big_endian_)
    read_mdd_header();
  else
    read_pc2_header(fps);
  check_times();
  leave_out_before_start();
}

void PointCache::fail(const std::string& why) const {
  throw SetupError(fmt::format("point cache '{}': {}", path_, why));
}

std::string PointCache::bytes(std::uint64_t from, std::size_t count) {
  std::string text(count, '\0');
  file_.seekg(static_cast<std::streamoff>(from));
  file_.read(text.data(), static_cast<std::streamsize>(count));
  if (!file_) fail("it cannot be read");
  return text;
}

void PointCache::read_pc2_header(double fps) {
  const std::string header = bytes(0, pc2_header);
  if (const std::int64_t version = integer_at(header, 12, false); version != 1)
    fail(fmt::format("it has version {} of the format; allowed: 1", version));
  const std::int64_t samples = integer_at(header, 28, false);
  check_size(samples, integer_at(header, 16, false), pc2_header, 0);
  const double start = float_at(header, 20, false), rate = float_at(header, 24, false);
  if (!std::isfinite(start) || !std::isfinite(rate) || !(rate > 0))
    fail(
        fmt::format("its header gives the start frame {} and {} frames per sample; allowed: finite numbers, the "
                    "second above 0",
                    start, rate));
  for (std::int64_t k = 0; k < samples; ++k) times_.push_back((start + static_cast<double>(k) * rate) / fps);
  first_byte_ = pc2_header;
}

void PointCache::read_mdd_header() {
  const std::string header = bytes(0, mdd_header);
  const std::int64_t samples = integer_at(header, 0, true);
  check_size(samples, integer_at(header, number_bytes, true), mdd_header, number_bytes);
  const std::size_t length = static_cast<std::size_t>(samples) * number_bytes;
  const std::string times = bytes(mdd_header, length);
  for (std::size_t at = 0; at < length; at += number_bytes) times_.push_back(float_at(times, at, true));
  first_byte_ = mdd_header + length;
}

/// Nothing is allocated by the numbers of a header before this. `per_sample`: bytes beside its points.
void PointCache::check_size(std::int64_t samples, std::int64_t points, std::uint64_t header, std::uint64_t per_sample) {
  if (samples < 1 || points < 1)
    fail(fmt::format("its header gives {} samples of {} points; allowed: at least 1 of each, so export it again",
                     samples, points));
  const std::uint64_t fitting = (size_ - header) / (per_sample + 3 * number_bytes * static_cast<std::uint64_t>(points));
  if (fitting < static_cast<std::uint64_t>(samples))
    fail(
        fmt::format("its header gives {} samples of {} points, but its size allows {}: it is incomplete or not a {} "
                    "file; export it again",
                    samples, points, fitting, big_endian_ ? ".mdd" : ".pc2"));
  if (samples > static_cast<std::int64_t>(most_files))
    fail(fmt::format("it has {} samples; allowed: at most {}", samples, most_files));
  points_ = static_cast<std::size_t>(points);
}

void PointCache::check_times() const {
  for (std::size_t k = 0; k < times_.size(); ++k) {
    if (!std::isfinite(times_[k])) fail(fmt::format("the time of sample {} is not finite; export it again", k + 1));
    if (k > 0 && !(times_[k] >= times_[k - 1] + least_interval))
      fail(fmt::format("samples {} and {} are at {} s and {} s; allowed: times that rise by at least {} s", k, k + 1,
                       times_[k - 1], times_[k], least_interval));
  }
  if (times_.back() < 0)
    fail(fmt::format("its last sample is at {} s; allowed: samples at 0 s or later, where the scene starts",
                     times_.back()));
}

void PointCache::leave_out_before_start() {
  if (times_.front() >= 0) return;
  first_ = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), 0.0) - times_.begin()) - 1;
  if (times_[first_] < 0) part_ = -times_[first_] / (times_[first_ + 1] - times_[first_]);
  times_.erase(times_.begin(), times_.begin() + static_cast<std::ptrdiff_t>(first_));
  times_.front() = 0;
}

std::vector<Vec3> PointCache::sample_of_file(std::size_t number) {
  const std::size_t length = 3 * number_bytes * points_;
  const std::string text = bytes(first_byte_ + std::uint64_t{number} * length, length);
  std::vector<Vec3> points(points_);
  for (std::size_t p = 0; p < points_; ++p)
    for (std::size_t a = 0; a < 3; ++a) {
      points[p][a] = float_at(text, number_bytes * (3 * p + a), big_endian_);
      if (!std::isfinite(points[p][a]))
        fail(fmt::format("point {} of sample {} is not finite; export it again", p, number + 1));
    }
  return points;
}

std::vector<Vec3> PointCache::sample(std::size_t k) {
  std::vector<Vec3> points = sample_of_file(first_ + k);
  if (k > 0 || part_ == 0) return points;
  const std::vector<Vec3> next = sample_of_file(first_ + 1);
  for (std::size_t p = 0; p < points.size(); ++p)
    for (std::size_t a = 0; a < 3; ++a) points[p][a] += part_ * (next[p][a] - points[p][a]);
  return points;
}

std::string PointCache::label(std::size_t k) const {
  return fmt::format("sample {} of {}", first_ + k + 1, std::filesystem::path(path_).filename().string());
}

}  // namespace drench
