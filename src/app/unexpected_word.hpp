#pragma once
// Words of the command line that no option or argument takes.

#include <CLI/CLI.hpp>
#include <string>

namespace drench {

/// One line about the first word that a parsed command does not take, with the option that was probably meant.
std::string unexpected_word(const CLI::App& command);

}  // namespace drench
