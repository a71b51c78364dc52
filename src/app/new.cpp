#include <fmt/format.h>

#include "app/commands.hpp"
#include "setup/first_scene.hpp"

namespace drench {

int new_command(const std::string& mesh) {
  const FirstScene scene = first_scene(mesh);
  for (const std::string& line : scene.warnings) fmt::print(stderr, "warning: {}\n", line);
  fmt::print("{}", scene.yaml);
  return exit_done;
}

}  // namespace drench
