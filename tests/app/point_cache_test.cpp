// Point caches .pc2 and .mdd: what is read, what is wrong with a file, and runs that equal those of a sequence of
// files.

#include "setup/point_cache.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "drench/drench.hpp"
#include "mesh_folder.hpp"
#include "point_caches.hpp"
#include "same_state.hpp"
#include "setup/mesh_io.hpp"

namespace drench::testing {
namespace {

using test::bytes_of;
using test::mdd_of;
using test::pc2_header;
using test::pc2_of;
using test::Samples;

const Samples three{{{1, 2, 3}, {4, 5, 6}}, {{3, 2, 3}, {4, 7, 6}}, {{9, 2, 3}, {4, 5, 0.5}}};

class PointCaches : public MeshFolder {
 protected:
  std::string refusal(const std::string& name, const std::string& bytes, double fps = 24) const {
    const std::string path = write(name, bytes);
    const std::string line = refusal_of([&] {
      PointCache cache(path, fps);
      for (std::size_t k = 0; k < cache.samples(); ++k) (void)cache.sample(k);
    });
    EXPECT_TRUE(line.starts_with(": point cache '" + path + "': ")) << line;
    EXPECT_LT(line.size(), 400u);
    EXPECT_EQ(line.find('\n'), line.npos);
    return line.substr(std::min(line.size(), path.size() + 18));
  }
};

TEST_F(PointCaches, AreReadSampleBySample) {
  PointCache pc2(write("a.pc2", pc2_of(three, 6, 3)), 12), mdd(write("a.MDD", mdd_of(three, {0, 0.25F, 1})), 12);
  EXPECT_EQ(pc2.times(), (std::vector{0.5, 0.75, 1.0})) << "frames 6, 9 and 12";
  EXPECT_EQ(mdd.times(), (std::vector{0.0, 0.25, 1.0}));
  for (PointCache* cache : {&mdd, &pc2}) {
    EXPECT_EQ(cache->points(), 2u);
    ASSERT_EQ(cache->samples(), 3u);
    for (const std::size_t k : {2u, 0u, 1u}) EXPECT_EQ(cache->sample(k), three[k]);
  }
  EXPECT_EQ(pc2.label(2), "sample 3 of a.pc2");
}

TEST_F(PointCaches, BeginAtTheStartOfTheScene) {
  PointCache between(write("a.mdd", mdd_of(three, {-3, -1, 3})), 1);
  EXPECT_EQ(between.times(), (std::vector{0.0, 3.0}));
  EXPECT_EQ(between.sample(0), (std::vector<Vec3>{{4.5, 2, 3}, {4, 6.5, 4.625}}));
  EXPECT_EQ(between.sample(1), three[2]);
  EXPECT_EQ(between.label(1), "sample 3 of a.mdd");
  PointCache exact(write("a.pc2", pc2_of(three, -1, 1)), 24);
  EXPECT_EQ(exact.times(), (std::vector{0.0, 1 / 24.0}));
  EXPECT_EQ(exact.sample(0), three[1]);
  PointCache last(write("b.pc2", pc2_of(three, -2, 1)), 24);
  EXPECT_EQ(last.times(), std::vector{0.0});
  EXPECT_EQ(last.sample(0), three[2]);
  EXPECT_EQ(refusal("c.pc2", pc2_of(three, -3, 1), 4),
            "its last sample is at -0.25 s; allowed: samples at 0 s or later, where the scene starts");
}

TEST_F(PointCaches, BadOnesAreRefusedInOneLine) {
  const std::string good = pc2_of(three), good_mdd = mdd_of(three, {0, 1, 2});
  const auto begins = [](const std::string& text, const std::string& with) {
    EXPECT_TRUE(text.starts_with(with)) << text;
  };
  begins(refusal("a.pc2", ""), "it does not begin with POINTCACHE2; allowed: a .pc2 file");
  begins(refusal("a.pc2", good_mdd), "it does not begin with POINTCACHE2; allowed: a .pc2 file");
  begins(refusal("a.pc2", good.substr(0, 30)), "it ends within its header, after 30 bytes; export it again");
  begins(refusal("a.mdd", "1234567"), "it ends within its header, after 7 bytes; export it again");
  begins(refusal("a.mdd", good), "it is a .pc2 file; allowed: the ending .pc2");
  begins(refusal("a.pc2", good.substr(0, 12) + bytes_of(2U, false) + good.substr(16)),
         "it has version 2 of the format");
  const auto size = [](std::uint32_t points, std::uint32_t samples) { return pc2_header(points, 0, 1, samples); };
  begins(refusal("a.pc2", size(2, 0)), "its header gives 0 samples of 2 points; allowed: at least 1 of each");
  begins(refusal("a.pc2", size(0, 3)), "its header gives 3 samples of 0 points; allowed: at least 1 of each");
  begins(refusal("a.pc2", size(0xffffffff, 3)), "its header gives 3 samples of -1 points");
  begins(refusal("a.pc2", good.substr(0, good.size() - 1)),
         "its header gives 3 samples of 2 points, but its size allows 2: it is incomplete or not a .pc2 file");
  begins(refusal("a.pc2", size(0x7fffffff, 0x7fffffff) + std::string(100, 'x')),
         "its header gives 2147483647 samples of 2147483647 points, but its size allows 0");
  begins(refusal("a.mdd", std::string(64, '\x7f')), "its header gives 2139062143 samples of 2139062143 points");
  begins(refusal("a.mdd", good_mdd.substr(0, good_mdd.size() - 4)),
         "its header gives 3 samples of 2 points, but its size allows 2: it is incomplete or not a .mdd file");
  begins(refusal("a.pc2", size(1, 100001) + std::string(12 * 100001, '\0')), "it has 100001 samples; allowed: at most");
  using Numbers = std::vector<std::pair<float, float>>;
  for (const auto& [start, rate] : Numbers{{0.0F, 0.0F}, {0.0F, -1.0F}, {NAN, 1.0F}, {0.0F, INFINITY}})
    begins(refusal("a.pc2", pc2_of(three, start, rate)), "its header gives the start frame ");
  begins(refusal("a.pc2", pc2_of(three, 1e9F, 1e-9F)), "samples 1 and 2 are at ");
  begins(refusal("a.mdd", mdd_of(three, {0, 0.5F, 0.5F})),
         "samples 2 and 3 are at 0.5 s and 0.5 s; allowed: times that rise by at least 1e-06 s");
  begins(refusal("a.mdd", mdd_of(three, {0, 0.5F, 0.25F})), "samples 2 and 3 are at 0.5 s and 0.25 s");
  begins(refusal("a.mdd", mdd_of(three, {0, NAN, 1})), "the time of sample 2 is not finite; export it again");
  Samples bad = three;
  bad[1][1][2] = INFINITY;
  begins(refusal("a.pc2", pc2_of(bad)), "point 1 of sample 2 is not finite; export it again");
  begins(refusal("a.mdd", mdd_of(bad, {0, 1, 2})), "point 1 of sample 2 is not finite; export it again");
}

/// Points without a face keep their numbers, and those at one place stay apart.
TEST_F(PointCaches, NumberThePointsOfTheFile) {
  const std::string obj = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 8 8 8\nv 0 0 1\nv 1 0 0\nv 1 0 1\nv 0 0 1\nf 2 3 5\nf 6 7 8\n";
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n9 9 9\n0 0 0\n1 0 0\n8 8 8\n0 0 1\n1 0 0\n1 0 1\n0 0 1\n"
      "3 1 2 4\n3 5 6 7\n";
  Samples samples(2);
  for (int k = 0; k < 2; ++k)
    for (int p = 0; p < 8; ++p) samples[static_cast<std::size_t>(k)].push_back({1.0 * p, 10.0 * k, 1.0 * p * p});
  const std::string cache = write("a.pc2", pc2_of(samples));
  for (const std::string& file : {write("a.obj", obj), write("a.ply", ply)}) {
    const MeshSequenceReader reader({{cache}, 24}, file, "");
    ASSERT_EQ(reader.size(), 2u);
    for (std::size_t k = 0; k < 2; ++k) {
      const SurfaceMesh mesh = reader.read(k);
      EXPECT_EQ(mesh.triangles, read_mesh(file, "").triangles);
      EXPECT_EQ(mesh.points, (std::vector<Vec3>{samples[k][1], samples[k][2], samples[k][4], samples[k][5],
                                                samples[k][6], samples[k][7]}));
    }
  }
  EXPECT_EQ(
      refusal_of([&] {
        MeshSequenceReader({{write("b.pc2", pc2_of(three))}, 24}, write("a.obj", obj), "");
      }),
      fmt::format(": point cache '{0}/b.pc2': it has 2 points, but mesh file '{0}/a.obj' has 8; allowed: the cache "
                  "and the mesh of one object",
                  folder_.string()));
  const std::string stl = write("a.stl",
                                "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                                "endloop\nendfacet\nendsolid a\n");
  EXPECT_NE(refusal_of([&] {
              MeshSequenceReader({{cache}, 24}, stl, "");
            }).find("does not number its points"),
            std::string::npos);
}

constexpr double rate = 64;  // 1/s: whole numbers over it are exact in single precision too
constexpr int files = 9;

/// The same motion as files a_0.obj, …, as a.pc2 and as a.mdd, and keys of a mesh for each.
struct Motion {
  std::vector<std::string> keys;
  std::string first;
};
Motion written(const std::filesystem::path& folder, const std::string& name, Samples samples,
               const std::string& faces) {
  samples = test::rounded(std::move(samples));
  std::vector<float> times;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    std::string text;
    for (const Vec3& x : samples[k]) text += fmt::format("v {:.17g} {:.17g} {:.17g}\n", x[0], x[1], x[2]);
    test::write_text(folder / fmt::format("{}_{}.obj", name, k), text + faces);
    times.push_back(static_cast<float>(static_cast<double>(k) / rate));
  }
  const std::string path = (folder / name).string(), first = path + "_0.obj";
  test::write_text(path + ".pc2", pc2_of(samples));
  test::write_text(path + ".mdd", mdd_of(samples, times));
  return {{fmt::format("sequence: \"{}_*.obj\", fps: {}", path, rate),
           fmt::format("file: {}, sequence: {}.pc2, fps: {}", first, path, rate),
           fmt::format("file: {}, sequence: {}.mdd", first, path)},
          first};
}

/// A box whose corners are where `place` puts them.
Samples box(Vec3 (*place)(double, const Vec3&)) {
  Samples samples(files);
  for (int k = 0; k < files; ++k)
    for (int c = 0; c < 8; ++c)
      samples[static_cast<std::size_t>(k)].push_back(
          place(k / rate, {c & 1 ? 0.05 : -0.05, c & 2 ? 0.02 : -0.02, c & 4 ? 0.05 : -0.05}));
  return samples;
}
constexpr const char* box_faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";

Vec3 turning(double t, const Vec3& x) {
  const double a = 5 * t;
  return {std::cos(a) * x[0] - std::sin(a) * x[2], x[1] + 0.3 * t, std::sin(a) * x[0] + std::cos(a) * x[2] + t * t};
}
Vec3 bending(double t, const Vec3& x) {
  return {x[0] * (1 + t) - 0.1, x[1] + 2 * t * x[0], x[2] - 3 * t * x[1] - 0.03};
}
Vec3 opening(double t, const Vec3& x) { return {0.4 * x[0], 0.2 + 0.1 * t, 0.4 * x[2] * (1 + 3 * t)}; }

void expect_same_runs(const std::vector<std::string>& scenes, double end) {
  std::vector<HostState> states;
  for (const std::string& text : scenes) {
    Simulation run(parse_scene(text, "cache.yaml"));
    while (run.time() < end - 1e-9) run.step();
    states.push_back(run.state());
  }
  for (std::size_t k = 1; k < states.size(); ++k) test::expect_same(states[0], states[k]);
}

/// Coordinates and times are exact in all three, so that the runs are equal bit for bit.
TEST_F(PointCaches, MoveBodiesAndEmittersAsFilesDo) {
  const Motion rigid = written(folder_, "turning", box(turning), box_faces),
               soft = written(folder_, "bending", box(bending), box_faces),
               mouth = written(folder_, "opening", box(opening), "f 1 2 6 5\n");
  std::vector<std::string> scenes;
  for (std::size_t k = 0; k < 3; ++k)
    scenes.push_back(fmt::format(R"(drench: 1
time: {{step: 0.004, end: 1}}
domain: {{min: [-0.4, -0.3, -0.4], max: [0.4, 0.4, 0.4]}}
fluid:
  spacing: 0.02
  sources:
    - block: {{min: [-0.08, 0.04, -0.06], max: [0.08, 0.1, 0.06]}}
    - mesh_jet: {{{}, speed: 1, direction: [0, -1, 0]}}
bodies:
  - mesh: {{{}, position: [0.08, 0, 0]}}
  - mesh: {{{}}}
)",
                                 mouth.keys[k], rigid.keys[k], soft.keys[k]));
  expect_same_runs(scenes, 0.1);
  for (const std::string& scene : scenes) {
    const Scene loaded = parse_scene(scene, "cache.yaml");
    EXPECT_TRUE(parse_scene(to_yaml(loaded), "cache.yaml") == loaded) << to_yaml(loaded);
  }
}

constexpr int side = 7;

Samples swaying_sheet() {
  Samples samples(files);
  for (int k = 0; k < files; ++k)
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < side; ++j) {
        const double t = k / rate, x = 0.2 * i / (side - 1) - 0.1, z = 0.2 * j / (side - 1) - 0.1;
        samples[static_cast<std::size_t>(k)].push_back(
            {x + 0.02 * std::sin(10 * t), 0.01 * (std::sin(20 * t + 15 * x) - std::sin(15 * x)), z});
      }
  return samples;
}

std::string sheet_faces() {
  std::string text;
  for (int i = 0; i + 1 < side; ++i)
    for (int j = 0; j + 1 < side; ++j) {
      const int a = i * side + j + 1;
      text += fmt::format("f {} {} {} {}\n", a, a + 1, a + side + 1, a + side);
    }
  return text;
}

std::string baked_scene(const std::string& first, const std::string& sequence) {
  return fmt::format(R"(drench: 1
time: {{step: 0.004, end: 1}}
domain: {{min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}}
fluid:
  spacing: 0.02
  sources:
    - block: {{min: [-0.06, 0.03, -0.06], max: [0.06, 0.09, 0.06]}}
cloth:
  - mesh: {{file: {}}}
    clean: off
    pin: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, {}}}]
    porous: {{absorption: 0.05}}
)",
                     first, sequence);
}

TEST_F(PointCaches, MoveClothAsFilesDo) {
  const Motion sheet = written(folder_, "sheet", swaying_sheet(), sheet_faces());
  std::vector<std::string> scenes;
  for (const std::string& keys : sheet.keys)
    scenes.push_back(baked_scene(sheet.first, keys.substr(keys.find("sequence:"))));
  expect_same_runs(scenes, 0.15);
}

/// A cache that has changed, in a point, a time or the start frame, is another motion.
TEST_F(PointCaches, ThatHaveChangedDoNotContinueARun) {
  const Samples sheet = test::rounded(swaying_sheet()), soft = test::rounded(box(bending)),
                turning_box = test::rounded(box(turning)), faces = test::rounded(box(opening));
  const Motion cloth = written(folder_, "sheet", sheet, sheet_faces()),
               body = written(folder_, "soft", soft, box_faces),
               rigid = written(folder_, "rigid", turning_box, box_faces),
               mouth = written(folder_, "mouth", faces, "f 1 2 6 5\n");
  const std::string bodies =
      "drench: 1\ntime: {step: 0.004, end: 1}\ndomain: {min: [-0.4, -0.3, -0.4], max: [0.4, 0.4, 0.4]}\n"
      "fluid:\n  spacing: 0.02\n  sources:\n    - block: {min: [-0.08, 0.1, -0.06], max: [0.08, 0.16, 0.06]}\n";
  const auto check = [&](const std::string& text, const std::string& name, const Samples& samples) {
    const Scene scene = parse_scene(text, "cache.yaml");
    const std::string checkpoint = (folder_ / "here.checkpoint").string();
    Simulation(scene).save_checkpoint(checkpoint);
    EXPECT_TRUE(Simulation(scene).resume(checkpoint).empty());
    Samples other = samples;
    other[4][1][1] += 1e-3;
    for (const std::string& bytes : {pc2_of(other), pc2_of(samples, 0, 1.5F), pc2_of(samples, 1, 1)}) {
      write(name, bytes);
      try {
        Simulation(scene).resume(checkpoint);
        ADD_FAILURE() << name << ": another motion";
      } catch (const std::exception& e) {
        EXPECT_NE(std::string(e.what()).find("the files of a sequence have changed"), std::string::npos) << e.what();
      }
    }
  };
  check(baked_scene(cloth.first, cloth.keys[1].substr(cloth.keys[1].find("sequence:"))), "sheet.pc2", sheet);
  check(bodies + "bodies: [{mesh: {" + body.keys[1] + "}}]\n", "soft.pc2", soft);
  check(bodies + "bodies: [{mesh: {" + rigid.keys[1] + "}}]\n", "rigid.pc2", turning_box);
  check(bodies + "    - mesh_jet: {" + mouth.keys[1] + ", speed: 1}\n", "mouth.pc2", faces);
}

}  // namespace
}  // namespace drench::testing
