#pragma once
// The Python scripts that are part of the program: what reads and writes USD.

#include <string>
#include <vector>

namespace drench {

/// Becomes Python with a script of share/drench/export (in a build tree, tools/export) and these words. The interpreter is the
/// one that DRENCH_PYTHON names, then .deps/export-venv above the program, then python3. Returns only to throw ExportError:
/// no such script, no such interpreter.
[[noreturn]] void become_python(const std::string& script, const std::vector<std::string>& words);

}  // namespace drench
