#pragma once
// Pictures without a window.

#include <vtkRenderWindow.h>

#include <filesystem>

#include "view/options.hpp"

namespace drench {

/// Writes what the window shows as a PNG file. Throws std::runtime_error.
void save_png(vtkRenderWindow* window, const std::filesystem::path& file);

/// Writes the one picture, or those of many frames, that the options ask for, and says where. Throws
/// std::runtime_error.
void write_pictures(const ViewOptions& options);

}  // namespace drench
