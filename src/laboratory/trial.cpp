#include "laboratory/trial.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <regex>
#include <string_view>

#include "output/text_file.hpp"
#include "scene/load.hpp"
#include "scene/yaml_tree.hpp"
#include "setup/build.hpp"
#include "setup/forecast.hpp"
#include "stages/substeps.hpp"

namespace drench {
namespace {

/// Keys of `cloth.0` that belong to the fabric.
constexpr std::array<std::string_view, 12> fabric_keys{"fabric",   "areal_density", "thickness",    "compression",
                                                       "stretch",  "membrane",      "bend",         "bending",
                                                       "friction", "adhesion",      "strain_limit", "porous"};

bool is_of_fabric(std::string_view override_text) {
  constexpr std::string_view specimen = "cloth.0.";
  if (!override_text.starts_with(specimen)) return false;
  const std::string_view key = override_text.substr(specimen.size());
  const std::string_view first = key.substr(0, key.find_first_of(".="));
  return std::find(fabric_keys.begin(), fabric_keys.end(), first) != fabric_keys.end();
}

MaterialScene material_of(const TestRequest& request) {
  std::vector<std::string> overrides;
  for (const std::string& o : request.overrides)
    if (is_of_fabric(o)) overrides.push_back(o);
  const std::string text = fmt::format(
      "drench: 1\ncloth:\n  - fabric: \"{}\"\n    mesh: {{grid: {{size: [1, 1], nodes: [2, 2]}}}}\n    porous: {{}}\n",
      yaml::escaped(request.fabric, "\"\\"));
  try {
    return parse_scene(text, "drench test", overrides).cloths.at(0).material;
  } catch (const SceneError& e) {
    // The text above is no file of the user's.
    static const std::regex place(R"(^drench test(:\d+:\d+)?: (cloth\.0\.fabric: )?)");
    const std::string what = e.what();
    std::smatch found;
    if (!std::regex_search(what, found, place)) throw;
    throw SceneError("--fabric " + request.fabric, found.suffix().str());
  }
}

/// Measurements rely on where the specimen is and on what holds it.
void check_overrides(const StandardTest& test, const TestRequest& request) {
  for (const std::string& o : request.overrides)
    for (const std::string_view key : {"cloth.0.mesh", "cloth.0.place", "cloth.0.pin"}) {
      if (!o.starts_with(key)) continue;
      const std::string_view rest = std::string_view(o).substr(key.size());
      if (!rest.starts_with('.') && !rest.starts_with('=')) continue;
      if (rest.starts_with(".grid.nodes=") && test.takes_other_mesh) continue;
      throw SceneError("--set " + o,
                       fmt::format("{}: the test {} sets it; allowed: keys of the fabric and of the scene{}", key,
                                   test.name, test.takes_other_mesh ? ", and cloth.0.mesh.grid.nodes" : ""));
    }
}

/// Threads that wait for a core, or for each other in short loops, take longer than one alone.
void choose_threads(const Simulation& run) {
  constexpr Index few = 3000;  // nodes and particles
  const HostState state = run.state();
  const int all = loop_threads();
  share_loops(all);
  const bool small = state.node_count() + static_cast<Index>(state.fluid_mass.size()) < few;
  if (all > 1 && (small || loop_cores() < all - 0.3)) share_loops(1);
}

std::string joined(const std::vector<std::string>& overrides) {
  std::string text;
  for (const std::string& o : overrides) text += " --set " + o;
  return text;
}

}  // namespace

Trial::Trial(const StandardTest& test, const TestRequest& request, Direction direction, int repeat)
    : test_(test), request_(request), direction_(direction), repeat_(repeat), material_(material_of(request)) {
  check_overrides(test, request);
  specimen_.name = !test.directions ? fmt::format("{}", repeat + 1)
                                    : fmt::format("{} {}", along_warp() ? "warp" : "weft", repeat + 1);
}

double Trial::scatter(int purpose) const {
  // Two irrational steps fill the square evenly for any number of repeats.
  constexpr std::array<double, 3> steps{0.7548776662466927, 0.5698402909980532, 0.4301597090019468};
  const double part = repeat_ * steps[static_cast<std::size_t>(purpose) % steps.size()];
  const double inside = part - std::floor(part);
  return inside < 0.5 ? 2 * inside : 2 * inside - 2;
}

double Trial::capacity() const { return (1 - material_.solid_fraction) * material_.thickness * water_density; }

double Trial::uptake_velocity() const {
  constexpr double slowest = 1e-4, fastest = 0.05, unknown = 0.01;  // m/s
  if (!(material_.permeability > 0)) return unknown;
  const double flux = material_.permeability * standard_gravity * material_.capillary_height /
                      (water_viscosity * material_.thickness / 2);
  return std::clamp(flux, slowest, fastest);
}

std::string Trial::specimen(const std::string& mesh, const std::string& keys, const std::string& porous) const {
  std::string text = fmt::format("cloth:\n  - name: specimen\n    fabric: \"{}\"\n    mesh: {}\n{}",
                                 yaml::escaped(request_.fabric, "\"\\"), mesh, keys);
  if (test_.porous) text += fmt::format("    porous: {{{}}}\n", porous);
  return text;
}

std::string Trial::without(const std::string& key, const std::string& value) {
  if (std::find(unused_.begin(), unused_.end(), key) == unused_.end()) unused_.push_back(key);
  return fmt::format(", {}: {}", key, value);
}

std::string Trial::porous_without_film() {
  std::string keys = "max_saturation: 1";
  if (material_.film > 0) keys += without("film", "0");
  if (material_.film_viscosity > 0) keys += without("film_viscosity", "0");
  return keys;
}

std::string Trial::porous_without_wicking() {
  // A diffusivity along the weft alone is not allowed; this one wets 10 µm in a minute.
  std::string keys = material_.weft_diffusivity ? "diffusivity: 1.0e-12" + without("weft_diffusivity", "1.0e-12")
                                                : std::string("diffusivity: 0");
  if (material_.film > 0) keys += without("film", "0");
  if (material_.film_viscosity > 0) keys += without("film_viscosity", "0");
  for (const auto& [key, value] : {std::pair{"drainage_height", material_.drainage_height},
                                   {"drainage_exponent", material_.drainage_exponent},
                                   {"large_pores", material_.large_pores},
                                   {"large_pore_height", material_.large_pore_height},
                                   {"pore_narrowing", material_.pore_narrowing}})
    if (value != 0) keys += without(key, "0");
  if (material_.contact_wicking) keys += without("contact_wicking", "false");
  return keys;
}

std::string Trial::porous_without_flow() {
  std::string keys = fmt::format("uptake_velocity: {:.4g}, {}", uptake_velocity(), porous_without_film());
  // A fabric that repels needs its permeability; another one would drip without the capillary barrier of its back face.
  if (material_.breakthrough_pressure > 0) return keys;
  keys += ", permeability: 0";
  if (material_.forchheimer > 0) keys += ", forchheimer: 0";
  if (material_.fibre_diameter > 0) keys += ", fibre_diameter: 0";
  return keys;
}

std::string Trial::warp_along_length() const {
  const bool woven = material_.membrane || material_.bending || (test_.porous && material_.weft_diffusivity);
  if (!woven) return "";  // the key would have no effect, which a scene refuses
  return along_warp() ? "    warp: [0, 0, 1]\n" : "    warp: [1, 0, 0]\n";
}

std::string Trial::file_name(const std::string& stem, const std::string& ending) const {
  std::string name = specimen_.name;
  std::replace(name.begin(), name.end(), ' ', '_');
  return stem + "_" + name + ending;
}

std::unique_ptr<Simulation> Trial::open(const std::string& text, const std::string& suffix) {
  const std::string name = file_name("scene", suffix + ".yaml");
  const std::filesystem::path path = request_.folder / name;
  std::vector<std::string> overrides = request_.overrides;
  std::erase_if(overrides, [&](const std::string& o) {
    return std::any_of(unused_.begin(), unused_.end(),
                       [&](const std::string& key) { return o.starts_with("cloth.0.porous." + key + "="); }) ||
           std::any_of(written_.begin(), written_.end(), [&](const std::string& key) {
             return o.starts_with("cloth.0." + key + "=") || o.starts_with("cloth.0." + key + ".");
           });
  });
  const Scene scene = parse_scene(text, path.string(), overrides);
  const std::string head =
      fmt::format("# {}: {}, specimen {}\n# drench test {} --fabric {}{}\n", test_.standard, test_.title,
                  specimen_.name, test_.name, request_.fabric, joined(request_.overrides));
  // With overrides the file has every key, so that it runs as it is.
  write_atomically(path, head + (request_.overrides.empty() ? text : to_yaml(scene)));
  specimen_.scene = name;
  auto run = std::make_unique<Simulation>(scene);
  choose_threads(*run);
  foresee(*run);
  for (const std::string& w : run->warnings()) {
    if (computes_on_host() && w.find("Jacobi iterations (on a GPU") != w.npos) continue;
    if (std::find(warnings_.begin(), warnings_.end(), w) == warnings_.end()) warnings_.push_back(w);
  }
  return run;
}

void Trial::foresee(const Simulation& run) const {
  constexpr double many = 1e6;
  const Scene& scene = run.scene();
  const double steps = scene.time.end / scene.time.step;
  double parts = 1;
  // The model is built again where a scene warns of them only.
  if (std::any_of(run.warnings().begin(), run.warnings().end(),
                  [](const std::string& w) { return w.find("diffusion needs about") != w.npos; })) {
    const Model model = build(scene).model;
    for (const ClothMaterial& cloth : model.cloths)
      if (cloth.wicks()) parts = std::max(parts, substeps_for(diffusion_rate(model, cloth), scene.time.step));
  }
  if (!request_.takes_long || steps * parts < many) return;
  request_.takes_long(
      parts > 1 ? fmt::format("this takes long: about {:.2g} steps with {:.2g} sub-steps of diffusion each; a smaller "
                              "diffusivity or time.end needs fewer",
                              steps, parts)
                : fmt::format("this takes long: about {:.2g} steps; a smaller time.end needs fewer", steps));
}

void Trial::row(std::vector<double> values) {
  values.resize(test_.columns.size());
  specimen_.rows.push_back(std::move(values));
}

void Trial::number(std::string key, std::string meaning, std::string unit, double value,
                   std::optional<double> expected) {
  specimen_.numbers.push_back({std::move(key), std::move(meaning), std::move(unit), value, expected});
}

void Trial::note(std::string text) { specimen_.notes.push_back(std::move(text)); }

TestedSpecimen Trial::take() {
  if (!unused_.empty()) note(fmt::format("this test does not use {} of the fabric", fmt::join(unused_, ", ")));
  return std::move(specimen_);
}

void watch_run(Simulation& run, double end, double interval, const std::function<bool(const HostState&)>& look) {
  if (!look(run.state())) return;
  for (int k = 1; run.time() < end * (1 - 1e-9); ++k) {
    run.run_until(std::min(end, k * interval));
    if (!look(run.state())) return;
  }
}

double liquid_mass(const Simulation& run, const HostState& state) {
  return static_cast<double>(std::accumulate(state.fluid_mass.begin(), state.fluid_mass.end(), Quanta{0})) *
         run.quantum();
}

double cloth_mass(const Simulation& run, const HostState& state, Index cloth) {
  const auto [first, count] = run.cloth_nodes(cloth);
  Quanta sum = 0;
  for (Index n = first; n < first + count; ++n) sum += state.node_liquid[at(n)];
  return static_cast<double>(sum) * run.quantum();
}

FittedLine fit_line(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double mx = 0, my = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) mx += x[i] / n, my += y[i] / n;
  for (std::size_t i = 0; i < x.size(); ++i) xx += (x[i] - mx) * (x[i] - mx), xy += (x[i] - mx) * (y[i] - my);
  const double slope = xx > 0 ? xy / xx : 0;
  return {slope, my - slope * mx};
}

}  // namespace drench
