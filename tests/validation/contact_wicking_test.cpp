// Layers that touch: liquid passes between them where both ask for it, and nowhere else.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/run_program.hpp"
#include "validation.hpp"

namespace drench::test {
namespace {

/// A soaked sheet 1 mm above a dry one of another mesh and another weave.
std::string two_sheets(const std::string& lower, const std::string& upper, double step) {
  return fmt::format(R"(drench: 1
time: {{step: {}, end: 1000}}
gravity: [0, 0, 0]
cloth:
  - name: lower
    mesh: {{grid: {{size: [0.2, 0.1], nodes: [21, 11]}}}}
    dynamics: false
    porous: {{{}}}
  - name: upper
    mesh: {{grid: {{size: [0.2, 0.1], nodes: [17, 8]}}}}
    place: {{position: [0, 0.001, 0]}}
    dynamics: false
    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [1, 1, 1]}}, value: 1}}]
    porous: {{{}}}
)",
                     step, lower, upper);
}

struct Sheets {
  double mean[2] = {0, 0};  // saturation of the lower and the upper one
  double low = 1e9, high = -1e9;
  Quanta lower = 0;
};

Sheets look(const Model& model, const HostState& s) {
  Sheets found;
  double capacity[2] = {0, 0};
  for (std::size_t n = 0; n < s.node_liquid.size(); ++n) {
    const auto cloth = static_cast<std::size_t>(model.mesh.node_cloth[n]);
    const double mass = kilograms(model, s.node_liquid[n]), saturation = mass / model.samples.node_capacity[n];
    capacity[cloth] += model.samples.node_capacity[n];
    found.mean[cloth] += mass;
    found.low = std::min(found.low, saturation);
    found.high = std::max(found.high, saturation);
    if (cloth == 0) found.lower += s.node_liquid[n];
  }
  for (int c = 0; c < 2; ++c) found.mean[c] /= capacity[c];
  return found;
}

}  // namespace

TEST(contact_wicking, two_sheets_in_contact_come_to_equal_saturation) {
  SceneRun run(
      two_sheets("contact_wicking: true", "contact_wicking: true, solid_fraction: 0.7, diffusivity: 3.0e-5", 0.01));
  Quanta lost = 0, outside = 0;
  const auto total = [](const StepReport& r) { return r.mass_fluid + r.mass_cloth + r.mass_drained - r.mass_supplied; };
  Quanta before = 0;
  for (const Quanta m : run.initial().node_liquid) before += m;
  for (int n = 0; n < 200; ++n) {
    lost = std::max(lost, std::abs(total(run.step()) - before));
    const Sheets now = look(run.model(), run.state());
    outside += now.low < 0 || now.high > 1.18 ? 1 : 0;
  }
  const Sheets end = look(run.model(), run.state());
  // The upper one holds 0.3 of its volume, the lower one 0.6.
  const std::string what = "soaked cloth on a dry one of another weave and mesh, after 2 s: ";
  report({what + "common saturation, error", "masses: 0.3/(0.3 + 0.6)", std::fabs(end.mean[0] * 3 - 1), 0.01});
  report({what + "range of saturation over both", "0", end.high - end.low, 0.01});
  report({what + "mass budget error", "0", static_cast<double>(lost), 0, "quanta"});
  report({what + "steps with a node outside [0, s_max]", "0", static_cast<double>(outside), 0});
}

TEST(contact_wicking, layers_of_other_pores_come_to_equal_suction) {
  struct Case {
    const char *what, *lower, *upper;
    double low, up;  // saturations at rest
  };
  // The upper sheet is full at first; it holds 0.3 of its volume, the lower one 0.6. ℓ (1 − s^β) is the same in the
  // end.
  const std::array<Case, 3> cases{{
      {"ℓ 0.3 m below, 0.2 m above", "capillary_height: 0.3", "capillary_height: 0.2", 3.0 / 7, 1.0 / 7},
      {"β 2 below, 1 above", "capillary_height: 0.3, retention_exponent: 2", "capillary_height: 0.3",
       std::sqrt(2.0) - 1, 3 - 2 * std::sqrt(2.0)},
      {"ℓ 0.3 m below, 0.1 m above, which runs dry", "capillary_height: 0.3", "capillary_height: 0.1", 0.5, 0},
  }};
  for (const Case& c : cases) {
    SceneRun run(two_sheets(fmt::format("contact_wicking: true, {}", c.lower),
                            fmt::format("contact_wicking: true, solid_fraction: 0.7, diffusivity: 3.0e-5, {}", c.upper),
                            0.01));
    for (int n = 0; n < 300; ++n) run.step();
    const Sheets end = look(run.model(), run.state());
    report({fmt::format("soaked cloth on a dry one, {}: saturations at rest, error", c.what), "equal suction and mass",
            std::max(std::fabs(end.mean[0] - c.low), std::fabs(end.mean[1] - c.up)), 0.005});
  }
}

TEST(contact_wicking, conducts_as_the_layers_do_through_their_thickness) {
  // Two equal layers, the difference of whose saturations falls as e^(−2 D t/τ²): 0.2/s.
  SceneRun run(
      two_sheets("contact_wicking: true, diffusivity: 1.0e-7", "contact_wicking: true, diffusivity: 1.0e-7", 0.05));
  for (int n = 0; n < 100; ++n) run.step();
  const Sheets end = look(run.model(), run.state());
  report({"soaked cloth on a dry one: difference of their mean saturations after one e-fold, over theory − 1",
          "e^(−2 D t/τ²)", std::fabs((end.mean[1] - end.mean[0]) * std::exp(1.0) - 1), 0.02});
  // The suction of layers of other pores falls at the same rate, for each conducts in proportion to 1/ℓ.
  SceneRun other(two_sheets("contact_wicking: true, diffusivity: 1.0e-7, capillary_height: 0.3",
                            "contact_wicking: true, diffusivity: 1.0e-7, capillary_height: 0.2", 0.05));
  for (int n = 0; n < 100; ++n) other.step();
  const Sheets last = look(other.model(), other.state());
  report({"the same with ℓ 0.3 m below, 0.2 m above: difference of their suctions", "e^(−2 D t/τ²)",
          std::fabs((0.3 * (1 - last.mean[0]) - 0.2 * (1 - last.mean[1])) / 0.3 * std::exp(1.0) - 1), 0.02});
}

namespace {

/// A strip of 40 × 4 cells of 2.5 mm, flat or with its second half folded back over its first, one cell above it.
std::string strip(const fs::path& file, bool folded) {
  constexpr int along = 41, across = 5;
  constexpr double cell = 0.0025;
  std::string obj;
  for (int i = 0; i < along; ++i)
    for (int j = 0; j < across; ++j) {
      const bool back = folded && i > 20;
      obj += fmt::format("v {:.7f} {:.7f} {:.7f}\n", (back ? 41 - i : i) * cell, back ? cell : 0, j * cell);
    }
  for (int i = 0; i + 1 < along; ++i)
    for (int j = 0; j + 1 < across; ++j) {
      const int a = 1 + i * across + j, b = a + 1, c = a + across, d = c + 1;
      obj += fmt::format("f {} {} {}\nf {} {} {}\n", a, b, c, b, d, c);
    }
  write_text(file, obj);
  return file.string();
}

}  // namespace

TEST(contact_wicking, a_fold_is_no_short_cut) {
  const TempFolder folder;
  std::vector<HostState> end;
  const std::vector<std::pair<bool, const char*>> layouts = {
      {false, ""}, {true, ""}, {true, ", contact_wicking: true"}};
  for (const auto& [folded, keys] : layouts) {
    SceneRun run(fmt::format(R"(drench: 1
time: {{step: 0.01, end: 1000}}
gravity: [0, 0, 0]
cloth:
  - mesh: {{file: "{}"}}
    dynamics: false
    thickness: 0.002
    porous: {{diffusivity: 5.0e-4{}}}
)",
                             strip(folder.path() / "strip.obj", folded), keys));
    HostState s = run.initial();
    for (std::size_t n = 0; n < 5 * 8; ++n)
      s.node_liquid[n] = std::llround(run.model().samples.node_capacity[n] / run.model().quantum);
    run.restart(s);
    for (int n = 0; n < 100; ++n) run.step();
    end.push_back(run.state());
    if (folded && *keys == 0) {
      double worst = 0;
      for (std::size_t n = 0; n < s.node_liquid.size(); ++n)
        worst = std::max(worst, std::fabs(kilograms(run.model(), end[1].node_liquid[n] - end[0].node_liquid[n])) /
                                    run.model().samples.node_capacity[n]);
      report({"folded strip, wet at one end, layers 1.25 thicknesses apart: saturation against the flat strip's",
              "equal", worst, 1e-6});
    }
  }
  // With contact_wicking the wet end passes liquid to the end that lies on it.
  Quanta through = 0;
  for (std::size_t n = 33 * 5; n < 41 * 5; ++n) through += end[2].node_liquid[n] - end[1].node_liquid[n];
  EXPECT_GT(through, 0);
}

TEST(contact_wicking, nothing_passes_unless_both_ask_for_it) {
  const std::vector<std::pair<const char*, const char*>> keys = {
      {"", ""}, {"contact_wicking: true", ""}, {"", "contact_wicking: true"}};
  for (const auto& [lower, upper] : keys) {
    SceneRun run(two_sheets(lower, upper, 0.01));
    for (int n = 0; n < 50; ++n) run.step();
    report({fmt::format("soaked cloth on a dry one, contact_wicking {}: transferred liquid in 0.5 s",
                        *lower   ? "below only"
                        : *upper ? "above only"
                                 : "off"),
            "0", static_cast<double>(look(run.model(), run.state()).lower), 0, "quanta"});
  }
}

}  // namespace drench::test
