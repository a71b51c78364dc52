#include "scene/scene_difference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "scene/yaml_tree.hpp"

namespace drench {
namespace {

using Keys = std::vector<std::pair<std::string, std::string>>;

void flatten(const yaml::Value& value, const std::string& path, Keys& keys) {
  const auto below = [&](const std::string& key) { return path.empty() ? key : path + "." + key; };
  for (const yaml::Entry& entry : value.entries) flatten(entry.value, below(entry.key), keys);
  const bool numbers = std::none_of(value.items.begin(), value.items.end(),
                                    [](const yaml::Value& item) { return item.kind != yaml::Value::Kind::scalar; });
  if (value.kind == yaml::Value::Kind::list && numbers) {
    std::string text;
    for (const yaml::Value& item : value.items) text += (text.empty() ? "" : ", ") + item.text;
    keys.emplace_back(path, "[" + text + "]");
  } else {
    for (std::size_t k = 0; k < value.items.size(); ++k) flatten(value.items[k], below(std::to_string(k)), keys);
  }
  if (value.kind == yaml::Value::Kind::scalar) keys.emplace_back(path, value.text);
}

Keys keys_of(const std::string& text, const std::vector<std::string>& allowed) {
  Keys keys;
  flatten(yaml::parse(text, "scene"), "", keys);
  std::erase_if(keys, [&](const auto& entry) {
    return entry.first.ends_with(".file") || entry.first.ends_with(".sequence") ||
           std::find(allowed.begin(), allowed.end(), entry.first) != allowed.end();
  });
  return keys;
}

}  // namespace

std::vector<KeyDifference> scene_differences(const std::string& before, const std::string& now,
                                             const std::vector<std::string>& allowed) {
  const Keys old_keys = keys_of(before, allowed), new_keys = keys_of(now, allowed);
  const std::map<std::string, std::string> old_values(old_keys.begin(), old_keys.end()),
      new_values(new_keys.begin(), new_keys.end());
  std::vector<KeyDifference> found;
  for (const auto& [key, value] : old_keys) {
    const auto at = new_values.find(key);
    if (at == new_values.end())
      found.push_back({key, value, std::nullopt});
    else if (at->second != value)
      found.push_back({key, value, at->second});
  }
  for (const auto& [key, value] : new_keys)
    if (!old_values.contains(key)) found.push_back({key, std::nullopt, value});
  return found;
}

std::optional<std::string> scene_difference(const std::string& before, const std::string& now,
                                            const std::vector<std::string>& allowed) {
  const auto all = scene_differences(before, now, allowed);
  if (all.empty()) return std::nullopt;
  const KeyDifference& first = all.front();
  if (!first.now) return fmt::format("{} was {} and is not given now", first.key, *first.before);
  if (!first.before) return fmt::format("{} was not given and is {} now", first.key, *first.now);
  return fmt::format("{} was {}, is {}", first.key, *first.before, *first.now);
}

}  // namespace drench
