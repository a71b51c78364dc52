#pragma once
// A run as one HTML page that needs nothing but a browser: docs/manual/report.md.

#include <filesystem>
#include <optional>

namespace drench {

inline constexpr const char* report_name = "report.html";

/// Writes the page about the run in `folder`, with the one in `other` beside it, in one move. A run may still be going
/// on. Throws FolderError where no run is, or a damaged one, and std::runtime_error where the page cannot be written.
void write_report(const std::filesystem::path& folder, const std::optional<std::filesystem::path>& other,
                  const std::filesystem::path& file);

/// Paints the last frame of the run in `folder` into a PNG, in one move, without a display. Throws FolderError as
/// above, and std::runtime_error for a run without frames or a file that cannot be written.
void write_picture(const std::filesystem::path& folder, const std::filesystem::path& file, int width, int height);

}  // namespace drench
