#include <fmt/format.h>

#include "app/commands.hpp"
#include "base/version.hpp"
#include "parallel/communicator.hpp"
#include "pipeline/runtime.hpp"

namespace drench {

int info_command(int threads) {
  require_device();
  const BackendRuntime runtime(threads, true);
  fmt::print("version: {}\ncommit: {}\nprecision: {}\n", version_string, git_commit, precision_name);
  std::string text = runtime_description();
  if (!text.empty() && text.back() != '\n') text += '\n';
  fmt::print("{}ranks: {}\n", text, transport_description());
  return exit_done;
}

}  // namespace drench
