#pragma once
// Version, commit and precision of this program. The build writes the values into a source file of their own
// (tools/cmake/version.cmake), so that a new commit or the other precision recompiles that file alone.

#include <string_view>

namespace drench {

extern const std::string_view version_string;
extern const std::string_view git_commit;      ///< ends in -dirty if files differ from it
extern const std::string_view precision_name;  ///< "float" or "double"
extern const std::string_view kokkos_version;

}  // namespace drench
