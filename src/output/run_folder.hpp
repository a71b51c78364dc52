#pragma once
// Where a run's files go. Nothing that a person made is ever overwritten.

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include "scene/scene.hpp"

namespace drench {

/// A folder that may not be written to. One line.
struct FolderError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct RunFolder {
  std::filesystem::path path;
  std::string note;  // one line when it is not the folder that one would expect, else ""
};

/// How a folder is chosen and replaced, for messages: of the command, unless a program calls.
struct FolderWords {
  const char* other = "choose another folder with -o";
  const char* overwrite = "--overwrite";  // null: there is no such option
};

/// Chooses and makes the folder. Without `requested` it is out/<scene's stem>, or the first free out/<stem>-2, -3, …
/// A `requested` folder must be new or empty. With `overwrite` a folder that holds an earlier run's output is cleared
/// of the files that drench writes, and of no others. Throws FolderError.
RunFolder make_run_folder(const std::optional<std::string>& requested, const std::string& scene_path, bool overwrite,
                          const FolderWords& words = {});

/// Removes what writers that were killed have left: files under their temporary names.
void remove_unfinished(const std::filesystem::path& folder);

/// While it lives no other run writes to the folder: the constructor throws FolderError if one does.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int file_;
};

/// True when `folder` holds the output of a run.
bool holds_run(const std::filesystem::path& folder);

/// Writes scene.yaml: the resolved scene under a comment that says which program and machine computed it.
void write_resolved_scene(const std::filesystem::path& folder, const Scene& scene, const std::string& backend_name,
                          const std::string& backend_description);
/// The first lines of run.log: program, backend and scene.
std::string run_heading(const std::string& backend_name, const std::string& backend_description,
                        const std::string& scene);

}  // namespace drench
