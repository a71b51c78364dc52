#include "paths.hpp"

#include <cstdlib>

namespace drench::test {

std::string from_environment(const char* name, const char* otherwise) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0' ? value : otherwise;
}

std::string program() { return from_environment("DRENCH_PROGRAM", DRENCH_BINARY); }
std::string scenes_folder() { return from_environment("DRENCH_SCENES", DRENCH_SCENES_DIR); }

}  // namespace drench::test
