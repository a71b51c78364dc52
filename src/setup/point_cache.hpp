#pragma once
// Point caches: where the points of a mesh are at many times, in a file .pc2 or .mdd.

#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace drench {

/// A file .pc2 (little-endian; Autodesk 3ds Max SDK, PC2 file format) or .mdd (big-endian; Newtek LightWave), by its
/// ending. Samples are in single precision. What lies before 0 s is left out: the first sample is then that of 0 s,
/// between two of the file.
class PointCache {
 public:
  /// Reads all but the samples. A .pc2 file counts in frames, of which `fps` make a second; an .mdd file has times.
  /// SetupError: not such a file, one that is shorter than its header requires, no samples or points, times that do
  /// not rise or that end before 0 s.
  PointCache(const std::string& path, double fps);

  std::size_t points() const { return points_; }
  std::size_t samples() const { return times_.size(); }
  /// s, of the samples; they rise, from 0 or later.
  const std::vector<double>& times() const { return times_; }
  /// The points of sample k, in the file's unit. SetupError: one is not finite.
  std::vector<Vec3> sample(std::size_t k);
  /// "sample 3 of walk.pc2": its number in the file, from 1.
  std::string label(std::size_t k) const;

 private:
  [[noreturn]] void fail(const std::string& why) const;
  std::string bytes(std::uint64_t from, std::size_t count);
  void read_pc2_header(double fps);
  void read_mdd_header();
  void check_size(std::int64_t samples, std::int64_t points, std::uint64_t header, std::uint64_t per_sample);
  void check_times() const;
  void leave_out_before_start();
  std::vector<Vec3> sample_of_file(std::size_t number);

  std::string path_;
  std::ifstream file_;
  bool big_endian_ = false;
  std::uint64_t size_ = 0, first_byte_ = 0;  // of the file; of the samples
  std::size_t points_ = 0, first_ = 0;       // first_: sample of the file
  double part_ = 0;                          // 1, of the way from there to the next: where the first one is
  std::vector<double> times_;
};

}  // namespace drench
