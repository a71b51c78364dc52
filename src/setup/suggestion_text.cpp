#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "base/eigen_vec.hpp"
#include "scene/fabric_file.hpp"
#include "setup/file_place.hpp"
#include "setup/suggestion.hpp"

namespace drench {
namespace {

using Eigen::Vector3d;

std::string pin_line(const Suggestion& s) {
  const Garment& g = s.garment;
  if (g.flat && g.open) return "    pin: [{edges: true}]              # held at its edges; without pins it falls\n";
  const Box band = top_band(g);
  const double unit = std::pow(10, std::floor(std::log10(g.size)) - 3);
  Box box = band;
  for (std::size_t a = 0; a < 3; ++a) {
    box.min[a] = outward(band.min[a], unit, false);
    box.max[a] = outward(band.max[a], unit, true);
  }
  return fmt::format("    pin: [{{box: {{min: {}, max: {}}}}}]   # m; held at its highest points\n", list(box.min),
                     list(box.max));
}

/// ", unit: cm, up: z" as far as they are not the defaults.
std::string coordinates(const MeshGuess& guess) {
  std::string keys;
  if (guess.unit != LengthUnit::m) keys += fmt::format(", unit: {}", name_of(guess.unit));
  if (guess.up != UpAxis::y) keys += fmt::format(", up: {}", name_of(guess.up));
  return keys;
}

/// "; unit cm: it is 90 units long; up z: …"
std::string reasons(const MeshGuess& guess) {
  std::string text;
  if (!guess.unit_reason.empty()) text += fmt::format("; unit {}: {}", name_of(guess.unit), guess.unit_reason);
  if (!guess.up_reason.empty()) text += fmt::format("; up {}: {}", name_of(guess.up), guess.up_reason);
  return text;
}

/// The quoted name of a file in the scene.
std::string written(const Suggestion& s, const std::string& file) {
  return in_quotes(s.paths == MeshPaths::absolute ? std::filesystem::absolute(file).string() : file);
}

const char* kind_of_path(const Suggestion& s, const std::string& file) {
  const bool absolute = s.paths == MeshPaths::absolute || std::filesystem::path(file).is_absolute();
  return absolute ? "absolute path" : "relative to the folder of this file";
}

std::string mesh_lines(const Suggestion& s) {
  const Garment& g = s.garment;
  if (s.mesh.empty())
    return fmt::format("    mesh: {{grid: {{size: [{}, {}], nodes: [{}, {}]}}}}   # m; or {{file: garment.obj}}\n",
                       suggested_grid.size[0], suggested_grid.size[1], suggested_grid.nodes[0],
                       suggested_grid.nodes[1]);
  std::string lines = fmt::format("    mesh: {{file: {}{}}}   # {}{}\n", written(s, s.mesh), coordinates(g.guess),
                                  kind_of_path(s, s.mesh), reasons(g.guess));
  if (g.shift != Vec3{0, 0, 0})
    lines += fmt::format("    place: {{position: {}}}   # m; moves it {}\n", list(g.shift),
                         s.worn ? "onto the body" : "to the origin, where rounding is smallest");
  if (g.weld > 0)
    lines += fmt::format("    weld: {:<28.6g} # m; sews {} pairs of boundary points more than the default\n", g.weld,
                         g.welded);
  return lines;
}

/// Is it along no axis?
bool is_tilted(const Vec3& direction) { return direction[0] != 0; }

std::string fabric_lines(const Suggestion& s) {
  const std::string damping = "    damping: 1.0                      # 1/s; damping of the motion, as by air\n";
  if (s.fabric.empty())
    return fmt::format(
               "    areal_density: 0.2                # kg/m², 200 g/m²; cotton shirt 0.15, towel 0.4\n"
               "    thickness: {}                  # m; with solid_fraction it determines how much water the fabric "
               "holds\n"
               "    stretch: 500                      # N/m; tensile stiffness\n"
               "    bend: {:<28} # N·m; bending stiffness: limp fabric 1e-5, stiff 1e-3\n",
               s.thickness, s.bend > 0 ? fmt::format("{:.1e}", s.bend) : "0") +
           damping +
           "    friction: 0.4                     # 1; of dry fabric, on bodies and on itself\n"
           "    friction_wet: 1.0                 # 1; wet fabric clings\n";
  std::string lines =
      is_fabric_file(s.fabric)
          ? fmt::format("    fabric: {}   # {}; drench check prints its values\n", written(s, s.fabric),
                        kind_of_path(s, s.fabric))
          : fmt::format("    fabric: {:<25} # drench check prints its values; a key below replaces one\n", s.fabric);
  if (s.whole_thickness > 0)
    lines +=
        fmt::format("    thickness: {:<22} # m; the fabric's is too thick for the smallest triangle\n", s.thickness);
  if (s.warp)
    lines +=
        fmt::format("    warp: {:<27} # direction of the warp, which the file's texture coordinates do not give{}\n",
                    list(*s.warp), is_tilted(*s.warp) ? "; tilted, as some triangles lie across the upright" : "");
  return lines + damping;
}

std::string porous_lines(const Suggestion& s) {
  if (!s.fabric.empty()) return "    porous: {}                        # without this key the cloth absorbs nothing\n";
  return fmt::format(
      "    porous:                           # without this section the cloth absorbs nothing\n"
      "      solid_fraction: {}             # 1; fraction of the volume that is fibre; the rest holds water\n"
      "      absorption: 0.02                # m²/s; how fast dry fabric absorbs water\n"
      "      film: 3.0e-4                    # m; water that each face of soaked fabric carries; it runs down and "
      "drips\n"
      "      film_viscosity: 1.0e-6          # m²/s; of water\n"
      "      diffusivity: 1.0e-4             # m²/s; how fast water spreads within the fabric\n"
      "      capillary_height: 0.3           # m; equilibrium wicking height\n",
      s.solid_fraction);
}

std::string body_lines(const Suggestion& s) {
  if (s.body.empty())
    return fmt::format(
        "# bodies:                             # a floor, so that it does not fall out of the domain\n"
        "#   - plane: {{point: [0, {:.6g}, 0], normal: [0, 1, 0]}}   # m\n",
        s.domain.min[1] + 0.1 * s.garment.size);
  const std::string motion = s.animated ? fmt::format(", fps: {:.9g}", s.body_rate) : "";
  return fmt::format("bodies:\n  - mesh: {{{}: {}{}{}}}   # {}{}\n", s.animated ? "sequence" : "file",
                     written(s, s.body), motion, coordinates(s.body_guess), kind_of_path(s, s.body),
                     reasons(s.body_guess));
}

std::string head(const Suggestion& s) {
  const Garment& g = s.garment;
  const Vector3d sides = to_eigen(g.box.max) - to_eigen(g.box.min);
  std::string text =
      fmt::format("# A first scene for {}, by drench new. SI units: m, s, kg. Every key: drench schema\n#\n",
                  s.mesh.empty() ? "a square cloth" : s.mesh);
  if (!g.unit_warning.empty()) text += fmt::format("# {}.\n#\n", g.unit_warning);
  for (const std::string& line : s.found) text += fmt::format("# {}.\n", line);
  if (!s.found.empty()) text += "#\n";
  return text + fmt::format(
                    "# {:.3g} × {:.3g} × {:.3g} m, {} points, {} triangles, edges of {:.2g} m. It holds {:.2g} "
                    "kg of water.\n"
                    "# What to expect: {:.3g} kg of water {}; the cloth darkens where it is wet, and drips.\n"
                    "# drench check prints the size of a run; half the spacing takes about 16 times as long.\n",
                    sides[0], sides[1], sides[2], g.mesh.points.size(), g.mesh.triangles.size(), g.edge, s.capacity,
                    s.jet_mass, g.flat ? "falls on its middle" : "hits it");
}

}  // namespace

std::string in_quotes(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

double outward(double x, double unit, bool up) {
  return (up ? std::ceil(x / unit - 1e-9) : std::floor(x / unit + 1e-9)) * unit;
}

std::string list(const Vec3& v) { return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v[0] + 0.0, v[1] + 0.0, v[2] + 0.0); }

std::string text_of(const Suggestion& s, bool with_body) {
  std::string text = head(s);
  text += fmt::format(
      "drench: 1                             # version of the format\n"
      "time: {{step: {}, end: {:.6g}, mode: cfl}}   # s; step: longest step at which the cloth converges; fast water "
      "shortens steps\n"
      "gravity: [0, -9.81, 0]                # m/s²; y is up\n"
      "domain: {{min: {}, max: {}}}   # m; water that leaves it is drained\n"
      "output: {{every: {}, surface: true}}   # s between frames; also writes the surface of the liquid\n",
      s.step, s.end, list(s.domain.min), list(s.domain.max), s.every);
  text += fmt::format(
      "fluid:\n"
      "  spacing: {}                      # m; particle diameter; the cloth's edges are {:.1f} times as long, 1 to 2 "
      "is "
      "best\n"
      "  density: 1000                       # kg/m³; water\n"
      "  viscosity: 1.0e-4                   # m²/s; water has 1e-6; a larger value calms splashes at this spacing\n"
      "  sources:\n"
      "    - jet: {{center: {}, radius: {}, velocity: {}, end: {}}}   # m, m, m/s, s; {:.1f} times what the cloth "
      "can hold\n",
      s.spacing, s.garment.edge / s.spacing, list(s.nozzle), s.radius, list(s.velocity), s.jet_end,
      s.jet_mass / s.capacity);
  text += "cloth:\n  - name: " + std::string(s.mesh.empty() ? "sheet" : "garment") + "\n" + mesh_lines(s);
  text += fabric_lines(s);
  if (s.pinned) text += pin_line(s);
  text += fmt::format("    self_collision: {}\n",
                      s.self_collision ? "true              # front and back do not pass through each other; costs time"
                                       : "false             # true for cloth that folds onto itself; costs time");
  if (s.settle != ClothScene{}.settle)
    text += fmt::format("    settle: {:<25} # 1; steps over which nodes come out of the body, at most {} m/s fast\n",
                        s.settle, fastest_release);
  text += porous_lines(s);
  if (with_body || s.body.empty()) text += body_lines(s);
  return text;
}

}  // namespace drench
