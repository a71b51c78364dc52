#include "app/resume.hpp"

#include <fmt/format.h>

#include "base/version.hpp"
#include "output/run_folder.hpp"
#include "output/stats_csv.hpp"
#include "scene/load.hpp"
#include "scene/scene_difference.hpp"
#include "state/needed_fields.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

/// "kokkos, OpenMP": the second is what the backend was built for.
std::string backend_label(const Backend& backend) {
  const std::string line = "backend: ", text = backend.description();
  if (!text.starts_with(line)) return backend.name();
  return backend.name() + ", " + text.substr(line.size(), text.find('\n') - line.size());
}

/// What the model begins with decides all but the liquid's arrays.
bool fits(const HostState& s, const Model& m) {
  bool whole = true;
  visit_fields(s, [&](std::string_view name, const auto& values) {
    const std::size_t particles = needs_field(m, name) ? s.fluid_position.size() : 0;
    if (name.starts_with("fluid_")) whole = whole && values.size() == particles;
    const std::size_t nodes = needs_field(m, name) ? m.mesh.rest_position.size() : 0;
    if (name.starts_with("node_")) whole = whole && values.size() == nodes;
    if (name.starts_with("body_")) whole = whole && values.size() == m.bodies.size();
    if (name.starts_with("boundary_")) whole = whole && values.size() == m.boundary.position.size();
    if (name.starts_with("sample_")) whole = whole && (values.empty() || values.size() == m.samples.triangle.size());
  });
  return whole && s.jet_particles.size() == m.jets.size();
}

void check(const Resume& r, const Checkpoint& now, const Model& model) {
  const Checkpoint& c = r.checkpoint;
  const auto refuse = [&](const std::string& why) {
    throw CheckpointError(fmt::format("{}: {}", r.path.string(), why));
  };
  if (c.precision != now.precision)
    refuse(fmt::format("was computed in {} precision, this run uses {}", c.precision, now.precision));
  if (c.backend != now.backend)
    refuse(fmt::format("was computed by backend {}, this run uses {}", c.backend, now.backend));
  if (const auto difference = scene_difference(c.scene, now.scene, resumable_keys))
    refuse(fmt::format("is of another scene: {}; only {} may change", *difference, fmt::join(resumable_keys, ", ")));
  if (c.geometry != now.geometry) refuse("is of another scene: its meshes or the files of a sequence have changed");
  if (!fits(c.state, model)) refuse("its array sizes differ from those of the scene");
}

/// What of the run's output up to the checkpoint is not there, "" if all is.
std::string missing_output(const Resume& r, const Model& model) {
  if (!StatsCsv::rows_until(r.folder / "stats.csv", r.checkpoint.state.step))
    return fmt::format("stats.csv has no row of step {}", r.checkpoint.state.step);
  const std::pair<const char*, bool> series[] = {{"fluid", model.has_fluid()},
                                                 {"surface", model.has_surface()},
                                                 {"cloth", model.has_cloth()},
                                                 {"bodies", model.has_moving_body()}};
  for (const auto& [name, wanted] : series) {
    const auto frame = fmt::format("frames/{}_{:06}.vtu", name, r.checkpoint.frames - 1);
    if (wanted && r.checkpoint.frames > 0 && !fs::exists(r.folder / frame)) return frame + " is missing";
  }
  return "";
}

}  // namespace

Checkpoint checkpoint_header(const Model& model, const Backend& backend) {
  Checkpoint c;
  c.version = version_string;
  c.commit = git_commit;
  c.precision = backend.name() == "reference" ? "double" : std::string(precision_name);
  c.backend = backend_label(backend);
  c.scene = to_yaml(model.scene);
  c.geometry = geometry_of(model);
  return c;
}

Resume find_checkpoint(const std::string& wanted, const Model& model, const Backend& backend, For whom) {
  const bool any = fs::is_directory(wanted);
  const std::vector<fs::path> candidates = any ? checkpoints_in(wanted) : std::vector<fs::path>{wanted};
  if (candidates.empty()) throw CheckpointError(fmt::format("{}: holds no checkpoint", wanted));
  const Checkpoint now = checkpoint_header(model, backend);
  Resume found;
  for (const fs::path& path : candidates) {
    found.path = path;
    const fs::path folder = path.has_parent_path() ? path.parent_path() : ".";
    found.folder = holds_run(folder) ? folder : fs::path();
    try {
      found.checkpoint = read_checkpoint(path);
      check(found, now, model);
      if (whom == For::command && !found.checkpoint.changes.empty())
        throw CheckpointError(fmt::format(
            "{}: its bodies, pins, jets or wind were changed by a program: continue with drench.Simulation.resume",
            path.string()));
      const bool no_folder = found.folder.empty() || whom == For::library;
      const std::string missing = no_folder ? "" : missing_output(found, model);
      if (!missing.empty()) throw DamagedCheckpoint(fmt::format("{}: cannot be continued: {}", path.string(), missing));
      break;
    } catch (const DamagedCheckpoint& e) {
      if (path == candidates.back()) throw;
      found.warnings.push_back(fmt::format("{}; continuing from the previous one", e.what()));
    }
  }
  const bool other_end =
      scene_difference(found.checkpoint.scene, now.scene, {"output.every", "output.checkpoint_every"}).has_value();
  if (found.checkpoint.shortened != 0 && other_end)
    found.warnings.push_back(fmt::format(
        "{}: time.end shortened its last step, so the continued run differs in bits from one without that end",
        found.path.string()));
  if (found.checkpoint.commit != now.commit)
    found.warnings.push_back(fmt::format("{}: was written by commit {}, this is {}: results may differ in bits",
                                         found.path.string(), found.checkpoint.commit, now.commit));
  return found;
}

}  // namespace drench
