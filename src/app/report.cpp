#include "report/report.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "app/commands.hpp"
#include "output/run_folder.hpp"

namespace drench {

namespace fs = std::filesystem;

int report_command(const ReportOptions& options) {
  const fs::path folder = options.folder;
  const fs::path file = options.output ? fs::path(*options.output) : folder / report_name;
  if (fs::is_directory(file)) throw FolderError(fmt::format("{}: is a folder; name a file with -o", file.string()));
  if (options.output && !file.parent_path().empty() && !fs::is_directory(file.parent_path()))
    throw FolderError(fmt::format("{}: there is no such folder to write to", file.parent_path().string()));
  std::optional<fs::path> other;
  if (options.other) other = *options.other;
  write_report(folder, other, file);
  fmt::print("{}: {:.0f} KiB; open it in a browser\n", file.string(), static_cast<double>(fs::file_size(file)) / 1024);
  return exit_done;
}

}  // namespace drench
