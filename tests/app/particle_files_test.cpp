// Particles from .bgeo and .npz files.

#include "setup/particle_files.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <string>

#include "mesh_folder.hpp"
#include "setup/packed_file.hpp"
#include "setup/setup_error.hpp"

namespace drench::test {
namespace {

using ParticleFiles = drench::testing::MeshFolder;

std::string big_endian(std::uint32_t value, int bytes = 4) {
  std::string text;
  for (int k = bytes; k-- > 0;) text += static_cast<char>(value >> 8 * k);
  return text;
}
std::string real(float value) { return big_endian(std::bit_cast<std::uint32_t>(value)); }
std::string named(const std::string& name) { return big_endian(static_cast<std::uint32_t>(name.size()), 2) + name; }

/// As partio writes it: two points with an index, a name each, a velocity and a mass.
std::string bgeo(std::uint32_t version = 5, std::uint32_t type_of_id = 1) {
  std::string text = "BgeoV" + big_endian(version) + big_endian(2);
  for (const std::uint32_t count : {0u, 0u, 0u, 4u, 0u, 0u, 0u}) text += big_endian(count);
  text += named("id") + big_endian(1, 2) + big_endian(type_of_id) + big_endian(0);
  text += named("group") + big_endian(1, 2) + big_endian(4) + big_endian(2) + named("water") + named("oil");
  text += named("v") + big_endian(3, 2) + big_endian(5) + big_endian(0) + big_endian(0) + big_endian(0);
  text += named("mass") + big_endian(1, 2) + big_endian(0) + big_endian(0);
  for (const float x : {0.5f, 2.0f})
    text += real(x) + real(0.25f) + real(-x) + real(1) + big_endian(7) + big_endian(1) + real(x) + real(3) + real(-4) +
            real(0.001f * x);
  return text;
}

/// Of numpy.savez_compressed(position=float32 (2, 3), velocity=float64 (2, 3) by columns, mass=float64 (2)).
std::string npz() {
  const std::string hex =
      "504b03042d000000080000002100e4c4d499ffffffffffffffff0c001400706f736974696f6e2e6e707901001000980000000000000059"
      "000000000000009bec17ea1b10c9c850c650ad9e925a9c5ca46ea5a06e9366a2aea3a09e965f54529498179f5f94920a12774bcc294e05"
      "8a17672416a402f91a463a0ac69a3a0ab50a64032e0606067b0686063b20de0f643b00111037380000504b03042d000000080000002100"
      "894556e9ffffffffffffffff0c00140076656c6f636974792e6e707901001000b00000000000000059000000000000009bec17ea1b10c9"
      "c850c650ad9e925a9c5ca46ea5a06e9366a1aea3a09e965f54529498179f5f94920a120f292a4d050a17672416a402b91a463a0ac69a3a"
      "0ab50ae4032e0630f8600fa1051c203403941681d21c505aca0100504b03042d000000080000002100586fc6c9ffffffffffffffff0800"
      "14006d6173732e6e707901001000900000000000000050000000000000009bec17ea1b10c9c850c650ad9e925a9c5ca46ea5a06e9366a1"
      "aea3a09e965f54529498179f5f94920a12774bcc294e058a17672416a402f91a463a9a3a0ab50a1400ae3f2b3f5ef24d0ab087d009f600"
      "504b01022d032d000000080000002100e4c4d49959000000980000000c0000000000000000000000800100000000706f736974696f6e2e"
      "6e7079504b01022d032d000000080000002100894556e959000000b00000000c000000000000000000000080019700000076656c6f6369"
      "74792e6e7079504b01022d032d000000080000002100586fc6c9500000009000000008000000000000000000000080012e0100006d6173"
      "732e6e7079504b05060000000003000300aa000000b80100000000";
  std::string text;
  for (std::size_t k = 0; k < hex.size(); k += 2) text += static_cast<char>(std::stoi(hex.substr(k, 2), nullptr, 16));
  return text;
}

TEST_F(ParticleFiles, reads_what_partio_writes) {
  const ParticleFile file = read_particle_file(write("points.bgeo", bgeo()));
  EXPECT_EQ(file.position, (std::vector<Vec3>{{0.5, 0.25, -0.5}, {2, 0.25, -2}}));
  EXPECT_EQ(file.velocity, (std::vector<Vec3>{{0.5, 3, -4}, {2, 3, -4}}));
  EXPECT_EQ(file.mass, (std::vector<double>{double(0.001f * 0.5f), double(0.001f * 2)}));
  EXPECT_EQ(file.id, (std::vector<std::int64_t>{7, 7}));
}

TEST_F(ParticleFiles, reads_what_numpy_packs) {
  const ParticleFile file = read_particle_file(write("points.npz", npz()));
  EXPECT_EQ(file.position, (std::vector<Vec3>{{0.5, 0.25, -1}, {2, 3, 4}}));
  EXPECT_EQ(file.velocity, (std::vector<Vec3>{{1, 2, 3}, {4, 5, 6.5}}));
  EXPECT_EQ(file.mass, (std::vector<double>{0.001, 0.002}));
}

TEST_F(ParticleFiles, refuses_what_it_cannot_read) {
  const auto refused = [&](const std::string& name, const std::string& text, const std::string& with) {
    try {
      read_particle_file(write(name, text));
      ADD_FAILURE() << with;
    } catch (const SetupError& e) {
      EXPECT_NE(std::string(e.what()).find(with), std::string::npos) << e.what();
    }
  };
  refused("a.bgeo", bgeo(6), "its version is 6; allowed: 5");
  refused("a.bgeo", bgeo(5, 2), "its attribute 'id' has type 2");
  refused("a.bgeo", "\x7fNSJb", "save it as .bhclassic or .ply");
  refused("a.bgeo", "v 0 0 0", "it is not a .bgeo file");
  refused("a.npz", "x = 1", "it is not an archive");
  std::string other = npz();
  other.replace(other.find("position"), 8, "distance");
  other.replace(other.rfind("position"), 8, "distance");
  refused("a.npz", other, "no array 'position'");
  const std::string name = (folder_ / "a.").string();
  refused("a.ply", "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\n", "particle file '" + name + "ply': ");
  const std::string vtu =
      R"(<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="1" NumberOfCells="0"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
1 2 3</DataArray></Points><Cells><DataArray type="Int64" Name="connectivity" format="ascii"/>
<DataArray type="Int64" Name="offsets" format="ascii"/><DataArray type="UInt8" Name="types" format="ascii"/></Cells>
</Piece></UnstructuredGrid></VTKFile>
)";
  EXPECT_EQ(read_particle_file(write("a.vtu", vtu)).position, (std::vector<Vec3>{{1, 2, 3}}));
  for (const std::size_t length : {vtu.find("NumberOfPoints"), vtu.find("<Cells>"), vtu.size() - 12})
    refused("a.vtu", vtu.substr(0, length), "particle file '" + name + "vtu': cannot be read: it is cut off");
}

/// Nothing that is cut off or changed is read as if it were whole, or beyond its end.
TEST_F(ParticleFiles, survives_broken_files) {
  for (const bool packed : {false, true}) {
    const std::string whole = packed ? npz() : bgeo(), name = packed ? "b.npz" : "b.bgeo";
    for (std::size_t length = 0; length < whole.size(); ++length)
      EXPECT_THROW(read_particle_file(write(name, whole.substr(0, length))), SetupError) << name << ' ' << length;
    for (std::size_t at = 0; at < whole.size(); ++at) {
      std::string changed = whole;
      changed[at] = static_cast<char>(~changed[at]);
      try {
        const ParticleFile file = read_particle_file(write(name, changed));
        EXPECT_LE(file.position.size(), 2u);
      } catch (const SetupError&) {
      }
    }
  }
}

}  // namespace
}  // namespace drench::test
