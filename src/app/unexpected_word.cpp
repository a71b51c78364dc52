#include "app/unexpected_word.hpp"

#include <fmt/format.h>

#include <vector>

#include "scene/nearest_word.hpp"

namespace drench {

std::string unexpected_word(const CLI::App& command) {
  const std::vector<std::string> words = command.remaining(true);
  const std::string word = words.empty() ? "" : words.front(), name = word.substr(0, word.find('='));
  const std::string of = command.get_parent() ? "drench " + command.get_name() : "drench";
  if (name.size() < 2 || name[0] != '-')
    return fmt::format("{}: '{}' is one argument too many; see {} --help", of, word, of);
  std::vector<std::string> options;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& known : option->get_lnames()) options.push_back("--" + known);
  std::string near;
  for (const std::string& known : options)
    if (name.size() > 3 && known.starts_with(name)) near = known;
  if (near.empty()) near = nearest_word(name, options);
  return fmt::format("{}: there is no option {}{}; see {} --help", of, name,
                     near.empty() ? "" : fmt::format("; did you mean {}?", near), of);
}

}  // namespace drench
