#include "laboratory/laboratory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "base/version.hpp"
#include "laboratory/tests.hpp"
#include "laboratory/trial.hpp"

namespace drench {
namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20)
      out += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out + "\"";
}

std::string json_number(double x) { return std::isfinite(x) ? fmt::format("{:.9g}", x) : "null"; }

template <class Values, class Text>
std::string json_list(const Values& values, Text text) {
  std::string out;
  for (const auto& v : values) out += (out.empty() ? "" : ", ") + text(v);
  return "[" + out + "]";
}

std::vector<std::string> notes_of(const TestResult& result) {
  std::vector<std::string> notes;
  for (const TestedSpecimen& s : result.specimens)
    for (const std::string& n : s.notes)
      if (std::find(notes.begin(), notes.end(), n) == notes.end()) notes.push_back(n);
  return notes;
}

/// Two digits of a deviation, but none beyond the four of the mean that stand before it.
std::string deviation_text(double deviation, double mean) {
  const auto place_of = [](double x) { return std::floor(std::log10(std::fabs(x))); };
  double last = deviation > 0 ? place_of(deviation) - 1 : 0;
  if (mean != 0) last = std::max(last, place_of(mean) - 3);
  const double unit = std::pow(10, last), rounded = std::round(deviation / unit) * unit;
  return rounded > 0 ? fmt::format("{:.4g}", rounded) : "0";
}

}  // namespace

const std::vector<StandardTest>& standard_tests() {
  static const std::vector<StandardTest> all{vertical_wicking_test(),
                                             horizontal_wicking_test(),
                                             drop_absorbency_test(),
                                             spray_test(),
                                             impact_penetration_test(),
                                             spray_impact_test(),
                                             hydrostatic_head_test(),
                                             strike_through_test(),
                                             wetback_test(),
                                             drying_rate_test(),
                                             drape_test(),
                                             tensile_test(),
                                             cantilever_test()};
  return all;
}

const StandardTest* find_standard_test(std::string_view name) {
  const auto is_named = [&](std::string_view word) {
    return std::equal(name.begin(), name.end(), word.begin(), word.end(),
                      [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
  };
  for (const StandardTest& t : standard_tests())
    if (is_named(t.name) || std::any_of(t.aliases.begin(), t.aliases.end(), is_named)) return &t;
  return nullptr;
}

TestResult run_test(const StandardTest& test, const TestRequest& request) {
  const auto begin = std::chrono::steady_clock::now();
  TestResult result{&test, request, {}, {}, 0};
  const int repeats = request.repeats.value_or(test.repeats);
  for (const Direction direction : {Direction::warp, Direction::weft}) {
    if (direction == Direction::weft && !test.directions) continue;
    for (int k = 0; k < repeats; ++k) {
      const auto started = std::chrono::steady_clock::now();
      Trial trial(test, request, direction, k);
      test.run(trial);
      for (const std::string& w : trial.warnings())
        if (std::find(result.warnings.begin(), result.warnings.end(), w) == result.warnings.end())
          result.warnings.push_back(w);
      result.specimens.push_back(trial.take());
      result.specimens.back().seconds = seconds_since(started);
      if (request.completed) request.completed(result.specimens.back());
    }
  }
  result.seconds = seconds_since(begin);
  return result;
}

std::vector<TestSummary> TestResult::summary() const {
  std::vector<TestSummary> all;
  for (const TestedSpecimen& s : specimens)
    for (const TestNumber& n : s.numbers) {
      auto found = std::find_if(all.begin(), all.end(), [&](const TestSummary& t) { return t.first.key == n.key; });
      if (found == all.end()) {
        all.push_back({n, {}, 0, 0, {}});
        found = std::prev(all.end());
      }
      found->values.push_back(n.value);
      if (n.expected) found->expected = found->expected.value_or(0) + *n.expected;
    }
  for (TestSummary& t : all) {
    const auto count = static_cast<double>(t.values.size());
    for (const double v : t.values) t.mean += v / count;
    double squares = 0;
    for (const double v : t.values) squares += (v - t.mean) * (v - t.mean);
    if (count > 1) t.deviation = std::sqrt(squares / (count - 1));
    constexpr double rounding = 1e-12;  // of the sums above
    if (t.deviation < rounding * std::fabs(t.mean)) t.deviation = 0;
    if (t.expected) *t.expected /= count;
  }
  return all;
}

double TestResult::mean(std::string_view key) const {
  for (const TestSummary& t : summary())
    if (t.first.key == key) return t.mean;
  throw std::out_of_range(fmt::format("{} has no number {}", test->name, key));
}

std::string to_text(const TestResult& result) {
  std::string text = fmt::format("{}: {}\nfabric {}, {} specimens, {:.0f} s\n\n", result.test->standard,
                                 result.test->title, result.request.fabric, result.specimens.size(), result.seconds);
  const auto number = [](double x) { return fmt::format("{:.4g}", x); };
  for (const TestSummary& t : result.summary()) {
    text += fmt::format("  {:<58} {:>9}", t.first.meaning, number(t.mean));
    if (t.values.size() > 1) text += fmt::format(" ± {:<8}", deviation_text(t.deviation, t.mean));
    if (t.first.unit != "1") text += " " + t.first.unit;
    if (t.expected) text += fmt::format("   (theory {})", number(*t.expected));
    text += "\n";
  }
  text += fmt::format("\n  Specimens differ in: {}\n", result.test->varied);
  for (const std::string& note : notes_of(result)) text += fmt::format("  Note: {}\n", note);
  return text;
}

std::string to_json(const TestResult& result) {
  const auto text = [](const std::string& s) { return in_quotes(s); };
  std::string numbers;
  for (const TestSummary& t : result.summary())
    numbers += fmt::format(
        "{}    {{\"key\": {}, \"meaning\": {}, \"unit\": {}, \"mean\": {}, \"standard_deviation\": {}, \"values\": {}, "
        "\"theory\": {}}}",
        numbers.empty() ? "\n" : ",\n", in_quotes(t.first.key), in_quotes(t.first.meaning), in_quotes(t.first.unit),
        json_number(t.mean), json_number(t.deviation), json_list(t.values, json_number),
        t.expected ? json_number(*t.expected) : "null");
  std::string specimens;
  for (const TestedSpecimen& s : result.specimens) {
    std::string values;
    for (const TestNumber& n : s.numbers)
      values += fmt::format("{}{}: {}", values.empty() ? "" : ", ", in_quotes(n.key), json_number(n.value));
    specimens += fmt::format("{}    {{\"name\": {}, \"scene\": {}, \"seconds\": {}, \"numbers\": {{{}}}}}",
                             specimens.empty() ? "\n" : ",\n", in_quotes(s.name), in_quotes(s.scene),
                             json_number(s.seconds), values);
  }
  std::string columns = in_quotes("specimen");
  for (const char* c : result.test->columns) columns += ", " + in_quotes(c);
  return fmt::format(
      "{{\n  \"test\": {},\n  \"standard\": {},\n  \"title\": {},\n  \"fabric\": {},\n  \"overrides\": {},\n"
      "  \"varied\": {},\n  \"drench\": {},\n  \"commit\": {},\n  \"seconds\": {},\n  \"numbers\": [{}\n  ],\n"
      "  \"specimens\": [{}\n  ],\n  \"curve\": \"curve.csv\",\n  \"columns\": [{}],\n  \"notes\": {},\n"
      "  \"warnings\": {}\n}}\n",
      in_quotes(result.test->name), in_quotes(result.test->standard), in_quotes(result.test->title),
      in_quotes(result.request.fabric), json_list(result.request.overrides, text), in_quotes(result.test->varied),
      in_quotes(version_string), in_quotes(git_commit), json_number(result.seconds), numbers, specimens, columns,
      json_list(notes_of(result), text), json_list(result.warnings, text));
}

std::string to_csv(const TestResult& result) {
  std::string text = "specimen";
  for (const char* c : result.test->columns) text += fmt::format(",{}", c);
  text += "\n";
  for (const TestedSpecimen& s : result.specimens)
    for (const std::vector<double>& row : s.rows) {
      text += s.name;
      for (const double v : row) text += std::isfinite(v) ? fmt::format(",{:.9g}", v) : ",";
      text += "\n";
    }
  return text;
}

}  // namespace drench
