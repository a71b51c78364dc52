// Stage diffusion: backend against reference from identical input.

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "app/run_program.hpp"
#include "pipeline/backend.hpp"
#include "pipeline/pipeline.hpp"
#include "precision.hpp"
#include "stage_compare.hpp"
#include "two_layers.hpp"

namespace drench::test {
namespace {

const double drift_bound = double_precision ? 1e-14 : 1e-8;

const char* const law[] = {"diffusion: linear",
                           "diffusion: degenerate",
                           "diffusion_exponent: 0.4",
                           "diffusion_exponent: 2",
                           "diffusion_exponent: 3.7",
                           "diffusion_exponent: 1.5, retention_exponent: 2.5",
                           "diffusion_exponent: 0.7, retention_exponent: 0.4"};

/// A strip of 0.4 m that lies folded once, its halves 1.5 mm apart; saturation falls along it.
std::string folded(const std::string& keys, const std::filesystem::path& folder) {
  constexpr int along = 41, across = 5;
  constexpr double step = 0.01, gap = 0.0015;
  std::string obj;
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < across; ++j) {
      const bool back = i > along / 2;
      const double x = back ? (along - 1 - i) * step + 0.3 * step : i * step;
      obj += "v " + std::to_string(x) + " " + std::to_string(back ? gap : 0) + " " + std::to_string(j * step) + "\n";
    }
  for (int i = 0; i + 1 < along; ++i)
    for (int j = 0; j + 1 < across; ++j) {
      const int a = 1 + i * across + j, b = a + 1, c = a + across, d = c + 1;
      obj += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\nf " + std::to_string(b) +
             " " + std::to_string(d) + " " + std::to_string(c) + "\n";
    }
  write_text(folder / "fold.obj", obj);
  return "drench: 1\ntime: {step: 0.01, end: 1}\ngravity: [0, 0, 0]\ncloth:\n  - mesh: {file: \"" +
         (folder / "fold.obj").string() + "\"}\n    dynamics: false\n    thickness: 0.0015\n    initial_saturation: [" +
         "{box: {min: [-1, -1, -1], max: [0.1, 0.0007, 1]}, value: 1}]\n    porous: {diffusivity: 1.0e-5" + keys +
         "}\n";
}

/// Every node gets a velocity of its own, m/s. Of cloth that does not move too: it must keep it.
void stir(const Model&, HostState& s) {
  for (std::size_t n = 0; n < s.node_velocity.size(); ++n) {
    const double k = double(n);
    s.node_velocity[n] = {std::sin(12.9898 * k + 1), 0.3 + std::sin(78.233 * k + 2), std::sin(37.719 * k + 3)};
  }
}

/// The scene with every cloth free to move.
std::string moving(std::string scene) {
  for (std::size_t at; (at = scene.find("    dynamics: false\n")) != std::string::npos;) scene.erase(at, 20);
  return scene;
}

/// Liquid on the nodes beyond the fold, quanta.
Quanta beyond_the_fold(const Model& model, const HostState& s) {
  Quanta sum = 0;
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
    if (model.mesh.rest_position[n][1] > 0.0007) sum += s.node_liquid[n];
  return sum;
}

}  // namespace

TEST(diffusion, agrees_with_the_reference) {
  for (const std::string kind : law) {
    SCOPED_TRACE(kind);
    compare_stage({.stage = Stage::diffusion,
                   .scene = with(wet_scene(), "diffusivity: 1.0e-3", "diffusivity: 1.0e-3, " + kind),
                   .prepare = stir,
                   .changes = "node_liquid node_velocity"});
  }
}

TEST(diffusion, with_hysteresis_agrees_with_the_reference) {
  // Nodes on all kinds of curves, and on both sides of where they turn.
  const auto scan = [](const Model& m, HostState& s) {
    stir(m, s);
    const std::array<double, 6> curve{0, 1, 0.6, -0.55, -0.9, -1}, away{0.1, 0.0005, 0.002, -0.002, -0.0005, 0};
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
      const double saturation = 0.55 * (1 + std::sin(12.9898 * double(n)));  // up to 1.1
      s.node_liquid[n] = std::llround(saturation * m.samples.node_capacity[n] / m.quantum);
      s.node_scanning[n] = curve[n % 6];
      s.node_extreme[n] = std::max(0.0, saturation + away[n / 6 % 6]);
    }
  };
  for (const std::string keys :
       {"diffusion: degenerate", "diffusion_exponent: 2.5, retention_exponent: 3",
        "diffusion: degenerate, film: 1.0e-4", "diffusion_exponent: 1.5, retention_exponent: 1.5, drainage_exponent: 4",
        "diffusion: degenerate, large_pores: 0.6, large_pore_height: 0.1",
        "diffusion_exponent: 3, retention_exponent: 2, drainage_exponent: 3.5, large_pores: 0.4, "
        "large_pore_height: 0.05"})
    compare_stage(
        {.stage = Stage::diffusion,
         .scene = with(wet_scene(), "diffusivity: 1.0e-3", "diffusivity: 1.0e-3, drainage_height: 0.5, " + keys),
         .prepare = scan,
         .changes = "node_liquid node_velocity node_scanning node_extreme"});
}

TEST(diffusion, through_pores_of_two_sizes_agrees_with_the_reference) {
  for (const std::string keys : {"diffusion: degenerate, large_pores: 0.6, large_pore_height: 0.1",
                                 "diffusion_exponent: 2.5, retention_exponent: 3, large_pores: 0.2, "
                                 "large_pore_height: 0.02",
                                 "diffusion_exponent: 1.5, retention_exponent: 1.2, large_pores: 0.9, "
                                 "large_pore_height: 0.06, film: 1.0e-4"})
    compare_stage({.stage = Stage::diffusion,
                   .scene = with(wet_scene(), "diffusivity: 1.0e-3", "diffusivity: 1.0e-3, " + keys),
                   .prepare = stir,
                   .changes = "node_liquid node_velocity"});
  const std::string one = two_layers("large_pores: 0.5, large_pore_height: 0.02, diffusion_exponent: 2");
  for (const std::string& scene :
       {one, with(one, "porous: {solid_fraction: 0.6, ",
                  "porous: {solid_fraction: 0.6, diffusion: degenerate, large_pores: 0.3, large_pore_height: 0.1, "
                  "drainage_height: 2, ")})
    compare_stage({.stage = Stage::diffusion, .scene = scene, .changes = "node_liquid"});
}

TEST(diffusion, through_pores_that_stretching_narrows_agrees_with_the_reference) {
  const auto stretch = [](const Model& m, HostState& s) {
    stir(m, s);
    for (std::size_t n = 0; n < s.node_position.size(); ++n) {
      Vec3& x = s.node_position[n];
      x = {1.2 * x[0] + 0.1 * std::sin(20 * x[2]), x[1], x[2] * (1 + 0.3 * std::sin(7 * x[0]))};
    }
  };
  for (const std::string keys : {"diffusion: degenerate, pore_narrowing: 1.5",
                                 "diffusion_exponent: 2, retention_exponent: 2, pore_narrowing: -3, large_pores: 0.5, "
                                 "large_pore_height: 0.1"})
    compare_stage({.stage = Stage::diffusion,
                   .scene = with(wet_scene(), "diffusivity: 1.0e-3", "diffusivity: 1.0e-3, " + keys),
                   .prepare = stretch,
                   .changes = "node_liquid node_velocity"});
}

TEST(diffusion, between_layers_with_hysteresis_agrees_with_the_reference) {
  const auto scan = [](const Model&, HostState& s) {
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n) s.node_scanning[n] = n % 2 == 0 ? 0.7 : -0.8;
  };
  const std::string one = two_layers("drainage_height: 0.25, diffusion_exponent: 2, retention_exponent: 1.5");
  for (const std::string& scene :
       {one, with(one, "porous: {solid_fraction: 0.6, ",
                  "porous: {solid_fraction: 0.6, diffusion: degenerate, drainage_height: 2, ")})
    compare_stage({.stage = Stage::diffusion, .scene = scene, .prepare = scan, .changes = "node_liquid"});
}

TEST(diffusion, agrees_where_nodes_are_full_or_empty) {
  // A steep saturation under a short capillary height: the limiters act at both ends.
  const auto chequered = [](const Model& model, HostState& s) {
    stir(model, s);
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
      const double full = 1.18 * model.samples.node_capacity[n] / model.quantum;
      s.node_liquid[n] = n % 3 == 0 ? 0 : static_cast<Quanta>(n % 3 == 1 ? full : 0.3 * full);
    }
  };
  for (const std::string kind : law) {
    SCOPED_TRACE(kind);
    compare_stage({.stage = Stage::diffusion,
                   .scene = with(with(wet_scene(), "diffusivity: 1.0e-3", "diffusivity: 1.0e-2, " + kind),
                                 "capillary_height: 0.3", "capillary_height: 0.01"),
                   .prepare = chequered,
                   .changes = "node_liquid node_velocity"});
  }
}

TEST(diffusion, reservoirs_are_filled_between_sub_steps) {
  const auto setup = setup_from(R"(drench: 1
time: {step: 0.02, end: 1}
cloth:
  - mesh: {grid: {size: [0.1, 0.2], nodes: [6, 11]}}
    dynamics: false
    hold_saturation: [{box: {min: [-1, -1, 0.09], max: [1, 1, 1]}, value: 1}]
    porous: {diffusivity: 1.0e-2}
)");
  std::vector<double> supplied;
  const std::vector<Stage> stages{Stage::porous_neighbors, Stage::diffusion};
  run_on_both(setup.model, setup.state, stages, {0, 0.0, 0.02}, [&](const Backend& backend, const StepReport& report) {
    EXPECT_GT(report.diffusion_substeps, 4);
    const HostState after = backend.download();
    Quanta gained = 0;
    for (std::size_t n = 0; n < after.node_liquid.size(); ++n)
      gained += after.node_liquid[n] - setup.state.node_liquid[n];
    EXPECT_EQ(after.supplied, gained);
    EXPECT_GT(after.supplied, 0);
    supplied.push_back(static_cast<double>(after.supplied));
  });
  EXPECT_NEAR(supplied[1], supplied[0], 1e-6 * supplied[0]);
}

// 10^11 sub-steps do not fit an int: they became one, which lost the ledger's mass.
TEST(diffusion, refuses_more_sub_steps_than_a_run_could_wait_for) {
  const auto setup = setup_from(R"(drench: 1
time: {step: 1, end: 2}
cloth:
  - mesh: {grid: {size: [1.0e-4, 1.0e-4], nodes: [11, 11]}}
    dynamics: false
    initial_saturation: [{box: {min: [-1, -1, -1], max: [0, 1, 1]}, value: 1}]
    porous: {diffusivity: 1}
)");
  for (const bool reference : {false, true}) {
    const auto backend = reference ? make_reference_backend(setup.model) : make_kokkos_backend(setup.model);
    StepReport report;
    backend->upload(setup.state);
    backend->run(Stage::porous_neighbors, {0, 0.0, 1.0}, report);
    try {
      backend->run(Stage::diffusion, {7, 0.0, 1.0}, report);
      ADD_FAILURE() << report.diffusion_substeps << " sub-steps";
    } catch (const RunFailure& e) {
      EXPECT_EQ(e.stage, Stage::diffusion);
      EXPECT_EQ(e.info.step, 7);
    }
  }
}

TEST(diffusion, between_layers_agrees_with_the_reference) {
  for (const std::string kind : law) {
    SCOPED_TRACE(kind);
    for (const int steps : {0, 20})
      compare_stage(
          {.stage = Stage::diffusion, .scene = two_layers(kind), .steps_before = steps, .changes = "node_liquid"});
  }
}

TEST(diffusion, of_fabric_far_above_what_it_holds_agrees_with_the_reference) {
  // Flows of more than 2^63 quanta in a step: their offers end at 2^56.
  compare_stage({.stage = Stage::diffusion,
                 .scene = two_layers("diffusion: linear, retention_exponent: 4"),
                 .steps_before = 0,
                 .prepare = [](const Model&, HostState& s) { s.node_liquid[13 * 4] *= 10'000; },
                 .changes = "node_liquid"});
}

TEST(diffusion, across_a_fold_agrees_with_the_reference) {
  const TempFolder folder;
  for (const std::string keys : {"", ", contact_wicking: true"}) {
    SCOPED_TRACE(keys);
    compare_stage(
        {.stage = Stage::diffusion, .scene = folded(keys, folder.path()), .steps_before = 3, .changes = "node_liquid"});
  }
}

TEST(diffusion, between_layers_takes_momentum_along_as_the_reference_does) {
  const TempFolder folder;
  const std::string layers = two_layers("diffusion: degenerate"),
                    fold = folded(", contact_wicking: true", folder.path());
  const std::string pin = "    pin: [{box: {min: [-1, -1, -1], max: [0, 1, 1]}}]\n    thickness: 0.002\n";
  const std::vector<std::pair<const char*, std::string>> cases = {
      {"both move", moving(layers)},
      {"the lower one moves", with(layers, "    dynamics: false\n", "")},
      {"half of the lower one is pinned", with(moving(layers), "    thickness: 0.002\n", pin)},
      {"a fold", moving(fold)}};
  for (const auto& [name, scene] : cases) {
    SCOPED_TRACE(name);
    for (const int steps : {0, 3})
      compare_stage({.stage = Stage::diffusion,
                     .scene = scene,
                     .steps_before = steps,
                     .prepare = stir,
                     .changes = "node_liquid node_velocity"});
  }
}

TEST(diffusion, keeps_the_sum_of_momentum) {
  // One sub-step or many, layers in contact, gravity along the cloth; all nodes free.
  const TempFolder folder;
  const std::string fold = moving(folded(", contact_wicking: true", folder.path()));
  for (const std::string& scene :
       {moving(two_layers("diffusion: linear")), fold, with(fold, "diffusivity: 1.0e-5", "diffusivity: 1.0e-2"),
        with(with(fold, "diffusivity: 1.0e-5", "diffusivity: 1.0e-2, capillary_height: 0.02"), "gravity: [0, 0, 0]",
             "gravity: [9.81, 0, 0]")}) {
    auto setup = setup_from(scene);
    stir(setup.model, setup.state);
    const auto backend = make_kokkos_backend(setup.model);
    StepReport report;
    backend->upload(setup.state);
    setup.state = backend->download();  // velocities as the backend has rounded them
    for (const Stage stage : {Stage::porous_neighbors, Stage::diffusion}) backend->run(stage, {0, 0.0, 0.01}, report);
    const HostState after = backend->download();
    double sizes = 0, moved = 0;
    Vec3 change{0, 0, 0};
    for (std::size_t n = 0; n < after.node_liquid.size(); ++n) {
      const auto mass = [&](const HostState& s) {
        return setup.model.mesh.solid_mass[n] + double(s.node_liquid[n]) * setup.model.quantum;
      };
      const Vec3 &u = setup.state.node_velocity[n], &v = after.node_velocity[n];
      for (std::size_t a = 0; a < 3; ++a) change[a] += mass(after) * v[a] - mass(setup.state) * u[a];
      sizes += mass(after) * std::hypot(v[0], v[1], v[2]);
      moved += std::fabs(mass(after) - mass(setup.state)) * std::hypot(v[0], v[1], v[2]);
    }
    const double drift = std::max({std::fabs(change[0]), std::fabs(change[1]), std::fabs(change[2])}) / sizes;
    std::printf("diffusion: %d sub-steps, drift %.1e, moved %.1e of Σm|v|\n", report.diffusion_substeps, drift,
                moved / sizes);
    EXPECT_GT(moved / sizes, 1e-4);
    EXPECT_LE(drift, drift_bound);
  }
}

TEST(diffusion, folds_pass_liquid_only_with_contact_wicking) {
  const TempFolder folder;
  for (const bool asked : {false, true}) {
    const auto setup = setup_from(folded(asked ? ", contact_wicking: true" : "", folder.path()));
    const auto backend = make_kokkos_backend(setup.model);
    StepReport report;
    backend->upload(setup.state);
    for (int n = 0; n < 20; ++n) {
      backend->run(Stage::porous_neighbors, {n, 0.0, 0.01}, report);
      backend->run(Stage::diffusion, {n, 0.0, 0.01}, report);
    }
    const Quanta passed = beyond_the_fold(setup.model, backend->download());
    // The wet end is 0.1 m away from the fold: within the fabric √(4 D t) = 3 mm.
    if (asked)
      EXPECT_GT(passed, 0);
    else
      EXPECT_EQ(passed, 0);
  }
}

namespace {

constexpr int side = 11;  // nodes along a side of the distorted sheet

/// A flat sheet in Wavefront's format whose inner nodes are far off their lattice, its diagonals chosen badly.
std::string distorted_sheet() {
  const auto noise = [](int n) { return std::sin(12.9898 * n + 1); };
  std::string obj;
  std::vector<std::array<double, 2>> at;
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) {
      const bool inner = i > 1 && i < side - 2 && j > 1 && j < side - 2;
      const int n = i + side * j;
      at.push_back({0.02 * (i + (inner ? 0.4 * noise(n) : 0)), 0.02 * (j + (inner ? 0.4 * noise(3 * n) : 0))});
      obj += "v " + std::to_string(at.back()[0]) + " 0 " + std::to_string(at.back()[1]) + "\n";
    }
  int obtuse = 0;  // quadrilaterals whose diagonal is the wrong one
  const auto angle = [&](int a, int b, int c) {
    const auto u = [&](int k) { return at[static_cast<std::size_t>(k)]; };
    return std::acos(((u(a)[0] - u(b)[0]) * (u(c)[0] - u(b)[0]) + (u(a)[1] - u(b)[1]) * (u(c)[1] - u(b)[1])) /
                     std::hypot(u(a)[0] - u(b)[0], u(a)[1] - u(b)[1]) /
                     std::hypot(u(c)[0] - u(b)[0], u(c)[1] - u(b)[1]));
  };
  for (int j = 0; j + 1 < side; ++j)
    for (int i = 0; i + 1 < side; ++i) {
      const int a = i + side * j, b = a + 1, c = a + side, d = c + 1;
      const auto face = [&](int k, int l, int m) {
        obj += "f " + std::to_string(k + 1) + " " + std::to_string(l + 1) + " " + std::to_string(m + 1) + "\n";
      };
      face(a, c, d);
      face(a, d, b);
      obtuse += angle(a, c, d) + angle(a, b, d) > 3.15 ? 1 : 0;
    }
  EXPECT_GT(obtuse, 10);
  return obj;
}

/// The sheet with two rates, its warp 25° from x towards z.
std::string weave(const std::string& mesh, const std::string& place) {
  return "drench: 1\ntime: {step: 0.01, end: 1}\ncloth:\n  - mesh: {file: \"" + mesh + "\"}\n    dynamics: false\n" +
         place +
         "    warp: [0.906307787036650, 0, 0.422618261740699]\n    porous: {diffusivity: 2.0e-3, weft_diffusivity: "
         "4.0e-4}\n";
}

/// The rows of the nodes name each pair of theirs.
void expect_rows_of_nodes(const FabricPairs& fabric, std::size_t count) {
  for (std::size_t n = 0; n < count; ++n) {
    std::size_t found = 0;
    for (Index k = fabric.of_node.start[n]; k < fabric.of_node.start[n + 1]; ++k, ++found) {
      const Index item = fabric.of_node.item[static_cast<std::size_t>(k)];
      EXPECT_EQ(fabric.nodes[static_cast<std::size_t>(item / 2)][static_cast<std::size_t>(item % 2)],
                static_cast<Index>(n));
    }
    EXPECT_GE(found, 2u);
  }
}

}  // namespace

TEST(diffusion, pairs_are_those_of_the_intrinsic_delaunay_mesh) {
  // ω > 0 all the same, and exact for s linear in the position: Σ_j ω_ij (x_j − x_i) = 0 inside and Σ ω_ij (s_i − s_j)²
  // is the Dirichlet energy, with the boundary's.
  const TempFolder folder;
  write_text(folder.path() / "sheet.obj", distorted_sheet());
  const auto setup = setup_from("drench: 1\ntime: {step: 0.01, end: 1}\ncloth:\n  - mesh: {file: \"" +
                                (folder.path() / "sheet.obj").string() + "\"}\n    dynamics: false\n    porous: {}\n");
  const FabricPairs& fabric = setup.model.fabric;
  const auto& x = setup.model.mesh.rest_position;
  double energy[2] = {0, 0}, area = 0;
  std::vector<Vec3> pull(x.size(), Vec3{0, 0, 0});
  for (std::size_t e = 0; e < fabric.weight.size(); ++e) {
    EXPECT_GT(fabric.weight[e], 0);
    const auto i = static_cast<std::size_t>(fabric.nodes[e][0]), j = static_cast<std::size_t>(fabric.nodes[e][1]);
    for (std::size_t a = 0; a < 3; ++a) {
      pull[i][a] += fabric.weight[e] * (x[j][a] - x[i][a]);
      pull[j][a] += fabric.weight[e] * (x[i][a] - x[j][a]);
    }
    energy[0] += fabric.weight[e] * std::pow(x[i][0] - x[j][0], 2);
    energy[1] += fabric.weight[e] * std::pow(x[i][2] - x[j][2], 2);
  }
  for (const double a : setup.model.samples.area) area += a;
  for (const double e : energy) EXPECT_NEAR(e, area, 1e-9 * area);
  for (std::size_t n = 0; n < x.size(); ++n) {
    const bool edge = n % side == 0 || n % side == side - 1 || n < side || n >= side * (side - 1);
    for (std::size_t a = 0; a < 3 && !edge; ++a) EXPECT_NEAR(pull[n][a], 0, 1e-12) << n;
  }
  expect_rows_of_nodes(fabric, x.size());
}

TEST(diffusion, pairs_of_a_weave_are_those_of_the_stretched_delaunay_mesh) {
  // ω > 0, and exact for linear s: the fluxes balance inside, and D Σ ω (s_i − s_j)² is the area times ∇s·D∇s.
  const TempFolder folder;
  const std::string mesh = (folder.path() / "sheet.obj").string();
  write_text(mesh, distorted_sheet());
  // Turned by 90° about x, which takes z to −y: the warp turns with the mesh.
  const std::string place = "    place: {rotate: {axis: [1, 0, 0], degrees: 90}}\n";
  const auto flat = setup_from(weave(mesh, "")), setup = setup_from(weave(mesh, place));
  const FabricPairs& fabric = setup.model.fabric;
  const auto& x = setup.model.mesh.rest_position;
  ASSERT_EQ(flat.model.fabric.weight.size(), fabric.weight.size());
  const double degrees = 3.14159265358979323846 / 180, c = std::cos(25 * degrees), s = std::sin(25 * degrees);
  const double D = std::sqrt(2e-3 * 4e-4);
  EXPECT_DOUBLE_EQ(setup.model.cloths[0].diffusivity, D);
  // D ∇s of s = x, s = −y and s = x − y, in the coordinates (x, −y) of the sheet's plane
  const double xx = 2e-3 * c * c + 4e-4 * s * s, yy = 2e-3 * s * s + 4e-4 * c * c, xy = (2e-3 - 4e-4) * c * s;
  double area = 0, energy[3] = {0, 0, 0};
  std::vector<Vec3> pull(x.size(), Vec3{0, 0, 0});
  for (std::size_t e = 0; e < fabric.weight.size(); ++e) {
    EXPECT_GT(fabric.weight[e], 0);
    EXPECT_NEAR(fabric.weight[e], flat.model.fabric.weight[e], 1e-9);
    const auto i = static_cast<std::size_t>(fabric.nodes[e][0]), j = static_cast<std::size_t>(fabric.nodes[e][1]);
    for (std::size_t a = 0; a < 3; ++a) {
      pull[i][a] += fabric.weight[e] * (x[j][a] - x[i][a]);
      pull[j][a] += fabric.weight[e] * (x[i][a] - x[j][a]);
    }
    const double dx = x[i][0] - x[j][0], dy = -(x[i][1] - x[j][1]);
    energy[0] += fabric.weight[e] * dx * dx;
    energy[1] += fabric.weight[e] * dy * dy;
    energy[2] += fabric.weight[e] * (dx + dy) * (dx + dy);
  }
  for (const double a : setup.model.samples.area) area += a;
  const double expected[3] = {area * xx, area * yy, area * (xx + yy + 2 * xy)};
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(D * energy[k], expected[k], 1e-8 * expected[k]);
  for (std::size_t n = 0; n < x.size(); ++n) {
    const bool edge = n % side == 0 || n % side == side - 1 || n < side || n >= side * (side - 1);
    for (std::size_t a = 0; a < 3 && !edge; ++a) EXPECT_NEAR(pull[n][a], 0, 1e-12) << n;
  }
  expect_rows_of_nodes(fabric, x.size());
}

TEST(diffusion, of_a_weave_agrees_with_the_reference) {
  const TempFolder folder;
  const std::string mesh = (folder.path() / "sheet.obj").string();
  write_text(mesh, distorted_sheet());
  const auto chequered = [](const Model& model, HostState& s) {
    for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
      s.node_liquid[n] = static_cast<Quanta>((n % 3) * 0.4 * model.samples.node_capacity[n] / model.quantum);
  };
  for (const std::string kind : law) {
    SCOPED_TRACE(kind);
    compare_stage({.stage = Stage::diffusion,
                   .scene = with(weave(mesh, ""), "diffusivity:", kind + ", diffusivity:"),
                   .prepare = chequered,
                   .changes = "node_liquid"});
  }
}

TEST(diffusion, fabric_that_conducts_alike_has_no_warp) {
  const auto setup = setup_from(two_layers("diffusion: linear"));
  EXPECT_TRUE(setup.model.mesh.triangle_warp.empty());
  const TempFolder folder;
  write_text(folder.path() / "sheet.obj", distorted_sheet());
  const auto setup_of_weave = setup_from(weave((folder.path() / "sheet.obj").string(), ""));
  EXPECT_EQ(setup_of_weave.model.mesh.triangle_warp.size(), setup_of_weave.model.mesh.triangle.size());
}

}  // namespace drench::test
