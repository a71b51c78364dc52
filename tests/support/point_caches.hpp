#pragma once
// Point caches for tests, as other programs write them.

#include <bit>
#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "ball_mesh.hpp"
#include "base/eigen_vec.hpp"
#include "base/types.hpp"

namespace drench::test {

using Samples = std::vector<std::vector<Vec3>>;

inline std::string bytes_of(std::uint32_t bits, bool big_endian) {
  std::string text;
  for (int b = 0; b < 4; ++b) text += static_cast<char>(bits >> 8 * (big_endian ? 3 - b : b) & 255);
  return text;
}
inline std::string bytes_of(float x, bool big_endian) { return bytes_of(std::bit_cast<std::uint32_t>(x), big_endian); }

inline std::string bytes_of(const Samples& samples, bool big_endian) {
  std::string text;
  for (const std::vector<Vec3>& points : samples)
    for (const Vec3& x : points)
      for (const double c : x) text += bytes_of(static_cast<float>(c), big_endian);
  return text;
}

inline std::string pc2_header(std::uint32_t points, float start, float rate, std::uint32_t samples) {
  return std::string("POINTCACHE2\0", 12) + bytes_of(1U, false) + bytes_of(points, false) + bytes_of(start, false) +
         bytes_of(rate, false) + bytes_of(samples, false);
}

inline std::string pc2_of(const Samples& samples, float start = 0, float rate = 1) {
  return pc2_header(static_cast<std::uint32_t>(samples.front().size()), start, rate,
                    static_cast<std::uint32_t>(samples.size())) +
         bytes_of(samples, false);
}

inline std::string mdd_of(const Samples& samples, const std::vector<float>& times) {
  std::string text = bytes_of(static_cast<std::uint32_t>(samples.size()), true) +
                     bytes_of(static_cast<std::uint32_t>(samples.front().size()), true);
  for (const float t : times) text += bytes_of(t, true);
  return text + bytes_of(samples, true);
}

/// Coordinates in single precision, as point caches have them.
inline Samples rounded(Samples samples) {
  for (std::vector<Vec3>& points : samples)
    for (Vec3& x : points)
      for (double& c : x) c = static_cast<double>(static_cast<float>(c));
  return samples;
}

/// The keys of a mesh whose points place(k, point) moves, by an .mdd file with these times (s).
inline std::string write_mdd(const std::string& name, const TestMesh& mesh, const std::vector<float>& times,
                             const std::function<Eigen::Vector3d(int, const Eigen::Vector3d&)>& place) {
  const std::string first = fmt::format(fmt::runtime(write_shapes(name, 1, mesh, place)), 0),
                    cache = first.substr(0, first.rfind('/')) + "/points.mdd";
  Samples samples(times.size());
  for (std::size_t k = 0; k < samples.size(); ++k)
    for (const Eigen::Vector3d& x : mesh.points) samples[k].push_back(to_vec3(place(static_cast<int>(k), x)));
  std::ofstream(cache, std::ios::binary) << mdd_of(samples, times);
  return "file: \"" + first + "\", sequence: \"" + cache + "\"";
}

}  // namespace drench::test
