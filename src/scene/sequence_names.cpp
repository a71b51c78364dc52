#include "scene/sequence_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <regex>

#include "scene/scalars.hpp"

namespace drench {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Nothing but a number that fits.
bool is_number(const std::string& text) {
  return !text.empty() && text.size() <= 15 && std::all_of(text.begin(), text.end(), is_digit);
}

/// Where a run of digits that begins at `i` begins without its zeros, and where it ends.
std::pair<std::size_t, std::size_t> digits_from(const std::string& text, std::size_t i) {
  while (i + 1 < text.size() && text[i] == '0' && is_digit(text[i + 1])) ++i;
  std::size_t end = i;
  while (end < text.size() && is_digit(text[end])) ++end;
  return {i, end};
}

/// The order of texts in which numbers stand in their own order.
bool comes_before(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
      continue;
    }
    const auto [from, to] = digits_from(a, i);
    const auto [other_from, other_to] = digits_from(b, j);
    if (to - from != other_to - other_from) return to - from < other_to - other_from;
    if (const int order = a.compare(from, to - from, b, other_from, other_to - other_from)) return order < 0;
    i = to, j = other_to;
  }
  return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
}

/// What stands between two texts in the names of a folder's files.
std::vector<std::string> texts_between(const std::string& before, const std::string& after, const fs::path& folder) {
  std::vector<std::string> texts;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.size() >= before.size() + after.size() && name.starts_with(before) && name.ends_with(after))
      texts.push_back(name.substr(before.size(), name.size() - before.size() - after.size()));
  }
  return texts;
}

/// The first number that is missing among ascending ones, as the text of a name; empty: none is. `step`: between two.
std::string missing_of(const std::vector<std::string>& numbers, std::int64_t step) {
  for (std::size_t k = 1; k < numbers.size(); ++k)
    if (std::stoll(numbers[k]) - std::stoll(numbers[k - 1]) > step)
      return fmt::format("{:0{}}", std::stoll(numbers[k - 1]) + step, numbers[k - 1].size());
  return "";
}

/// The least difference between two ascending numbers that differ.
std::int64_t least_step(const std::vector<std::string>& numbers) {
  std::int64_t step = 0;
  for (std::size_t k = 1; k < numbers.size(); ++k) {
    const std::int64_t by = std::stoll(numbers[k]) - std::stoll(numbers[k - 1]);
    if (by > 0 && (step == 0 || by < step)) step = by;
  }
  return std::max<std::int64_t>(step, 1);
}

}  // namespace

SequenceNames sequence_names(const std::string& pattern, const std::string& folder) {
  static const std::regex number(R"(\{(?::0?([1-9])d|:d)?\})"), star(R"(\*)");
  const fs::path path(pattern);
  const std::string last = path.filename().string();
  std::smatch found;
  const bool numbered = std::regex_search(last, found, number);
  if (!numbered && !std::regex_search(last, found, star)) return {{pattern}, ""};
  const std::string before = found.prefix(), after = found.suffix();
  std::vector<std::string> texts = texts_between(before, after, fs::path(folder) / path.parent_path());
  const auto name = [&](const std::string& text) { return (path.parent_path() / (before + text + after)).string(); };
  if (numbered) {
    const int digits = found[1].matched ? std::stoi(found[1]) : 1;
    std::erase_if(texts, [&](const std::string& t) {
      return !is_number(t) || fmt::format("{:0{}}", std::stoll(t), digits) != t;
    });
  }
  std::sort(texts.begin(), texts.end(), comes_before);
  if (texts.size() > most_files) texts.resize(most_files);
  SequenceNames result;
  for (const std::string& text : texts) result.names.push_back(name(text));
  if (!std::all_of(texts.begin(), texts.end(), is_number)) return result;
  if (const std::string missing = missing_of(texts, numbered ? 1 : least_step(texts)); !missing.empty())
    result.problem = fmt::format("lacks '{}' (there are {} to {}); allowed: no gap, or a list of the files",
                                 before + missing + after, texts.front(), texts.back());
  return result;
}

}  // namespace drench
