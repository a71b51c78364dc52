#include "scene/sequence_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <regex>

#include "scene/scalars.hpp"

namespace drench {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> numbered(const std::string& before, int digits, const std::string& after,
                                  const std::string& folder) {
  const auto name = [&](std::size_t k) { return fmt::format("{}{:0{}}{}", before, k, digits, after); };
  const auto exists = [&](std::size_t k) {
    std::error_code error;
    return fs::exists(fs::path(folder) / name(k), error);
  };
  std::vector<std::string> names;
  for (std::size_t k = exists(0) ? 0 : 1; names.size() < most_files && exists(k); ++k) names.push_back(name(k));
  return names;
}

std::vector<std::string> alike(const fs::path& pattern, const std::string& folder) {
  const std::string last = pattern.filename().string();
  const std::size_t star = last.find('*');
  const std::string before = last.substr(0, star), after = last.substr(star + 1);
  std::vector<std::string> names;
  const fs::path searched = fs::path(folder) / pattern.parent_path();
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(searched.empty() ? "." : searched, error)) {
    const std::string name = entry.path().filename().string();
    if (name.size() >= before.size() + after.size() && name.starts_with(before) && name.ends_with(after))
      names.push_back((pattern.parent_path() / name).string());
    if (names.size() == most_files) break;
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

std::vector<std::string> sequence_names(const std::string& pattern, const std::string& folder) {
  static const std::regex number(R"(\{(?::0?([1-9])d|:d)?\})");
  const std::string last = fs::path(pattern).filename().string(),
                    before = pattern.substr(0, pattern.size() - last.size());
  std::smatch found;
  if (std::regex_search(last, found, number))
    return numbered(before + found.prefix().str(), found[1].matched ? std::stoi(found[1]) : 1, found.suffix(), folder);
  if (last.find('*') != std::string::npos) return alike(pattern, folder);
  return {pattern};
}

}  // namespace drench
