#pragma once

#include <filesystem>
#include <string>

namespace drench {

/// Replaces `path` by `text` in one move, so that a reader sees the old or the new file, never half of one.
/// Throws std::runtime_error when the disk refuses.
void write_atomically(const std::filesystem::path& path, const std::string& text);

/// The name under which a file is written before it is renamed to `path`: hidden, in the same folder.
std::filesystem::path temporary_name(const std::filesystem::path& path);

/// Moves `from` onto `to`. Throws std::runtime_error.
void rename_into_place(const std::filesystem::path& from, const std::filesystem::path& to);

/// Puts a file's bytes, or a folder's names, onto the disk itself: what is renamed or written is otherwise only in the
/// system's memory. Not every file system can for folders; that is no error. Throws std::runtime_error.
void sync_to_disk(const std::filesystem::path& path);

}  // namespace drench
