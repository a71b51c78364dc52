#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <vector>

#include "app/cloth_texture.hpp"
#include "app/commands.hpp"
#include "app/python.hpp"
#include "output/particle_file.hpp"
#include "output/recorded_frames.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

/// What of the resolved scene the frames do not say.
struct SceneFacts {
  std::vector<std::string> cloths;  // names, in the order of the frames' field `cloth`
  char up = 'Y';                    // the axis against gravity; USD allows Y and Z
  bool mesh_files = false;          // has a cloth or a body one?
  std::string warning;              // one line, "" for none
};

SceneFacts read_scene(const fs::path& folder) {
  SceneFacts facts;
  try {
    const YAML::Node scene = YAML::LoadFile((folder / "scene.yaml").string());
    for (const YAML::Node& cloth : scene["cloth"]) {
      facts.cloths.push_back(cloth["name"].as<std::string>());
      if (const YAML::Node mesh = cloth["mesh"]; mesh && mesh.IsMap() && mesh["file"]) facts.mesh_files = true;
    }
    for (const YAML::Node& body : scene["bodies"])
      if (body["mesh"]) facts.mesh_files = true;
    const auto g = scene["gravity"].as<std::vector<double>>();
    if (g.size() != 3) return facts;
    if (std::abs(g[2]) > std::abs(g[1]) && std::abs(g[2]) >= std::abs(g[0])) facts.up = 'Z';
    const double along = facts.up == 'Z' ? g[2] : g[1];
    if (along > 0 || std::hypot(g[0], g[1], g[2]) - std::abs(along) > 1e-3 * std::abs(along))
      facts.warning = fmt::format("gravity [{}, {}, {}] is not along −y or −z; the USD file declares {} as up", g[0],
                                  g[1], g[2], facts.up);
  } catch (const YAML::Exception& e) {
    facts.warning = fmt::format("{}: cannot be read ({}): cloths are exported without names, with y up",
                                (folder / "scene.yaml").string(), e.msg);
  }
  return facts;
}

void warn(const std::string& line) { fmt::print(stderr, "warning: {}\n", line); }

std::vector<double> times_of(const std::vector<RecordedFrame>& frames) {
  std::vector<double> times;
  times.reserve(frames.size());
  for (const RecordedFrame& frame : frames) times.push_back(frame.time);
  return times;
}

/// The series of the run that has the most frames: bodies that stand still have only one.
std::vector<RecordedFrame> leading_series(const fs::path& folder) {
  std::vector<RecordedFrame> most;
  for (const char* name : {"fluid", "cloth", "surface", "bodies"})
    if (auto frames = recorded_frames(folder, name); frames.size() > most.size()) most = std::move(frames);
  if (most.empty())
    throw ExportError(
        fmt::format("{}: holds no frames of a run (fluid.pvd, cloth.pvd, surface.pvd or bodies.pvd)", folder.string()));
  return most;
}

/// Was it written by an earlier export? A .ply file has a comment of it, and a .bgeo file these attributes.
bool is_exported(const fs::path& file, const std::string& ending) {
  std::string head(400, '\0');
  std::ifstream(file, std::ios::binary).read(head.data(), std::ssize(head));
  const auto has = [&](const char* text) { return head.find(text) != std::string::npos; };
  return ending == "ply" ? has("comment drench:") : has("density") && has("pressure") && has("pscale") && has("age");
}

/// Files of earlier exports to this folder, by their numbers. ExportError: one with such a name is of something else.
std::map<std::size_t, fs::path> earlier_files(const fs::path& folder, const std::string& ending) {
  const std::regex ours(fmt::format(R"(fluid_(\d{{6,9}})\.{})", ending));
  std::map<std::size_t, fs::path> earlier;
  std::smatch match;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (!std::regex_match(name, match, ours)) continue;
    if (!is_exported(entry.path(), ending))
      throw ExportError(fmt::format(
          "{}: is not of drench export, which would replace it; choose another folder with -o", entry.path().string()));
    earlier.emplace(std::stoull(match[1].str()), entry.path());
  }
  return earlier;
}

int export_particles(const ExportOptions& options) {
  const fs::path folder = options.folder;
  const std::vector<RecordedFrame> frames = recorded_frames(folder, "fluid");
  if (frames.empty())
    throw ExportError(
        fmt::format("{}: holds no particles (fluid.pvd); --to {} writes nothing else", folder.string(), options.to));
  std::vector<std::size_t> pictures;
  if (options.fps) {
    const std::vector<double> times = times_of(frames);
    if (const auto misfit = rate_misfit(times, *options.fps)) warn("--fps: " + *misfit);
    pictures = frames_of_pictures(times, *options.fps);
  } else {
    for (std::size_t i = 0; i < frames.size(); ++i) pictures.push_back(i);
  }
  const fs::path target = options.output ? fs::path(*options.output) : folder / options.to;
  if (fs::exists(target) && !fs::is_directory(target))
    throw ExportError(fmt::format("{}: is not a folder; choose another with -o", target.string()));
  fs::create_directories(target);
  const auto earlier = earlier_files(target, options.to);
  vtkIdType particles = 0;
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    const RecordedFrame& frame = frames[pictures[k]];
    const auto grid = read_vtu(frame.files.back());
    const fs::path file = target / fmt::format("fluid_{:06}.{}", k, options.to);
    if (options.to == "bgeo")
      write_bgeo(file, grid);
    else
      write_ply(file, grid, frame.time);
    particles = grid->GetNumberOfPoints();
  }
  // A player would go on with those after the last.
  for (auto file = earlier.lower_bound(pictures.size()); file != earlier.end(); ++file) fs::remove(file->second);
  fmt::print("{}: {} files, fluid_000000.{} to fluid_{:06}.{}, {} particles in the last\n", target.string(),
             pictures.size(), options.to, pictures.size() - 1, options.to, particles);
  return exit_done;
}

[[noreturn]] void export_usd(const ExportOptions& options) {
  fs::path folder = fs::path(options.folder).lexically_normal();
  const std::vector<double> times = times_of(leading_series(folder));
  const double rate = options.fps.value_or(frame_rate(times));
  if (const auto misfit = rate_misfit(times, rate)) warn(options.fps ? "--fps: " + *misfit : *misfit);
  const SceneFacts scene = read_scene(folder);
  if (!scene.warning.empty()) warn(scene.warning);
  const fs::path absolute = fs::weakly_canonical(folder);
  const std::string file = options.output.value_or((folder / (absolute.filename().string() + ".usdc")).string());
  std::vector<std::string> words{folder.string(),         file, "--rate", fmt::format("{:.17g}", rate), "--up",
                                 std::string(1, scene.up)};
  for (const std::string& name : scene.cloths) words.push_back("--cloth=" + name);
  if (options.wet_maps || options.wet_textures) words.push_back("--wet-maps");
  if (options.wet_textures) words.push_back(fmt::format("--wet-textures={}", *options.wet_textures));
  std::vector<std::string> warnings;
  bool body_texture = false;
  if (scene.mesh_files || options.wet_textures)
    for (std::string& word : texture_arguments(folder, warnings)) {
      body_texture |= word.starts_with("--body-texture");
      words.push_back(std::move(word));
    }
  if (options.wet_textures && !body_texture)
    throw ExportError("--wet-textures: no body has a mesh file with texture coordinates (vt in .obj)");
  for (const std::string& line : warnings) warn(line);
  become_python("write_usd.py", words);
}

}  // namespace

int export_command(const ExportOptions& options) {
  if (!fs::is_directory(options.folder)) throw ExportError(fmt::format("{}: no such folder", options.folder));
  if (options.to != "usd" && (options.wet_maps || options.wet_textures))
    throw ExportError(fmt::format("{}: applies only to --to usd", options.wet_maps ? "--wet-maps" : "--wet-textures"));
  try {
    if (options.to == "usd") export_usd(options);
    return export_particles(options);
  } catch (const fs::filesystem_error& e) {
    throw ExportError(fmt::format("{}: {}", e.path1().string(), e.code().message()));
  } catch (const ExportError&) {
    throw;
  } catch (const std::runtime_error& e) {  // frames that cannot be read, files that cannot be written
    throw ExportError(e.what());
  }
}

}  // namespace drench
