#include "random_scenes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace drench::test {
namespace {

constexpr double gravity_part = 0.25, between_sheets = 0.02;  // 1, m

std::string list_of(std::initializer_list<std::string> parts) {
  std::string all;
  for (const std::string& part : parts) {
    if (part.empty()) continue;
    all += (all.empty() ? "" : ", ") + part;
  }
  return all;
}

}  // namespace

double SceneDraw::uniform(double low, double high) {
  return low + (high - low) * 0x1p-53 * static_cast<double>(random_() >> 11);
}

double SceneDraw::logarithmic(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }

double SceneDraw::usually(double low, double high, double least, double most) {
  if (wild_ && chance(0.15)) {
    drawn_.ordinary = false;
    return logarithmic(least, most);
  }
  return logarithmic(low, high);
}

bool SceneDraw::chance(double share) { return uniform(0, 1) < share; }

int SceneDraw::whole(int low, int high) {
  return low + static_cast<int>(random_() % static_cast<std::uint64_t>(high - low + 1));
}

std::string SceneDraw::word(std::initializer_list<const char*> words) {
  return words.begin()[random_() % words.size()];
}

std::string SceneDraw::vector(double low, double high) {
  const double x = uniform(low, high), y = uniform(low, high), z = uniform(low, high);
  return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", x, y, z);
}

std::string SceneDraw::keys(double low, double high, bool three) {
  const auto value = [&] { return three ? vector(low, high) : fmt::format("{:.4g}", uniform(low, high)); };
  const double middle = uniform(1, 20) * dt_, last = middle + uniform(1, 30) * dt_;
  const std::string a = value(), b = value(), c = value(), how = word({"linear", "smooth", "step"});
  return fmt::format("{{keys: [[0, {}], [{:.4g}, {}], [{:.4g}, {}]], interpolation: {}}}", a, middle, b, last, c, how);
}

template <class Text>
std::string SceneDraw::drawn_by(std::mt19937_64& numbers, double share, const Text& text) {
  if (narrow_) return "";
  std::swap(random_, numbers);
  const std::string drawn = chance(share) ? text() : std::string();
  std::swap(random_, numbers);
  return drawn;
}

template <class Text>
std::string SceneDraw::sometimes(double share, const Text& text) {
  return drawn_by(more_, share, text);
}

void SceneDraw::begin() {
  dt_ = usually(0.001, 0.004, 1e-5, 0.1);
  drawn_.yaml = fmt::format("drench: 1\ntime: {{step: {:.4g}, end: 10, mode: {}, cfl: {:.3g}}}\n", dt_,
                            word({"fixed", "cfl"}), uniform(0.1, 1));
  if (chance(gravity_part)) drawn_.yaml += fmt::format("gravity: {}\n", chance(0.3) ? "[0, 0, 0]" : vector(-12, 12));
  drawn_.yaml += "domain: {min: [-0.4, -0.4, -0.4], max: [0.4, 0.5, 0.4]}\n";
  drawn_.yaml += fmt::format("neighbors: {{sort: {}, through_cloth: {}}}\n",
                             word({"auto", "counting", "radix", "bitonic", "bitonic_naive"}), chance(0.2));
  if (chance(0.3)) drawn_.yaml += "output: {measures: true}\n";
  const std::string error =
      sometimes(0.12, [&] { return fmt::format("mode: error, tolerance: {:.3g}", usually(3e-4, 3e-3, 1e-5, 0.1)); });
  if (!error.empty()) {
    const std::size_t at = drawn_.yaml.find("mode: ");
    drawn_.yaml.replace(at, drawn_.yaml.find(',', at) - at, error);
  }
  const std::string wind = sometimes(0.15, [&] {
    const bool gusts = chance(0.4);
    const std::string velocity = !gusts && chance(0.5) ? keys(-8, 8, true) : vector(-8, 8);
    const double drag = uniform(0, 2), along = uniform(0, 0.1), liquid = chance(0.5) ? uniform(0, 1) : 0;
    return fmt::format("wind: {{velocity: {}, normal_drag: {:.3g}, tangential_drag: {:.3g}, liquid_drag: {:.3g}{}}}\n",
                       velocity, drag, along, liquid,
                       gusts
                           ? fmt::format(", gusts: [{{time: 0, velocity: {}}}, {{time: {:.3g}, velocity: [0, 0, 0]}}]",
                                         vector(-8, 8), 30 * dt_)
                           : "");
  });
  if (!wind.empty()) drawn_.closed = false;
  drawn_.yaml += wind;
}

void SceneDraw::fluid() {
  d_ = logarithmic(0.012, 0.025);
  std::string& yaml = drawn_.yaml;
  if (chance(0.2))
    yaml += fmt::format("field: {{center: {}, rate: [{:.3g}, {:.3g}, 0]}}\n", vector(-0.1, 0.1), uniform(1, 10),
                        uniform(0, 10));
  yaml += fmt::format("fluid:\n  spacing: {:.5g}\n  density: {:.5g}\n  viscosity: {:.4g}\n", d_,
                      usually(700, 1400, 1, 30000), usually(1e-6, 1e-2, 1e-7, 1));
  if (chance(0.3)) yaml += fmt::format("  surface_tension: {:.3g}\n", usually(0.01, 0.08, 1e-3, 1));
  const std::string kernel = word({"cubic", "cubic", "wendland", "poly6"});
  yaml += fmt::format("  kernel: {}\n  support: {:.3g}\n", kernel,
                      kernel == "wendland" ? uniform(2.4, 3) : uniform(1.8, 2.6));
  yaml += drawn_by(others_, 0.25, [] { return std::string("  wall_pressure: mirrored\n"); });
  yaml += sometimes(0.2, [&] {
    const bool pays = chance(0.5);
    if (!pays) drawn_.closed = false;
    const double transfer = usually(1e-4, 1e-2, 1e-6, 10), inertia = usually(0.3, 3, 0.01, 1e4);
    return fmt::format("  micropolar: {{transfer: {:.3g}, inertia: {:.3g}, viscosity: {:.3g}, reaction: {:.3g}}}\n",
                       transfer, inertia, uniform(0, 1e-3), pays ? 1 : uniform(0, 1));
  });
  if (chance(0.4)) {
    const int most = whole(1, 200);
    yaml += fmt::format(
        "  solver: {{density_error: {:.3g}, divergence_error: {:.3g}, max_iterations: {}, min_iterations: {}}}\n",
        usually(1e-4, 1e-2, 1e-6, 0.5), usually(1e-4, 1e-2, 1e-6, 0.5), most, whole(0, std::min(most, 3)));
  } else {
    yaml += sometimes(0.2, [&] { return fmt::format("  solver: {{density_correction: {:.3g}}}\n", uniform(0.5, 1)); });
  }
  yaml += "  sources:\n";
  const double x = uniform(-0.1, 0.05), y = 0.02 + height_ + 0.5 * d_, z = uniform(-0.1, 0.05);
  const int nx = whole(1, 7), ny = whole(1, 7), nz = whole(1, 7);
  yaml += fmt::format("    - block: {{min: [{:.6g}, {:.6g}, {:.6g}], max: [{:.6g}, {:.6g}, {:.6g}], velocity: {}{}}}\n",
                      x, y, z, x + nx * d_, y + ny * d_, z + nz * d_, chance(0.5) ? "[0, 0, 0]" : vector(-3, 3),
                      concentration());
  if (chance(0.3)) {
    const double radius = uniform(1, 2.5) * d_, speed = usually(0.5, 4, 0.01, 60);
    yaml += fmt::format(
        "    - jet: {{center: [{:.4g}, 0.4, {:.4g}], radius: {:.4g}, velocity: [{:.4g}, {:.4g}, 0], start: "
        "{:.3g}{}}}\n",
        uniform(-0.1, 0.1), uniform(-0.1, 0.1), radius, 0.3 * speed, -speed, uniform(0, 20 * dt_), concentration());
  }
  yaml += sometimes(0.15, [&] {  // one that opens, closes and opens
    const double radius = uniform(0.6, 1.5) * d_;
    const std::string center = fmt::format("[{:.4g}, 0.3, {:.4g}]", uniform(-0.1, 0.1), uniform(-0.1, 0.1));
    return fmt::format(
        "    - jet: {{center: {}, radius: {:.4g}, velocity: {{keys: [[0, [0, {:.3g}, 0]], [{:.3g}, [0, 0, 0]], "
        "[{:.3g}, [0, {:.3g}, 0]]], interpolation: {}}}}}\n",
        center, radius, -uniform(0.5, 4), 10 * dt_, 25 * dt_, -uniform(0.5, 4), word({"step", "linear"}));
  });
  yaml += drawn_by(newest_, 0.1, [&] {
    const double speed = uniform(1, 6);
    return fmt::format(
        "    - rain: {{center: [0, 0.35, 0], size: [0.2, {:.3g}], rate: {:.4g}, diameter: {:.3g}, "
        "velocity: [0, {:.3g}, 0]}}\n",
        uniform(0.05, 0.3), usually(1e3, 1e5, 1, 1e6), usually(5e-4, 5e-3, 1e-5, 0.01), -speed);
  });
  yaml += drawn_by(sprays_, 0.08, [&] {
    return fmt::format(
        "    - spray: {{center: [{:.3g}, 0.35, 0], direction: [{:.3g}, -1, 0.2], half_angle: {:.3g}, speed: {:.3g}, "
        "flow: {:.3g}}}\n",
        uniform(-0.1, 0.1), uniform(-1, 1), uniform(0, 90), usually(0.5, 8, 0.01, 60), usually(0.5, 40, 1e-3, 200));
  });
  const std::string drains = drawn_by(newest_, 0.06, [&] {
    return chance(0.5) ? fmt::format("  drains: [{{plane: {{point: [0, {:.3g}, 0], normal: [0, 1, 0]}}}}]\n",
                                     uniform(-0.3, 0.1))
                       : fmt::format("  drains: [{{sphere: {{center: {}, radius: {:.3g}}}, start: {:.3g}}}]\n",
                                     vector(-0.1, 0.1), uniform(0.02, 0.1), uniform(0, 30 * dt_));
  });
  if (!drains.empty()) drawn_.closed = false;
  yaml += drains;
}

std::string SceneDraw::concentration() {
  return drawn_by(dyes_, 0.25, [&] { return fmt::format(", concentration: {:.3g}", logarithmic(1e-6, 1)); });
}

std::string SceneDraw::pins(int nx, int nz) {
  std::string list;
  switch (whole(0, 4)) {
    case 0:
      return "";
    case 1:
      list = "{edges: true";
      break;
    case 2:
      list = "{corners: true";
      break;
    case 3:
      list = fmt::format("{{nodes: [{}, {}]", whole(0, nx * nz / 2), whole(nx * nz / 2, nx * nz - 1));
      break;
    default:
      list = "{box: {min: [-1, -1, -1], max: [-0.05, 1, 1]}";
      break;
  }
  if (chance(0.25)) {
    moving_pins_ = true;
    const std::string plain = vector(-1, 1), moving = sometimes(0.3, [&] { return keys(-1, 1, true); });
    list += ", velocity: " + (moving.empty() ? plain : moving);
    list += sometimes(0.3, [&] {
      return fmt::format(", offset: {{keys: [[0, [0, 0, 0]], [{:.3g}, {}]], interpolation: smooth}}", 25 * dt_,
                         vector(-0.05, 0.05));
    });
    if (chance(0.5))
      list += fmt::format(", spin: {{axis: {}, degrees_per_second: {:.3g}}}", "[0.3, 1, 0.2]", uniform(-360, 360));
    list += fmt::format(", end: {:.3g}", 30 * dt_);
  }
  std::string soft =
      drawn_by(newest_, 0.12, [&] { return fmt::format(", stiffness: {:.3g}", usually(1, 1e4, 1e-3, 1e9)); });
  if (!soft.empty())
    soft += drawn_by(latest_, 0.3, [&] { return fmt::format(", release: {:.3g}", uniform(0, 30) * dt_); });
  if (!soft.empty()) drawn_.closed = false;  // what such pins store is not known
  return "    pin: [" + list + soft + "}]\n";
}

std::string SceneDraw::porous() {
  const double most = chance(0.5) ? 1.18 : uniform(1, 3);
  std::string yaml;
  if (chance(0.6))
    yaml +=
        fmt::format("    initial_saturation: [{{box: {{min: [-1, -1, -1], max: [{:.3g}, 1, 1]}}, value: {:.4g}}}]\n",
                    uniform(-0.1, 1), uniform(0, most));
  if (!yaml.empty()) {  // rounded up it may be above the most
    const std::size_t at = yaml.rfind("value: ") + 7;
    const double value = std::stod(yaml.substr(at));
    drips_ = drips_ || value > 1;
    if (value > most) yaml.replace(at, yaml.find('}', at) - at, fmt::format("{:.17g}", most));
  }
  if (chance(0.15)) {
    yaml += fmt::format("    hold_saturation: [{{box: {{min: [0, -1, -1], max: [1, 1, 1]}}, value: {:.4g}}}]\n",
                        uniform(0, most));
    const std::size_t at = yaml.rfind("value: ") + 7;
    if (std::stod(yaml.substr(at)) > most) yaml.replace(at, yaml.find('}', at) - at, fmt::format("{:.17g}", most));
    drawn_.closed = false;
  }
  yaml += drawn_by(dyes_, 0.2, [&] {
    return fmt::format("    initial_stain: [{{box: {{min: [-1, -1, -1], max: [{:.3g}, 1, 1]}}, value: {:.3g}}}]\n",
                       uniform(-0.1, 0.1), logarithmic(1e-6, 10));
  });
  const std::string diffuse = chance(0.7) ? fmt::format("diffusivity: {:.3g}, contact_wicking: {}",
                                                        usually(1e-5, 1e-3, 1e-7, 1e-2), chance(0.4))
                                          : "diffusivity: 0";
  const std::string held = sometimes(0.2, [&] { return fmt::format("retention_exponent: {:.3g}", uniform(1, 4)); });
  const double along = std::stod(diffuse.substr(diffuse.find(' ')));
  const std::string weft = sometimes(0.2, [&] {
    return along > 0 ? fmt::format("weft_diffusivity: {:.3g}", along * logarithmic(0.1, 10)) : std::string();
  });
  yaml +=
      "    porous: {" +
      list_of({fmt::format("max_saturation: {:.17g}, solid_fraction: {:.10g}", most,
                           chance(0.1) ? 1 - logarithmic(1e-9, 0.1) : uniform(0, 0.9)),
               chance(0.5) ? fmt::format("absorption: {:.3g}", usually(1e-3, 0.1, 1e-6, 100))
                           : fmt::format("uptake_velocity: {:.3g}", usually(1e-3, 0.1, 1e-6, 100)),
               chance(0.5) ? fmt::format("virtual_pressure: {:.4g}", usually(1, 100, 1e-3, 1e5)) : "",
               chance(0.5) ? fmt::format("emission_angle: {:.4g}, emission_velocity: {:.4g}, emission_ramp: {:.3g}",
                                         uniform(1, 179), usually(0.1, 5, 1e-3, 100), chance(0.2) ? 0 : uniform(0, 0.1))
                           : "",
               diffuse, held, weft,
               fmt::format("diffusion: {}, capillary_height: {:.3g}", word({"linear", "degenerate"}),
                           usually(0.1, 10, 1e-2, 1000)),
               chance(0.2) ? fmt::format("adhesion: {:.3g}", uniform(0, 0.14)) : ""}) +
      "}\n";
  if (chance(0.3))
    yaml += fmt::format("    friction_wet: {:.3g}\n    damping_wet: {:.3g}\n", uniform(0, 1.3), uniform(0, 10));
  return yaml;
}

std::string SceneDraw::filmed_or_squeezed(std::string pores, bool still) {
  const auto number_after = [&](const std::string& key) {
    const std::size_t at = pores.find(key);
    return at == pores.npos ? 0.0 : std::stod(pores.substr(at + key.size()));
  };
  const std::string height = "capillary_height: ";
  const std::size_t heights = pores.find("diffusion: degenerate, " + height);
  const bool spreads = pores.find("diffusivity: 0,") == pores.npos;
  const std::string drained = drawn_by(latest_, heights == pores.npos || !spreads ? 0 : 0.4, [&] {
    return fmt::format("drainage_height: {:.3g}, ", std::min(1000.0, number_after(height) * logarithmic(1.01, 5)));
  });
  if (!drained.empty()) pores.insert(heights + std::string("diffusion: degenerate, ").size(), drained);
  const std::string large = drawn_by(porous_, heights == pores.npos || !spreads ? 0 : 0.3, [&] {
    return fmt::format("large_pores: {:.3g}, large_pore_height: {:.3g}, ", uniform(0.01, 0.95),
                       number_after(height) / logarithmic(1.6, 90));
  });
  if (heights != pores.npos && spreads)
    pores.insert(heights + std::string("diffusion: degenerate, ").size(),
                 drawn_by(porous_, 0.3, [&] { return fmt::format("pore_narrowing: {:.3g}, ", uniform(-20, 20)); }));
  if (!large.empty()) pores.insert(heights + std::string("diffusion: degenerate, ").size(), large);
  const std::string film = drawn_by(newest_, pores.empty() ? 0 : 0.15, [&] {
    return fmt::format("film: {:.3g}, film_viscosity: {:.3g}", usually(2e-5, 3e-4, 1e-7, 0.01),
                       usually(1e-6, 1e-3, 1e-8, 1));
  });
  const std::string squeezed = drawn_by(newest_, pores.empty() || still ? 0 : 0.2, [&] {
    return fmt::format("compressibility: {:.4g}, ", uniform(0, 0.95) * (1 - number_after("solid_fraction: ")));
  });
  const std::string begin = "porous: {";
  const std::string expands = drawn_by(porous_, pores.empty() || still ? 0 : 0.2,
                                       [&] { return fmt::format("hygral_expansion: {:.3g}, ", uniform(-0.3, 0.3)); });
  if (!expands.empty()) pores.insert(pores.find(begin) + begin.size(), expands);
  if (!squeezed.empty()) pores.insert(pores.find(begin) + begin.size(), squeezed);
  if (film.empty() || !(number_after("diffusivity: ") > 0)) return pores;
  const std::size_t most = pores.find("max_saturation: ");
  pores.replace(most, pores.find(',', most) - most, film);
  for (const char* key : {"initial_saturation", "hold_saturation"}) {  // the film may hold less than that
    const std::size_t at = pores.find(key), value = at == pores.npos ? at : pores.find("value: ", at) + 7;
    if (value != pores.npos && std::stod(pores.substr(value)) > 1)
      pores.replace(value, pores.find('}', value) - value, "1");
  }
  return pores;
}

void SceneDraw::cloth(int number, int count) {
  const int nx = whole(2, 12), nz = whole(2, 12);
  const double width = uniform(0.08, 0.3), depth = uniform(0.08, 0.3),
               least = std::min(width / (nx - 1), depth / (nz - 1));
  const double thickness = std::min(usually(0.0005, 0.003, 1e-5, 0.02), 0.3 * least);
  const double y = between_sheets * (number - count);
  std::string& yaml = drawn_.yaml;
  yaml += fmt::format("  - name: sheet {}\n    mesh: {{grid: {{size: [{:.5g}, {:.5g}], nodes: [{}, {}]}}}}\n", number,
                      width, depth, nx, nz);
  yaml +=
      fmt::format("    place: {{position: [{:.4g}, {:.4g}, {:.4g}], rotate: {{axis: [0, 1, 0], degrees: {:.4g}}}}}\n",
                  uniform(-0.03, 0.03), y, uniform(-0.03, 0.03), uniform(-180, 180));
  const std::size_t fabric = yaml.size();
  yaml += fmt::format(
      "    areal_density: {:.4g}\n    thickness: {:.4g}\n    stretch: {:.4g}\n    bend: {:.4g}\n    damping: {:.3g}\n",
      usually(0.05, 0.5, 1e-3, 100), thickness, usually(50, 5000, 1, 1e6),
      chance(0.2) ? 0 : usually(1e-6, 1e-3, 1e-9, 1), chance(0.3) ? 0 : usually(0.1, 10, 1e-3, 1000));
  if (chance(0.3)) yaml += fmt::format("    strain_damping: {:.3g}\n", usually(0.001, 0.05, 1e-5, 10));
  if (chance(0.3)) yaml += fmt::format("    strain_limit: {:.3g}\n", uniform(0.005, 0.2));
  if (chance(0.4)) yaml += fmt::format("    friction: {:.3g}\n", uniform(0, 2));
  if (chance(0.2)) yaml += fmt::format("    adhesion: {:.3g}\n", uniform(0, 0.1));
  yaml += sometimes(0.3, [&] {
    return chance(0.5) ? std::string("    slip: free\n")
                       : fmt::format("    slip: {:.3g}\n", usually(1e-4, 1e-2, 1e-6, 1));
  });
  yaml += sometimes(0.1, [&] { return fmt::format("    sample_spacing: {:.4g}\n", uniform(0.5, 1) * d_); });
  const bool still = chance(0.15);
  if (still) yaml += "    dynamics: false\n";
  if (chance(0.4)) yaml += "    self_collision: true\n";
  yaml += drawn_by(latest_, still ? 0 : 0.15, [&] {
    return fmt::format("    velocity: [{:.3g}, {:.3g}, {:.3g}]\n", uniform(-2, 2), uniform(-2, 2), uniform(-2, 2));
  });
  const std::string pinned = still ? std::string() : pins(nx, nz);
  const std::string pores = filmed_or_squeezed(chance(0.8) ? porous() : "", still);
  yaml += pinned + pores + regions(thickness, pores);
  // Plates are for pd alone.
  const std::string named = drawn_by(others_, yaml.find("method: pd") != yaml.npos ? 0.12 : 0, [&] {
    return fmt::format("    fabric: {}\n", word({"denim_11oz", "cotton_plain", "nylon_swim", "sock_polyester"}));
  });
  if (named.empty()) return;
  yaml.resize(fabric);
  yaml += named + pinned;
}

std::string SceneDraw::regions(double thickness, const std::string& pores) {
  return drawn_by(patches_, 0.25, [&] { return halves(thickness, pores); });
}

std::string SceneDraw::halves(double thickness, const std::string& pores) {
  std::string yaml = "    regions:\n";
  const std::size_t from = drawn_.yaml.rfind("position: [") + 11;
  const std::string middle = drawn_.yaml.substr(from, drawn_.yaml.find(',', from) - from);
  for (int k = whole(1, 2); k > 0; --k) {
    yaml += fmt::format("      - {{box: {{min: [{}, -1, -1], max: [{}, 1, 1]}}", k > 1 ? middle : "-1",
                        k > 1 ? "1" : middle);
    if (chance(0.5)) yaml += fmt::format(", areal_density: {:.4g}", usually(0.05, 0.5, 1e-3, 100));
    if (chance(0.3)) yaml += fmt::format(", thickness: {:.4g}", thickness * uniform(0.3, 1));
    if (chance(0.5))
      yaml += fmt::format(", stretch: {:.4g}, bend: {:.4g}", usually(50, 5000, 1, 1e6), usually(1e-6, 1e-3, 1e-9, 1));
    if (chance(0.3))
      yaml += fmt::format(", damping: {:.3g}, friction: {:.3g}", usually(0.1, 10, 1e-3, 1000), uniform(0, 2));
    const std::size_t squeezed = pores.find("compressibility: ");  // at most 1 − Φ
    const double most_solid = squeezed == pores.npos ? 1 : 1 - std::stod(pores.substr(squeezed + 17));
    const bool wicks = pores.find("diffusivity: 0,") == pores.npos, anisotropic = pores.find("weft_") != pores.npos;
    if (!pores.empty() && chance(0.7))
      yaml += ", porous: {" +
              list_of({fmt::format("solid_fraction: {:.4g}, absorption: {:.3g}", most_solid * uniform(0, 0.9),
                                   usually(1e-3, 0.1, 1e-6, 100)),
                       wicks && !anisotropic ? fmt::format("diffusivity: {:.3g}", usually(1e-5, 1e-3, 1e-7, 1e-2)) : "",
                       chance(0.3) ? fmt::format("max_saturation: {:.4g}", uniform(1, 1.5)) : ""}) +
              "}";
    yaml += "}\n";
  }
  return yaml;
}

void SceneDraw::cloths() {
  drawn_.yaml += fmt::format("cloth_solver: {{method: {}, tolerance: {:.3g}, max_iterations: {}}}\n",
                             word({"pd", "pd", "xpbd"}), usually(1e-4, 1e-2, 1e-6, 0.5), whole(1, 300));
  drawn_.yaml += "cloth:\n";
  const int count = whole(1, 3);
  for (int n = 0; n < count; ++n) cloth(n, count - 1);
  // What drips between sheets finds no room (docs/limitations.md).
  drawn_.crowded = drips_ && count > 1;
}

std::string SceneDraw::motion() {
  std::string text;
  if (chance(0.2)) text += ", velocity: " + vector(-1, 1);
  if (chance(0.2))
    text += fmt::format(", spin: {{axis: {}, degrees_per_second: {:.4g}}}", vector(0.1, 1), uniform(-720, 720));
  if (text.empty())
    text += sometimes(0.15, [&] {
      return chance(0.5) ? ", velocity: " + keys(-1, 1, true)
                         : ", spin: {axis: [0.2, 1, 0.3], degrees_per_second: " + keys(-720, 720, false) + "}";
    });
  if (!text.empty()) drawn_.closed = false;
  text += sometimes(0.2, [&] { return fmt::format(", adhesion: {:.3g}", uniform(0, 0.1)); });
  text += sometimes(0.3, [&] { return chance(0.5) ? std::string(", slip: free") : std::string(", slip: 0.001"); });
  return text;
}

void SceneDraw::bodies() {
  std::string list;
  if (chance(0.5))
    list += fmt::format("  - plane: {{point: [0, {:.4g}, 0], normal: [{:.3g}, 1, {:.3g}]{}}}\n", uniform(-0.3, -0.15),
                        uniform(-0.3, 0.3), uniform(-0.3, 0.3), motion());
  if (chance(0.4)) list += "  - box: {min: [-0.35, -0.35, -0.35], max: [0.35, 0.45, 0.35], inside: true}\n";
  if (chance(0.5)) {
    const bool floats = chance(0.4);
    list +=
        fmt::format("  - sphere: {{center: [{:.4g}, {:.4g}, 0], radius: {:.4g}{}}}\n", uniform(-0.05, 0.05),
                    uniform(-0.15, -0.1), uniform(0.02, 0.05),
                    floats ? fmt::format(", dynamic: true, density: {:.4g}", usually(200, 3000, 1, 30000)) : motion());
  }
  if (chance(0.3))
    list += fmt::format("  - box: {{min: [0.1, -0.14, -0.03], max: [0.16, {:.4g}, 0.03]{}}}\n", uniform(-0.12, -0.08),
                        chance(0.4) ? ", dynamic: true" : motion());
  const std::string ball = "  - sphere: {", dynamic = "dynamic: true";
  std::string hinge;
  if (const std::size_t at = list.find(ball); at != list.npos && list.find(dynamic, at) < list.find('\n', at)) {
    const double speed = wild_ ? 3000 : 300;
    hinge = drawn_by(newest_, 0.4, [&] {
      const std::string motor = chance(0.5) ? fmt::format(", motor: {{degrees_per_second: {:.4g}, torque: {:.3g}}}",
                                                          uniform(-speed, speed), usually(0.01, 1, 1e-6, 1e9))
                                            : "";
      const std::string limits =
          chance(0.4) ? fmt::format(", limits: [{:.3g}, {:.3g}]", uniform(-180, 0), uniform(0, 180)) : "";
      return fmt::format("joints: [{{hinge: {{body: ball, point: {}, axis: {}{}{}}}}}]\n", vector(-0.15, 0.15),
                         vector(0.1, 1), limits, motor);
    });
    if (!hinge.empty()) {
      list.insert(at + 4, "name: ball\n    ");
      drawn_.closed = false;
    }
  }
  if (!list.empty()) drawn_.yaml += "bodies:\n" + list + hinge;
}

void SceneDraw::air() {
  std::string air = sometimes(0.12, [&] {
    const double fast = usually(1e-4, 0.05, 1e-9, 1);
    return chance(0.3)
               ? fmt::format("air: {{humidity: {:.3g}, temperature: {:.3g}, speed: {:.3g}, length: {:.3g}}}\n",
                             uniform(0, 1), uniform(0, 60), usually(0.1, 10, 0.01, 100), usually(0.05, 2, 1e-3, 1000))
               : fmt::format("air: {{evaporation_rate: {:.3g}}}\n", fast);
  });
  if (air.empty()) return;
  const std::string cooling = drawn_by(latest_, air.find("humidity") == std::string::npos ? 0 : 0.5,
                                       [] { return std::string(", cooling: true"); });
  air.insert(air.size() - 2, cooling);
  drawn_.closed = false;
  drawn_.yaml += air;
  const std::string from = "porous: {";
  const double critical = uniform(0, 1);
  if (const std::size_t at = drawn_.yaml.find(from); at != std::string::npos)
    drawn_.yaml.insert(at + from.size(), fmt::format("critical_saturation: {:.3g}, ", critical));
}

void SceneDraw::rotating_frame() {
  const std::string frame =
      drawn_by(latest_, drawn_.yaml.find("dynamic: true") == std::string::npos ? 0.1 : 0, [&]() -> std::string {
        const std::size_t given = drawn_.yaml.find("gravity: ["), at = given + std::size("gravity: ") - 1;
        const std::string gravity =
            given == std::string::npos ? "[0, 1, 0]" : drawn_.yaml.substr(at, drawn_.yaml.find(']', at) + 1 - at);
        const std::string axis = gravity == "[0, 0, 0]" ? vector(0.1, 1) : gravity, center = vector(-0.3, 0.3);
        return fmt::format("rotating_frame: {{axis: {}, center: {}, degrees_per_second: {}}}\n", axis, center,
                           keys(-800, 800, false));
      });
  if (!frame.empty()) drawn_.closed = false;
  drawn_.yaml += frame;
}

RandomScene SceneDraw::scene() {
  drawn_ = {};
  drawn_.closed = drawn_.ordinary = drawn_.bounded = true;
  drawn_.folds = drawn_.crowded = false;
  moving_pins_ = drips_ = false;
  wild_ = chance(0.5);
  begin();
  fluid();
  const bool cloth = chance(0.9);
  if (cloth) cloths();
  bodies();
  drawn_.folds = drawn_.yaml.find("self_collision") != std::string::npos;
  // The force of pins is without that of contacts of cloth with itself.
  if (drawn_.folds && moving_pins_) drawn_.closed = false;
  // Switches are for porous cloth alone.
  const std::string numbers = sometimes(0.2, [] { return std::string("fabric: true, "); });
  if (const std::size_t at = drawn_.yaml.find("measures: true");
      at != std::string::npos && drawn_.yaml.find("porous:") != std::string::npos)
    drawn_.yaml.insert(at, numbers);
  if (drawn_.yaml.find("porous:") != std::string::npos && chance(0.4)) {
    const bool control = chance(0.7);
    drawn_.bounded = control;
    drawn_.yaml += fmt::format(
        "processes: {{direction: {}, saturation_control: {}, absorption: {}, emission: {}, diffusion: {}}}\n",
        chance(0.6), control, chance(0.8), chance(0.8), chance(0.8));
  }
  air();
  rotating_frame();
  return drawn_;
}

}  // namespace drench::test
