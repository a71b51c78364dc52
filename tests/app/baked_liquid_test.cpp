// Liquid whose motion is finished: its particles follow a sequence of files, and it wets cloth.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <string>

#include "drench/drench.hpp"
#include "pipeline/pipeline.hpp"
#include "run_program.hpp"
#include "setup/build.hpp"
#include "setup/setup_error.hpp"
#include "state/mass_budget.hpp"

namespace drench::test {
namespace {

constexpr int side = 5, particles = side * side, files = 9;
constexpr double fps = 50;  // a file each five steps

/// Where particle k is in a file: a layer that falls through the sheet, askew.
Vec3 falling(int k, int file) {
  const double t = file / fps;
  return {0.02 * (k % side) - 0.04 + 0.1 * t, 0.041 - 0.5 * t, 0.02 * (k / side) - 0.04};
}

/// A .ply file; without ids its particles have a velocity. `least`: the first particle that it has.
void write_frame(const std::filesystem::path& path, int file, bool ids, int least = 0) {
  std::ofstream out(path);
  out << "ply\nformat ascii 1.0\nelement vertex " << particles - least
      << "\nproperty float x\nproperty float y\nproperty float z\n"
      << (ids ? "property int id\n" : "property float vx\nproperty float vy\nproperty float vz\n") << "end_header\n";
  for (int k = particles - 1; k >= least; --k) {  // in no order of ids
    const Vec3 x = falling(k, file);
    out << x[0] << ' ' << x[1] << ' ' << x[2] << (ids ? " " + std::to_string(3 * k + 1) : " 0.1 -0.5 0") << '\n';
  }
}

class BakedLiquidFiles : public ::testing::Test {
 protected:
  std::string scene(const std::string& more = "") const {
    std::string text = R"(drench: 1
time: {step: 0.004, end: 0.2}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid:
  spacing: 0.02
  sources:
    - particles: {sequence: FILES, fps: 50}
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    pin: [{edges: true}]
    porous: {absorption: 0.05}
)";
    const std::string files = "FILES, fps: 50}";
    return text.replace(text.find(files), files.size(),
                        '"' + (folder_.path() / "liquid_{}.ply").string() + "\", fps: 50}" + more);
  }
  void write(bool ids, int first = 0) const {
    for (int k = first; k < files; ++k) write_frame(folder_.path() / ("liquid_" + std::to_string(k) + ".ply"), k, ids);
  }
  TempFolder folder_;
};

using Masses = std::map<std::int64_t, Quanta>;
Masses masses(const HostState& s) {
  Masses of;
  for (std::size_t i = 0; i < s.fluid_id.size(); ++i) of[s.fluid_id[i]] = s.fluid_mass[i];
  return of;
}

TEST_F(BakedLiquidFiles, move_the_particles_and_cloth_takes_from_each) {
  write(true);
  Simulation run(parse_scene(scene(), "baked.yaml"));
  for (const auto& [stage, time] : run.stage_milliseconds())
    for (const char* moving : {"divergence", "forces", "pressure", "emission"}) EXPECT_NE(stage, moving);
  const Quanta budget = liquid_budget(run.state());
  Masses before = masses(run.state());
  ASSERT_EQ(before.size(), std::size_t{particles});
  while (run.time() < 0.2 - 1e-9) {
    run.step();
    const HostState s = run.state();
    EXPECT_EQ(liquid_budget(s), budget);
    const Masses now = masses(s);
    for (const auto& [id, mass] : now) {
      ASSERT_TRUE(before.contains(id)) << "what cloth has taken whole comes again";
      EXPECT_LE(mass, before[id]);
    }
    before = now;
    // Between files too, for these fall evenly; in the last file they rest.
    const double at = std::min(run.time(), (files - 1) / fps) * fps;
    for (std::size_t i = 0; i < s.fluid_id.size(); ++i) {
      const int k = static_cast<int>(s.fluid_id[i] / 3);
      for (std::size_t a = 0; a < 3; ++a) {
        const double from = falling(k, 0)[a], by = falling(k, 1)[a] - from;
        EXPECT_NEAR(s.fluid_position[i][a], from + at * by, 2e-6);
      }
    }
  }
  const HostState end = run.state();
  EXPECT_EQ(end.drained, 0);
  EXPECT_EQ(end.supplied, 0);
  EXPECT_GT(sum_of(end.node_liquid), budget / 20);
  Quanta left = 0;
  for (const auto& [id, mass] : before) left += mass;
  EXPECT_EQ(left + sum_of(end.node_liquid), budget) << "what the particles lack is what the cloth has";
}

TEST_F(BakedLiquidFiles, agree_with_the_reference) {
  write(true);
  drench::Setup setup = build(parse_scene(scene(), "baked.yaml"));
  std::vector<HostState> ends;
  for (const auto& backend : {make_reference_backend(setup.model), make_kokkos_backend(setup.model)}) {
    Pipeline pipeline(setup.model, *backend, setup.state);
    while (pipeline.time() < 0.12 - 1e-9) pipeline.step(0.12 - pipeline.time());
    ends.push_back(backend->download());
  }
  const double full = static_cast<double>(quanta_per_particle);
  const Masses one = masses(ends[0]), other = masses(ends[1]);
  ASSERT_EQ(one.size(), other.size());
  for (const auto& [id, mass] : one) EXPECT_NEAR(double(mass) / full, double(other.at(id)) / full, 1e-4) << id;
  for (std::size_t n = 0; n < ends[0].node_liquid.size(); ++n)
    EXPECT_NEAR(double(ends[0].node_liquid[n]) / full, double(ends[1].node_liquid[n]) / full, 1e-4) << n;
}

TEST_F(BakedLiquidFiles, without_ids_bring_full_particles) {
  write(false);
  Simulation run(parse_scene(scene(), "baked.yaml"));
  const HostState start = run.state();
  const Quanta budget = liquid_budget(start);
  run.run_until(0.116);
  const Quanta before = sum_of(run.state().fluid_mass);
  run.run_until(0.124);  // past the file of 0.12 s
  const HostState s = run.state();
  EXPECT_EQ(liquid_budget(s), budget);
  EXPECT_EQ(s.fluid_count(), particles);
  EXPECT_EQ(s.supplied - s.drained, sum_of(s.fluid_mass) + sum_of(s.node_liquid) - sum_of(start.fluid_mass));
  EXPECT_GT(s.supplied, 0);
  const double all = static_cast<double>(particles * quanta_per_particle);
  EXPECT_LT(static_cast<double>(before), 0.998 * all);
  EXPECT_GT(static_cast<double>(sum_of(s.fluid_mass)), 0.999 * all) << "full again but for the last step";
}

/// In the middle between two files, and at a file.
TEST_F(BakedLiquidFiles, go_on_from_a_checkpoint_with_the_same_bits) {
  for (const bool ids : {true, false}) {
    write(ids);
    Simulation whole(parse_scene(scene(), "baked.yaml"));
    whole.run_until(0.16);
    for (const double at : {0.068, 0.08}) {
      Simulation first(parse_scene(scene(), "baked.yaml"));
      first.run_until(at);
      const std::string checkpoint = (folder_.path() / "here.checkpoint").string();
      first.save_checkpoint(checkpoint);
      Simulation second(parse_scene(scene(), "baked.yaml"));
      second.resume(checkpoint);
      second.run_until(0.16);
      const HostState a = whole.state(), b = second.state();
      EXPECT_EQ(a.fluid_id, b.fluid_id) << at;
      EXPECT_EQ(a.fluid_mass, b.fluid_mass) << at;
      EXPECT_EQ(a.fluid_position, b.fluid_position) << at;
      EXPECT_EQ(a.node_liquid, b.node_liquid) << at;
    }
  }
}

TEST_F(BakedLiquidFiles, do_not_go_on_with_other_files) {
  write(true);
  const std::string checkpoint = (folder_.path() / "here.checkpoint").string();
  Simulation first(parse_scene(scene(), "baked.yaml"));
  first.run_until(0.06);
  first.save_checkpoint(checkpoint);
  const std::filesystem::path last = folder_.path() / ("liquid_" + std::to_string(files - 1) + ".ply");
  const auto resumed = [&]() -> std::string {
    try {
      Simulation(parse_scene(scene(), "baked.yaml")).resume(checkpoint);
      return "";
    } catch (const std::exception& e) {
      return e.what();
    }
  };
  EXPECT_EQ(resumed(), "");
  const std::string expected = "is of another scene: its meshes or the files of a sequence have changed";
  write_frame(last, files - 1, true, 1);
  EXPECT_NE(resumed().find(expected), std::string::npos) << resumed();
  std::filesystem::remove(last);
  EXPECT_NE(resumed().find(expected), std::string::npos) << resumed();
}

TEST_F(BakedLiquidFiles, may_bring_new_particles_and_take_old_ones_away) {
  for (int k = 0; k < files; ++k)
    write_frame(folder_.path() / ("liquid_" + std::to_string(k) + ".ply"), k, true, k < 2 ? 10 : k < 4 ? 0 : 5);
  Simulation run(parse_scene(scene(), "baked.yaml"));
  const Quanta budget = liquid_budget(run.state()), full = quanta_per_particle;
  EXPECT_EQ(run.state().fluid_count(), particles - 10);
  run.run_until(0.044);
  HostState s = run.state();
  EXPECT_EQ(s.supplied, 10 * full);
  EXPECT_EQ(liquid_budget(s), budget);
  run.run_until(0.084);
  s = run.state();
  EXPECT_GT(s.drained, 0);
  EXPECT_LE(s.drained, 5 * full);
  EXPECT_EQ(liquid_budget(s), budget);
  for (const std::int64_t id : s.fluid_id) EXPECT_GE(id, 3 * 5 + 1);
}

TEST_F(BakedLiquidFiles, are_refused_where_ids_are_wrong) {
  const auto message = [&](const std::string& text) -> std::string {
    try {
      Simulation run(parse_scene(text, "baked.yaml"));
      run.run_until(0.1);
    } catch (const std::exception& e) {
      return e.what();
    }
    return "";
  };
  write(true);
  write_frame(folder_.path() / "liquid_3.ply", 3, false);
  EXPECT_NE(message(scene()).find("liquid_3.ply': it has no ids, unlike the first file with"), std::string::npos)
      << message(scene());
  std::ofstream(folder_.path() / "liquid_2.ply")
      << "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
         "property int id\nend_header\n0 0.1 0 4\n0 0.2 0 4\n";
  EXPECT_NE(message(scene()).find("liquid_2.ply': two particles have the id 4"), std::string::npos) << message(scene());
  write(true);
  EXPECT_NE(message(scene("\n    - block: {min: [0.1, 0.1, 0.1], max: [0.2, 0.2, 0.2]}"))
                .find("allowed: a sequence as the only source"),
            std::string::npos);
}

TEST_F(BakedLiquidFiles, name_a_broken_file_and_their_key) {
  write(true);
  std::ofstream(folder_.path() / "liquid_3.ply")
      << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
         "property int id\nend_header\n0 nan 0 4\n";
  write_text(folder_.path() / "scene.yaml", scene());
  const Outcome o = run_drench(folder_.path(), {"run", "scene.yaml", "--quiet"});
  EXPECT_EQ(o.code, 2);
  EXPECT_EQ(o.err.find("scene.yaml:7:29: fluid.sources.0.particles.sequence: particle file '"), 0U) << o.err;
  EXPECT_NE(o.err.find("liquid_3.ply': numbers of particle 0 are not finite"), std::string::npos) << o.err;
  const char* open_box = "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nv 0 0 0.2\nf 1 2 3\nf 1 2 4\n";
  const char* tetrahedron = "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nv 0 0 0.2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  for (int k = 0; k < 3; ++k)
    write_text(folder_.path() / ("s_" + std::to_string(k) + ".obj"), k == 1 ? open_box : tetrahedron);
  std::string text = scene();
  const auto from = text.find("particles:"), to = text.find(", fps");
  text.replace(from, to - from, "mesh: {sequence: \"s_*.obj\"");
  write_text(folder_.path() / "scene.yaml", text);
  const Outcome other = run_drench(folder_.path(), {"run", "scene.yaml", "--quiet", "-o", "other"});
  EXPECT_EQ(other.code, 2);
  EXPECT_EQ(other.err.find("scene.yaml:7:24: fluid.sources.0.mesh.sequence: "), 0U) << other.err;
  EXPECT_NE(other.err.find("s_1.obj"), std::string::npos) << other.err;
}

/// Emitters begin later, and what has flowed away is not there any more.
TEST_F(BakedLiquidFiles, may_be_empty) {
  write(true);
  for (const int empty : {0, 1, 5, 6, 8})
    write_frame(folder_.path() / ("liquid_" + std::to_string(empty) + ".ply"), empty, empty % 2 == 0, particles);
  Simulation run(parse_scene(scene(), "baked.yaml"));
  EXPECT_EQ(run.state().fluid_count(), 0);
  const Quanta budget = liquid_budget(run.state()), all = particles * quanta_per_particle;
  for (const auto& [file, count] : std::map<int, int>{{1, 0}, {2, particles}, {5, 0}, {6, 0}, {7, particles}, {8, 0}}) {
    run.run_until(file / fps);
    const HostState s = run.state();
    EXPECT_EQ(s.fluid_count(), count) << file;
    EXPECT_EQ(liquid_budget(s), budget) << file;
  }
  const HostState end = run.state();
  EXPECT_EQ(end.supplied, 2 * all);
  EXPECT_EQ(end.drained, 2 * all - sum_of(end.node_liquid)) << "what comes and what goes are counted apart";
}

/// The surface of liquid: a box that falls and grows; each file is filled anew.
TEST_F(BakedLiquidFiles, may_be_surfaces) {
  for (int k = 0; k < files; ++k) {
    std::ofstream out(folder_.path() / ("surface_" + std::to_string(k) + ".obj"));
    const double y = 0.05 - 0.01 * k, half = 0.04 + 0.002 * k;
    for (int corner = 0; corner < 8; ++corner)
      out << "v " << (corner & 1 ? half : -half) << ' ' << y + (corner & 2 ? 0.08 : 0) << ' '
          << (corner & 4 ? half : -half) << '\n';
    out << "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
  }
  std::string text = R"(drench: 1
time: {step: 0.004, end: 0.2}
domain: {min: [-0.5, -0.5, -0.5], max: [0.5, 0.5, 0.5]}
fluid: {spacing: 0.02, sources: [{mesh: {sequence: FILES, fps: 50}}]}
cloth:
  - mesh: {grid: {size: [0.2, 0.2], nodes: [9, 9]}}
    pin: [{edges: true}]
    porous: {absorption: 0.05}
)";
  text.replace(text.find("FILES"), 5, '"' + (folder_.path() / "surface_{}.obj").string() + '"');
  const Scene of_surfaces = parse_scene(text, "baked.yaml");
  EXPECT_EQ(parse_scene(to_yaml(of_surfaces), "baked.yaml").fluid, of_surfaces.fluid);
  Simulation run(of_surfaces);
  const Quanta budget = liquid_budget(run.state());
  std::ofstream(folder_.path() / "surface_3.obj") << "# no liquid\n";
  for (const int file : {1, 5, 8}) {
    run.run_until(file / fps + 0.004);
    const HostState s = run.state();
    EXPECT_EQ(liquid_budget(s), budget);
    const double half = 0.04 + 0.002 * file, volume = 4 * half * half * 0.08;
    // Less what the cloth has taken in the one step since.
    const double liquid = static_cast<double>(sum_of(s.fluid_mass)) * run.quantum();
    EXPECT_LE(liquid, 1.001 * 1000 * volume) << file;
    EXPECT_GE(liquid, 0.95 * 1000 * volume) << file;
    double least = 1;
    for (const Vec3& x : s.fluid_position) least = std::min(least, x[1]);
    EXPECT_NEAR(least, 0.05 - 0.01 * file + 0.01, 0.004) << file;
  }
  EXPECT_GT(sum_of(run.state().node_liquid), 0);
}

}  // namespace
}  // namespace drench::test
