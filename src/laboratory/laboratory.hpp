#pragma once
// Standard tests of textiles as templates (docs/manual/fabric_tests.md): each writes a scene, runs it, and measures
// what the standard reports.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace drench {

class Trial;

/// A number that a test reports for one specimen.
struct TestNumber {
  std::string key;                 ///< name in result.json
  std::string meaning;             ///< a line for the reader
  std::string unit;                ///< "1" for none
  double value = 0;                ///< measured
  std::optional<double> expected;  ///< by theory for the specimen's parameters, where there is a closed form
};

/// The measurement of one specimen.
struct TestedSpecimen {
  std::string name;                       ///< such as "warp 1"
  std::vector<TestNumber> numbers;        ///< a number that could not be measured is missing
  std::vector<std::vector<double>> rows;  ///< of the curve; as long as StandardTest::columns
  std::vector<std::string> notes;         ///< a line each
  std::string scene;                      ///< name of its scene file
  double seconds = 0;                     ///< run time
};

/// A test.
struct StandardTest {
  const char* name;                  ///< on the command line
  std::vector<const char*> aliases;  ///< other names for it
  const char* standard;              ///< number of the standard
  const char* title;                 ///< a line
  const char* varied;                ///< what differs between specimens
  bool directions;                   ///< specimens are cut along the warp and along the weft
  bool porous;                       ///< the specimen absorbs liquid
  int repeats;                       ///< specimens, per direction
  bool takes_other_mesh = true;      ///< allows an override of the number of nodes
  std::vector<const char*> columns;  ///< of the curve, with units
  void (*run)(Trial& trial);
};

/// All of them.
const std::vector<StandardTest>& standard_tests();
/// The test of this name or alias, in letters of either case; null if there is none.
const StandardTest* find_standard_test(std::string_view name);

/// What is tested, and how.
struct TestRequest {
  std::string fabric = "cotton_interlock";               ///< a word of `cloth.N.fabric`
  std::vector<std::string> overrides;                    ///< key.path=value, for the scene of each specimen
  std::optional<int> repeats;                            ///< specimens, per direction; else the test's own
  std::filesystem::path folder;                          ///< for scenes and meshes; it has to exist
  std::function<void(const TestedSpecimen&)> completed;  ///< called for each specimen
  std::function<void(const std::string&)> takes_long;    ///< called with a line before a scene of very many steps
};

/// A number over all specimens that have it.
struct TestSummary {
  TestNumber first;            ///< key, meaning and unit
  std::vector<double> values;  ///< in the order of the specimens
  double mean = 0;
  double deviation = 0;            ///< standard deviation of the specimens; 0 for one
  std::optional<double> expected;  ///< mean
};

/// What a test found.
struct TestResult {
  const StandardTest* test = nullptr;
  TestRequest request;
  std::vector<TestedSpecimen> specimens;
  std::vector<std::string> warnings;  ///< of the scenes, a line each
  double seconds = 0;                 ///< run time

  std::vector<TestSummary> summary() const;
  /// The mean of a number. @throws std::out_of_range if no specimen has it
  double mean(std::string_view key) const;
};

/// Runs a test. A BackendRuntime must exist.
/// @throws SceneError for an unknown fabric, an override that a scene does not allow, or one of the specimen's geometry
/// @throws SetupError, DeviceError as Simulation does; std::runtime_error if a run fails or a file cannot be written
TestResult run_test(const StandardTest& test, const TestRequest& request);

/// The result as lines for a terminal.
std::string to_text(const TestResult& result);
/// The result as JSON.
std::string to_json(const TestResult& result);
/// The curves as CSV: a column with the specimen's name, then those of the test.
std::string to_csv(const TestResult& result);

}  // namespace drench
