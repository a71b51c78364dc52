#include "output/checkpoint.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <regex>
#include <string_view>
#include <type_traits>
#include <utility>

#include "base/version.hpp"
#include "output/text_file.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

static_assert(std::endian::native == std::endian::little, "checkpoints are little-endian");

constexpr std::string_view magic = "drench checkpoint ", format = "1\n";

/// FNV-1a, 64 bits.
class Checksum {
 public:
  void add(const void* data, std::size_t size) {
    const auto* byte = static_cast<const unsigned char*>(data);
    for (std::size_t k = 0; k < size; ++k) value_ = (value_ ^ byte[k]) * 0x100000001b3U;
  }
  template <class T>
  void add(const std::vector<T>& values) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_same_v<T, Vec3> ||
                  std::is_same_v<T, std::array<double, 3>>);
    add(values.data(), values.size() * sizeof(T));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

/// Calls visit(name, field) for everything in a checkpoint: strings, numbers and vectors.
template <class C, class Visitor>
void visit_checkpoint(C& c, Visitor&& visit) {
  visit("version", c.version);
  visit("commit", c.commit);
  visit("precision", c.precision);
  visit("backend", c.backend);
  visit("scene", c.scene);
  visit("geometry", c.geometry);
  visit("frames", c.frames);
  visit("shortened", c.shortened);
  visit("changes", c.changes);
  visit("probe_sums", c.probe_sums);
  visit("step", c.state.step);
  visit("time", c.state.time);
  visit("collapsing", c.state.collapsing);
  visit("divergence_start", c.state.divergence_start);
  visit("density_start", c.state.density_start);
  visit("next_step", c.state.next_step);
  visit("uptake_rate", c.state.uptake_rate);
  visit("drained", c.state.drained);
  visit("supplied", c.state.supplied);
  visit("evaporated", c.state.evaporated);
  visit("solute_drained", c.state.solute_drained);
  visit("solute_supplied", c.state.solute_supplied);
  visit("solute_deposited", c.state.solute_deposited);
  visit("next_id", c.state.next_id);
  visit("jet_particles", c.state.jet_particles);
  visit_fields(c.state, visit);
}

/// A file that is written to the disk itself, not only to the system's memory.
class DiskFile {
 public:
  explicit DiskFile(const fs::path& path) : file_(open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (file_ < 0) fail();
  }
  ~DiskFile() {
    if (file_ >= 0) close(file_);
  }
  DiskFile(const DiskFile&) = delete;
  DiskFile& operator=(const DiskFile&) = delete;

  void write(const void* data, std::size_t size) {
    sum_.add(data, size);
    for (const char* at = static_cast<const char*>(data); size > 0;) {
      const ssize_t done = ::write(file_, at, std::min(size, std::size_t{1} << 30));
      if (done < 0 && errno == EINTR) continue;
      if (done < 0) fail();
      at += done;
      size -= static_cast<std::size_t>(done);
    }
  }
  template <class T>
  void record(std::string_view name, const T& field) {
    const char* data = nullptr;
    std::uint32_t bytes = sizeof(T);
    std::uint64_t count = 1;
    if constexpr (std::is_arithmetic_v<T>) {
      data = reinterpret_cast<const char*>(&field);
    } else {
      data = reinterpret_cast<const char*>(field.data());
      bytes = sizeof(typename T::value_type);
      count = field.size();
    }
    const auto length = static_cast<std::uint32_t>(name.size());
    write(&length, sizeof length);
    write(name.data(), name.size());
    write(&bytes, sizeof bytes);
    write(&count, sizeof count);
    write(data, bytes * count);
  }
  void finish() {
    const std::uint64_t sum = sum_.value();
    write(&sum, sizeof sum);
    const int file = std::exchange(file_, -1);
    const bool synced = fsync(file) == 0;
    const int why = errno;
    const bool closed = close(file) == 0;
    if (!synced) errno = why;
    if (!synced || !closed) fail();
  }

 private:
  [[noreturn]] static void fail() { throw std::runtime_error(std::strerror(errno)); }

  int file_;
  Checksum sum_;
};

struct Record {
  std::uint32_t bytes = 0;
  std::uint64_t count = 0;
  const char* data = nullptr;
};

/// The records between the first line and the checksum.
std::map<std::string, Record, std::less<>> records_of(std::string_view text, const fs::path& path) {
  const auto take = [&](std::size_t size) {
    if (text.size() < size) throw DamagedCheckpoint(fmt::format("{}: is damaged: a record is cut off", path.string()));
    const char* data = text.data();
    text.remove_prefix(size);
    return data;
  };
  const auto number = [&]<class T>(T value) {
    std::memcpy(&value, take(sizeof value), sizeof value);
    return value;
  };
  std::map<std::string, Record, std::less<>> records;
  while (!text.empty()) {
    const auto length = number(std::uint32_t{});
    const std::string name(take(length), length);
    Record record{number(std::uint32_t{}), number(std::uint64_t{}), nullptr};
    if (record.bytes == 0 || record.count > text.size() / record.bytes) take(text.size() + 1);
    record.data = take(record.bytes * record.count);
    records[name] = record;
  }
  return records;
}

std::string whole_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (fs::is_directory(path)) in.setstate(std::ios::failbit), errno = EISDIR;
  const auto end = in ? static_cast<std::streamoff>(in.tellg()) : -1;
  std::string text(static_cast<std::size_t>(std::max<std::streamoff>(end, 0)), '\0');
  in.seekg(0);
  in.read(text.data(), end);
  if (end < 0 || !in) throw CheckpointError(fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
  return text;
}

/// What was read from the files of sequences beside deforming bodies. Liquid is read during the run: of its files only
/// the names and sizes are compared.
void add_sequences(Checksum& sum, const Model& model) {
  const auto add_keys = [&](const auto& keys) { sum.add(keys.data(), keys.size() * sizeof keys[0]); };
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (model.scene.bodies[b].sequence.files.empty()) continue;
    add_keys(model.bodies[b].path.keys());
    add_keys(model.bodies[b].turns);
  }
  const auto follows_files = [](const PinScene& pin) { return !pin.sequence.files.empty(); };
  if (std::any_of(model.scene.cloths.begin(), model.scene.cloths.end(), [&](const ClothScene& cloth) {
        return std::any_of(cloth.pins.begin(), cloth.pins.end(), follows_files);
      }))
    for (const PinMotion& motion : model.pin_motions) add_keys(motion.path.keys());
  for (std::size_t j = model.jets.size() - model.scene.fluid.mesh_jets.size(); j < model.jets.size(); ++j) {
    sum.add(model.jets[j].offsets);
    for (const std::vector<Vec3>& points : model.jets[j].mouth->points) sum.add(points);
    add_keys(model.jets[j].mouth->time);
    add_keys(model.jets[j].mouth->area.keys());
  }
  for (const BlockScene& block : model.scene.fluid.blocks)
    for (const std::string& file : block.sequence.files) {
      std::error_code error;
      const std::string text = fmt::format("{} {}\n", fs::path(file).filename().string(), fs::file_size(file, error));
      sum.add(text.data(), text.size());
    }
}

}  // namespace

void write_checkpoint(const fs::path& path, const Checkpoint& checkpoint) {
  const fs::path temporary = temporary_name(path);
  try {
    DiskFile file(temporary);
    file.write(magic.data(), magic.size());
    file.write(format.data(), format.size());
    visit_checkpoint(checkpoint, [&](std::string_view name, const auto& field) { file.record(name, field); });
    file.finish();
  } catch (const std::exception& e) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw std::runtime_error(fmt::format("{}: cannot be written: {}", path.string(), e.what()));
  }
  rename_into_place(temporary, path);
  sync_to_disk(path.parent_path());
}

Checkpoint read_checkpoint(const fs::path& path) {
  const std::string file = whole_file(path);
  std::string_view text = file;
  if (!text.starts_with(magic)) throw CheckpointError(fmt::format("{}: is not a checkpoint of drench", path.string()));
  text.remove_prefix(magic.size());
  const auto newer = [&](std::string_view what, std::string_view theirs, std::string_view ours) {
    return CheckpointError(fmt::format("{}: {} {}, this drench is {}", path.string(), what, theirs, ours));
  };
  std::uint64_t sum = 0;
  if (text.size() < format.size() + sizeof sum)
    throw DamagedCheckpoint(fmt::format("{}: is damaged: it is cut off", path.string()));
  std::memcpy(&sum, file.data() + file.size() - sizeof sum, sizeof sum);
  Checksum checksum;
  checksum.add(file.data(), file.size() - sizeof sum);
  if (checksum.value() != sum)
    throw DamagedCheckpoint(fmt::format("{}: is damaged: its checksum is wrong", path.string()));
  if (!text.starts_with(format)) throw newer("has the format", text.substr(0, text.find('\n')), format.substr(0, 1));
  text.remove_prefix(format.size());
  text.remove_suffix(sizeof sum);

  const auto records = records_of(text, path);
  if (const auto found = records.find("version"); found != records.end()) {
    const std::string_view version(found->second.data, found->second.count);
    if (version != version_string) throw newer("was written by version", version, version_string);
  }
  Checkpoint checkpoint;
  visit_checkpoint(checkpoint, [&]<class T>(std::string_view name, T& field) {
    const auto found = records.find(name);
    if (found == records.end() && name == "changes") return;     // as older ones, whose run nobody changed
    if (found == records.end() && name == "probe_sums") return;  // as older ones
    if (found == records.end() && name.find("solute") != std::string_view::npos)
      return;  // as those before there were any
    if (found == records.end()) throw CheckpointError(fmt::format("{}: has no {}", path.string(), name));
    const Record& record = found->second;
    bool fits = record.bytes == sizeof(T) && record.count == 1;
    if constexpr (!std::is_arithmetic_v<T>) fits = record.bytes == sizeof(typename T::value_type);
    if (!fits) throw CheckpointError(fmt::format("{}: its {} has another type", path.string(), name));
    void* to = &field;
    if constexpr (!std::is_arithmetic_v<T>) {
      field.resize(record.count);
      to = field.data();
    }
    if (record.count > 0) std::memcpy(to, record.data, record.bytes * record.count);
  });
  return checkpoint;
}

std::string checkpoint_name(std::int64_t step) { return fmt::format("checkpoint_{:06}.drench", step); }

std::int64_t checkpoint_step(const fs::path& path) {
  static const std::regex ours(R"(checkpoint_(\d{6,18})\.drench)");
  const std::string name = path.filename().string();
  std::smatch match;
  return std::regex_match(name, match, ours) ? std::stoll(match[1].str()) : -1;
}

std::vector<fs::path> checkpoints_in(const fs::path& folder) {
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && checkpoint_step(entry.path()) >= 0) found.push_back(entry.path());
  std::sort(found.begin(), found.end(),
            [](const fs::path& a, const fs::path& b) { return checkpoint_step(a) > checkpoint_step(b); });
  return found;
}

std::uint64_t geometry_of(const Model& model) {
  Checksum sum;
  sum.add(model.mesh.rest_position);
  sum.add(model.mesh.triangle);
  sum.add(model.mesh.pinned);
  if (model.has_stitches()) sum.add(model.mesh.stitch);
  if (model.has_regions()) sum.add(model.mesh.triangle_material);
  sum.add(model.samples.triangle);
  sum.add(model.samples.weight);
  sum.add(model.boundary.position);
  for (const Body& body : model.bodies) {
    sum.add(body.mesh_points);
    sum.add(body.mesh_triangles);
    for (const std::vector<Vec3>& points : body.shape.points) sum.add(points);
    sum.add(body.shape.time.data(), body.shape.time.size() * sizeof(double));
  }
  add_sequences(sum, model);
  return sum.value();
}

}  // namespace drench
