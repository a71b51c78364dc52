// Scenes of the project with one mistake each, hundreds of them: every one is refused with one line that names file,
// line, column and key, or it is a scene that says something else and says it validly. DRENCH_FUZZ_SEED and
// DRENCH_FUZZ_COUNT repeat or lengthen the hunt.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/time.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <map>
#include <random>
#include <regex>
#include <sstream>

#include "good_scenes.hpp"
#include "pipeline/backend.hpp"
#include "point_caches.hpp"
#include "run_program.hpp"
#include "scene/load.hpp"
#include "scene/schema.hpp"
#include "scene/yaml_tree.hpp"
#include "scene_equal.hpp"
#include "scene_mutations.hpp"
#include "setup/build.hpp"

namespace drench::testing {
namespace {

using yaml::Value;

/// The paths and values of a document; entries of lists by number, and N in `general`.
struct Leaf {
  std::string path, general;
  const Value* value;
};

void leaves(const Value& value, const std::string& path, const std::string& general, std::vector<Leaf>& all) {
  all.push_back({path, general, &value});
  const auto under = [](const std::string& base, const std::string& next) {
    return base.empty() ? next : base + "." + next;
  };
  for (const yaml::Entry& e : value.entries) leaves(e.value, under(path, e.key), under(general, e.key), all);
  for (std::size_t i = 0; i < value.items.size(); ++i)
    leaves(value.items[i], under(path, std::to_string(i)), under(general, "N"), all);
}

double as_number(const std::string& text) {
  if (text == ".inf" || text == ".Inf" || text == ".INF") return std::numeric_limits<double>::infinity();
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  double value = 0;
  const auto [end, code] = std::from_chars(begin, text.data() + text.size(), value);
  return code == std::errc{} && end == text.data() + text.size() ? value : std::nan("");
}

bool in_range(double x, const std::string& range) {
  const std::size_t comma = range.find(", ");
  const double low = std::stod(range.substr(1, comma - 1)), high = std::stod(range.substr(comma + 2));
  return (range.front() == '(' ? x > low : x >= low) && (range.back() == ')' ? x < high : x <= high);
}

/// The same of a time or a value among the keys of one that moves with time, and of a number in a list of pairs; "no
/// key" if the leaf is no part of such a value.
std::string objection_to_key(const Leaf& leaf, const std::map<std::string, const SchemaKey*>& keys) {
  for (std::size_t dot = leaf.general.rfind('.'); dot != std::string::npos && dot > 0;
       dot = leaf.general.rfind('.', dot - 1)) {
    const auto key = keys.find(leaf.general.substr(0, dot));
    if (key == keys.end()) continue;
    const std::string rest = leaf.general.substr(dot + 1), text = leaf.value->text;
    if (key->second->type.starts_with("list of pairs") && rest == "N.N")
      return in_range(as_number(text), key->second->allowed) ? "" : leaf.path + " is " + text;
    if (!key->second->type.ends_with("or keyframes")) continue;
    if (rest == "interpolation")
      return text == "linear" || text == "smooth" || text == "step" ? "" : leaf.path + " is " + text;
    const bool time = (rest == "N.N" || rest == "keys.N.N") && leaf.path.ends_with(".0");
    const std::string range = time ? "[0, 1e6]" : key->second->allowed;
    return in_range(as_number(text), range) ? "" : leaf.path + " is " + text + ", not in " + range;
  }
  return leaf.path + " is no key";
}

/// Looks at a scene that was accepted with nothing but the schema: "" if each of its values may stand where it stands,
/// and comes back out of the scene that was made of it.
std::string objection(const std::string& text, const Scene& scene) {
  static const Schema schema = scene_schema();
  std::map<std::string, const SchemaKey*> keys;
  for (const SchemaKey& key : schema.keys) keys[key.path] = &key;
  const Value given = yaml::parse(text, "given"), resolved = yaml::parse(to_yaml(scene), "resolved");
  std::vector<Leaf> all, written;
  leaves(given, "", "", all);
  leaves(resolved, "", "", written);
  std::map<std::string, const Value*> out;
  for (const Leaf& leaf : written) out[leaf.path] = leaf.value;
  for (const Leaf& leaf : all) {
    if (leaf.value->kind != Value::Kind::scalar) continue;
    const bool in_list = leaf.general.ends_with(".N");
    const std::string name = in_list ? leaf.general.substr(0, leaf.general.size() - 2) : leaf.general;
    const auto key = keys.find(name);
    if (key == keys.end()) {
      if (const std::string wrong = objection_to_key(leaf, keys); !wrong.empty()) return wrong;
      continue;
    }
    std::string allowed = key->second->allowed;
    if (key->second->type == "word or number") {  // the words, then the range
      const std::size_t range = allowed.find_first_of("[(");
      if ((", " + allowed.substr(0, range)).find(", " + leaf.value->text + ",") != std::string::npos) continue;
      allowed = allowed.substr(range);
    }
    const bool number = key->second->type.find("number") != std::string::npos;
    if (number && !in_range(as_number(leaf.value->text), allowed))
      return leaf.path + " is " + leaf.value->text + ", not in " + key->second->allowed;
    if (number && leaf.value->quoted) return leaf.path + " is text";
    if (key->second->type == "word" &&
        (", " + key->second->allowed + ",").find(", " + leaf.value->text + ",") == std::string::npos)
      return leaf.path + " is none of " + key->second->allowed;
    // What a resolved scene leaves out or says in other words: 0 m is `off`.
    if (name == "cloth.N.clean" && as_number(leaf.value->text) == 0) continue;
    if (name == "preset" || name == "cloth.N.fabric") continue;
    if (key->second->type.starts_with("file") || key->second->type == "switch") continue;
    // The sources come out blocks first; pins without motion come out without it.
    if (name.starts_with("fluid.sources") || name.starts_with("cloth.N.pin")) continue;
    const auto same = out.find(leaf.path);
    if (same == out.end()) return leaf.path + " is lost";
    if (number ? as_number(same->second->text) != as_number(leaf.value->text) : same->second->text != leaf.value->text)
      return leaf.path + " is " + leaf.value->text + " and became " + same->second->text;
  }
  for (const SchemaKey& key : schema.keys) {  // of every map that stands there, what must stand in it
    if (key.need == SchemaKey::Need::optional) continue;
    for (const Leaf& leaf : all) {
      if (leaf.general != key.parent() || leaf.value->kind != Value::Kind::map) continue;
      int count = 0;
      for (const SchemaKey& other : schema.keys)
        if (other.parent() == key.parent() && other.need == key.need && leaf.value->find(other.name())) ++count;
      if (key.need == SchemaKey::Need::required ? !leaf.value->find(key.name()) : count != 1)
        return leaf.path + " lacks " + key.name();
    }
  }
  return "";
}

/// What loading a scene, and setting it up in little memory, comes to.
struct Verdict {
  std::string refusal;    // "" if it is accepted
  std::string objection;  // to an acceptance
  bool at_set_up = false;
};

Verdict judge(const std::string& text, const std::string& path) {
  Verdict verdict;
  try {
    const Scene scene = parse_scene(text, path);
    verdict.objection = objection(text, scene);
    const Scene again = parse_scene(to_yaml(scene), path);
    if (!same_scene(again, scene)) verdict.objection += "; the resolved scene reads as another one";
    MemoryBudget small;
    small.host = 256.0 * (1 << 20);
    small.arrays = [](const SetupSize& size) { return kokkos_array_bytes(size, 4, false); };
    try {
      build(scene, small);
    } catch (const SetupError& error) {
      EXPECT_NE(error.key, "") << error.what();
      verdict.at_set_up = true;
      verdict.refusal = locate_in(text, path, {}, error.key) + ": " + error.what();
    }
  } catch (const SceneError& error) {
    verdict.refusal = error.what();
  }
  return verdict;
}

/// Scenes that fit in little memory: the tests' own, coarser, and those of the project but for the paper's.
std::vector<std::pair<std::string, std::string>> good_ones() {
  const auto coarser = [](const char* text, const char* what, const char* with) {
    return std::regex_replace(text, std::regex(what), with);
  };
  std::vector<std::pair<std::string, std::string>> all{
      {"minimal", coarser(minimal, "fluid: \\{", "fluid: {spacing: 0.1, ")},
      {"fluid_and_cloth", coarser(fluid_and_cloth, "fluid: \\{", "fluid: {spacing: 0.1, ")},
      {"everything", coarser(everything, "spacing: 0.02", "spacing: 0.1")}};
  for (const auto& file : std::filesystem::directory_iterator(test::scenes_folder()))
    if (file.path().extension() == ".yaml") all.emplace_back(file.path().stem(), test::read_text(file.path()));
  std::sort(all.begin(), all.end());
  return all;
}

/// `file:line:column: key: what is wrong`, the place being in the text.
std::string wrong_form(const std::string& line, const std::string& path, const std::string& text) {
  static const std::regex form(R"(:(\d+):(\d+): (\S.*?): \S.*)");
  std::smatch match;
  if (line.find('\n') != line.npos) return "more than a line";
  if (!line.starts_with(path)) return "names another file";
  const std::string rest = line.substr(path.size());
  if (!std::regex_match(rest, match, form)) return "is not located";
  if (line.size() > 600) return "is long";
  const auto lines = 1 + std::count(text.begin(), text.end(), '\n');
  return std::stol(match[1]) >= 1 && std::stol(match[1]) <= lines + 1 && std::stol(match[2]) >= 1
             ? ""
             : "is located nowhere";
}

/// Ends the program when it has computed for so many seconds more; 0: never.
void stop_after(long seconds) {
  const itimerval limit{{0, 0}, {seconds, 0}};
  setitimer(ITIMER_PROF, &limit, nullptr);
}

long largest_resident() {  // KiB
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// The files that `everything` names.
void write_meshes(const std::filesystem::path& folder) {
  test::write_text(
      folder / "exists.obj",
      "v 0 0 0\nv 0 0 1\nv 1 0 0\nv 3 0 0\nv 3 0 1\nv 4 0 0\nv 6 0 0\nv 6 0 1\nv 7 0 0\nv 9 0 0\nv 9 0 1\nv 10 0 0\n"
      "g left\nf 1 2 3\ng right-side\nf 4 5 6\ng\nf 7 8 9\nf 10 11 12\n");
  test::write_text(folder / "seams.txt", "0 3\n");
  test::write_text(
      folder / "mesh.PLY",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float "
      "wax\n"
      "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0 1\n1 0 0 0.5\n0 1 0 0\n0 0 1 0\n"
      "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n");
  const std::vector<Vec3> solid{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<Vec3> sheet;
  for (const double x : {0.0, 3.0, 6.0, 9.0}) sheet.insert(sheet.end(), {{x, 0, 0}, {x, 0, 1}, {x + 1, 0, 0}});
  test::write_text(folder / "cache.pc2", test::pc2_of({solid, solid}));
  test::write_text(folder / "cache.mdd", test::mdd_of({sheet, sheet}, {0, 1}));
}

/// The program says the same as `line`, with exit code 2; it has more memory.
void expect_of_the_program(const std::filesystem::path& folder, const std::string& path, const std::string& bad,
                           const std::string& line) {
  test::write_text(path, bad);
  const test::Outcome o = test::run_drench(folder, {"check", path});
  EXPECT_TRUE(o.code == 2 || (o.code == 0 && line.empty()) || line.find("does not fit") != line.npos)
      << o.code << o.err;
  if (o.code == 2) {
    EXPECT_EQ(wrong_form(o.err.substr(0, o.err.size() - 1), path, bad), "") << o.err;
  }
}

TEST(SceneMutations, EndInOneLocatedLineOrAnotherValidScene) {
  const char* seed_text = std::getenv("DRENCH_FUZZ_SEED");
  const char* count_text = std::getenv("DRENCH_FUZZ_COUNT");
  const unsigned long seed = seed_text ? std::stoul(seed_text) : 1, wanted = count_text ? std::stoul(count_text) : 500;
  const test::TempFolder here;
  const std::string path = here.path() / "bad.yaml";
  write_meshes(here.path());
  std::filesystem::copy_file(std::filesystem::path(test::scenes_folder()) / "bowl.obj", here.path() / "bowl.obj");
  const auto good = good_ones();
  for (const auto& [name, text] : good) {
    const Verdict whole = judge(text, path);
    EXPECT_EQ(whole.refusal + whole.objection, "") << name;
  }
  Mutations mutations(seed);
  std::mt19937_64 random(seed);
  unsigned long refused = 0, accepted = 0, at_set_up = 0, run = 0;
  double slowest = 0;  // s of the processor
  std::map<std::size_t, unsigned long> refused_by_kind;
  const long resident = largest_resident();
  for (; refused < wanted && run < 4 * wanted; ++run) {
    const auto& [name, text] = good[static_cast<std::size_t>(random() % good.size())];
    const std::size_t kind = run % Mutations::kinds;
    const std::string bad = mutations.of(text, kind);
    SCOPED_TRACE(fmt::format("seed {}, run {}: {}\n{}", seed, run, name, bad));
    stop_after(60);  // a hang ends the test
    const std::clock_t begin = std::clock();
    Verdict verdict;
    ASSERT_NO_THROW(verdict = judge(bad, path));
    const std::string& line = verdict.refusal;
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    slowest = std::max(slowest, seconds);
    stop_after(0);
    EXPECT_LT(seconds, 10) << line;
    EXPECT_EQ(verdict.objection, "");
    if (line.empty()) {
      ++accepted;
    } else {
      EXPECT_EQ(wrong_form(line, path, bad), "") << line;
      ++refused;
      at_set_up += verdict.at_set_up ? 1 : 0;
      ++refused_by_kind[kind];
    }
    if (run % 20 == 0) expect_of_the_program(here.path(), path, bad, line);
  }
  EXPECT_GE(refused, wanted);
  EXPECT_GT(accepted, wanted / 20);  // else nothing is learned of what is let through
  for (std::size_t kind = 0; kind < Mutations::kinds; ++kind) EXPECT_GT(refused_by_kind[kind], 0U) << kind;
  EXPECT_LT(largest_resident() - resident, 512 << 10);
  std::printf(
      "%lu scenes: %lu refused, %lu of them at set-up, %lu accepted; %ld MiB more at most, %.2f s the slowest\n", run,
      refused, at_set_up, accepted, (largest_resident() - resident) >> 10, slowest);
}

}  // namespace
}  // namespace drench::testing
