// The mesh readers under libFuzzer: whatever the bytes, a mesh whose triangles have their points, or one line that
// begins with the file. The first byte selects the format. tools/dev/fuzz builds and runs it.

#include <unistd.h>
#include <vtkObject.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "setup/mesh_io.hpp"
#include "setup/setup_error.hpp"

namespace {

const std::array<std::string, 3> endings{"obj", "ply", "stl"};

[[noreturn]] void wrong(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

void write(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

std::string file_of(std::uint8_t kind) {
  static const std::string name =
      std::filesystem::temp_directory_path() / ("mesh_fuzz_" + std::to_string(getpid()) + ".");
  return name + endings[kind % endings.size()];
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

void must_read(const std::filesystem::path& seed) {
  std::ifstream file(seed, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const std::string path = file_of(static_cast<std::uint8_t>(bytes[0]));
  write(path, bytes.substr(1));
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
    for (const char* name : {"obj", "ply", "ply_binary", "stl", "stl_binary"}) must_read(folder / name);
    break;
  }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string path = file_of(data[0]);
  write(path, std::string(reinterpret_cast<const char*>(data + 1), size - 1));
  try {
    check(drench::read_mesh(path, "", {.texture = true, .groups = path.ends_with("obj")}));
    const drench::MeshSequenceReader sequence(path, "");
    check(sequence.read(path));
  } catch (const drench::SetupError& error) {
    const std::string line = error.what();
    if (!line.starts_with("mesh file '" + path) || line.find('\n') != line.npos)
      wrong("not one line of its file: " + line);
  }
  std::filesystem::remove(path);
  return 0;
}
