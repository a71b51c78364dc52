#include <fmt/format.h>

#include <filesystem>

#include "app/commands.hpp"
#include "app/python.hpp"

namespace drench {

int import_command(const ImportOptions& options) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(options.file, ignored))
    throw ExportError(fmt::format("{}: no such file", options.file));
  std::vector<std::string> words;
  if (options.prim) words.push_back("--prim=" + *options.prim);
  if (options.fps) words.push_back(fmt::format("--fps={:.17g}", *options.fps));
  words.push_back("--");  // names may begin with dashes
  words.push_back(options.file);
  if (options.output) words.push_back(*options.output);
  become_python("read_usd.py", words);
}

}  // namespace drench
