#pragma once
// The Python scripts that are part of the program: what reads and writes the files of other tools.

#include <string>
#include <vector>

namespace drench {

/// An interpreter with the modules that a script needs.
struct PythonEnvironment {
  const char* variable;  // of the environment, that names one
  const char* folder;    // above the program, where tools/setup puts one
  const char* remedy;    // for messages
};
inline constexpr PythonEnvironment usd_python{
    "DRENCH_PYTHON", ".deps/export-venv",
    "run tools/setup export, or name a Python that has usd-core and numpy in DRENCH_PYTHON"};
inline constexpr PythonEnvironment blender_python{
    "DRENCH_BLENDER_PYTHON", ".deps/blender-venv",
    "run tools/setup blender, or name a Python that has bpy in DRENCH_BLENDER_PYTHON"};
inline constexpr PythonEnvironment any_python{"DRENCH_PYTHON", ".deps/export-venv",
                                              "install Python 3.9 or newer, or name one in DRENCH_PYTHON"};

/// Becomes Python with a script of share/drench/export (in a build tree, tools/export) and these words. The interpreter
/// is the one that the environment's variable names, then the one in its folder above the program, then python3.
/// Returns only to throw ExportError: no such script, no such interpreter.
[[noreturn]] void become_python(const std::string& script, const std::vector<std::string>& words,
                                const PythonEnvironment& environment = usd_python);

/// Runs it and returns what it prints. Throws ExportError too, without a text, where it ends with another exit
/// code than 0: it has printed why.
std::string run_python(const std::string& script, const std::vector<std::string>& words,
                       const PythonEnvironment& environment);

}  // namespace drench
