// The readers of meshes and point caches under libFuzzer: whatever the bytes, a mesh whose triangles have their points,
// or one line that begins with the file. The first byte selects the format. tools/dev/fuzz builds and runs it.

#include <unistd.h>
#include <vtkObject.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "setup/mesh_io.hpp"
#include "setup/point_cache.hpp"
#include "setup/setup_error.hpp"

namespace {

const std::array<std::string, 5> endings{"obj", "ply", "stl", "pc2", "mdd"};

[[noreturn]] void wrong(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

void write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::size_t kind_of(std::uint8_t first) { return first % endings.size(); }

std::string file_of(std::uint8_t first) {
  static const std::string name =
      std::filesystem::temp_directory_path() / ("mesh_fuzz_" + std::to_string(getpid()) + ".");
  return name + endings[kind_of(first)];
}

void check(const drench::SurfaceMesh& mesh) {
  for (const auto& triangle : mesh.triangles)
    for (const drench::Index point : triangle)
      if (point < 0 || static_cast<std::size_t>(point) >= mesh.points.size()) wrong("a triangle of no point");
  for (const auto& [name, triangles] : mesh.groups)
    for (const drench::Index t : triangles)
      if (t < 0 || static_cast<std::size_t>(t) >= mesh.triangles.size()) wrong("a group of no triangle");
  if (!mesh.texture.empty() && mesh.texture.size() != mesh.triangles.size()) wrong("texture of other triangles");
}

void check_cache(const std::string& path) {
  drench::PointCache cache(path, 24);
  const std::vector<double>& times = cache.times();
  if (times.size() != cache.samples() || times.empty() || times.front() < 0) wrong("times of other samples");
  for (std::size_t k = 0; k < cache.samples(); ++k) {
    if (k > 0 && !(times[k] > times[k - 1])) wrong("times do not rise");
    const std::vector<drench::Vec3> points = cache.sample(k);
    if (points.size() != cache.points()) wrong("another number of points");
    for (const drench::Vec3& x : points)
      if (!std::isfinite(x[0] + x[1] + x[2])) wrong("a point that is not finite");
  }
}

void must_read(const std::filesystem::path& seed) {
  std::ifstream file(seed, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const std::string path = file_of(static_cast<std::uint8_t>(bytes[0]));
  write(path, bytes.substr(1));
  if (kind_of(static_cast<std::uint8_t>(bytes[0])) > 2)
    check_cache(path);
  else
    check(drench::read_mesh(path, ""));
}

}  // namespace

/// Puts a file of each format into the first folder of the command line, beside what the fuzzer found before.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  vtkObject::GlobalWarningDisplayOff();
  const std::string points = "0 0 0\n1 0 0\n0 0 1\n1 0 1\n";
  const std::string ply =
      " 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 1; i < *argc; ++i) {
    const std::filesystem::path folder = (*argv)[i];
    if (!std::filesystem::is_directory(folder)) continue;
    write(folder / "obj", std::string(1, '\0') +
                              "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 1 0\n"
                              "g a b\nusemtl c\nf 1/1/1 2/2/1 3/3/1\no q\nf 2//1 4//1 3//1\nf -1 -2 -3 \\\n -4\n");
    write(folder / "ply", "\1ply\nformat ascii" + ply + points + "4 0 1 3 2\n");
    std::string numbers(48, '\0');
    numbers[14] = numbers[34] = '\x80';  // 1 and 1, little-endian
    numbers[15] = numbers[35] = '\x3f';
    write(folder / "ply_binary", "\1ply\nformat binary_little_endian" + ply + numbers + '\3' +
                                     std::string{0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0});
    write(folder / "stl",
          "\2solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
          "endfacet\nendsolid a\n");
    write(folder / "stl_binary",
          '\2' + std::string(80, '\0') + '\1' + std::string(3, '\0') + numbers + std::string(2, '\0'));
    // Two samples of a point, at frames 0 and 1, and at 0 and 1 s.
    const std::string little_one("\1\0\0\0", 4), little_two("\2\0\0\0", 4), big_one("\0\0\0\1", 4),
        big_two("\0\0\0\2", 4), zero(4, '\0'), samples(24, '\0');
    write(folder / "pc2", '\3' + std::string("POINTCACHE2\0", 12) + little_one + little_one + zero +
                              std::string("\0\0\x80\x3f", 4) + little_two + samples);
    write(folder / "mdd", '\4' + big_two + big_one + zero + std::string("\x3f\x80\0\0", 4) + samples);
    for (const char* name : {"obj", "ply", "ply_binary", "stl", "stl_binary", "pc2", "mdd"}) must_read(folder / name);
    break;
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string path = file_of(data[0]);
  write(path, std::string(reinterpret_cast<const char*>(data + 1), size - 1));
  try {
    if (kind_of(data[0]) > 2) {
      check_cache(path);
    } else {
      check(drench::read_mesh(path, "", {.texture = true, .groups = path.ends_with("obj")}));
      const drench::MeshSequenceReader sequence({{path, path}, 24}, "", "");
      check(sequence.read(1));
    }
  } catch (const drench::SetupError& error) {
    const std::string line = error.what();
    const std::string kind = kind_of(data[0]) > 2 ? "point cache '" : "mesh file '";
    if (!line.starts_with(kind + path) || line.find('\n') != line.npos) wrong("not one line of its file: " + line);
  }
  std::filesystem::remove(path);
  return 0;
}
