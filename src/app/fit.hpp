#pragma once
// The command `drench fit`: values of a fabric from measured curves. Python does the work (tools/export/fit_fabric.py).

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

namespace drench {

struct FitOptions {
  std::vector<std::string> data;                      // CSV files
  std::vector<std::string> tests;                     // one, or one for each file
  std::vector<std::string> parameters;                // keys of a cloth
  std::vector<std::string> held_out, held_out_tests;  // CSV files that are only predicted
  std::vector<std::string> overrides, starts, bounds;
  std::string fabric = "cotton_interlock", direction = "warp", name;
  std::optional<std::string> output;
  std::optional<int> jobs, max_steps;
  bool simulate = false, quiet = false;
};

void add_fit_options(CLI::App& command, FitOptions& options);

/// The process becomes Python. Throws ExportError: no such interpreter or script.
[[noreturn]] void fit_command(const FitOptions& options);

}  // namespace drench
