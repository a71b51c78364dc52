#include "view/png_files.hpp"

#include <fmt/format.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <cmath>
#include <string>

#include "output/text_file.hpp"
#include "view/show.hpp"

namespace drench {
namespace {

namespace fs = std::filesystem;

vtkSmartPointer<vtkRenderWindow> hidden_window(Show& show, int width, int height) {
  auto window = vtkSmartPointer<vtkRenderWindow>::New();
  window->SetOffScreenRendering(1);
  window->SetMultiSamples(8);
  window->SetSize(width, height);
  window->AddRenderer(show.picture().renderer());
  show.picture().fit_texts(width, height);
  return window;
}

/// Evenly spread, from the first frame to the last; the last alone where one is asked for.
std::vector<std::size_t> chosen_frames(int wanted, std::size_t last) {
  const std::size_t count = wanted == 0 ? last + 1 : std::min(static_cast<std::size_t>(wanted), last + 1);
  if (count == 1) return {last};
  std::vector<std::size_t> chosen;
  for (std::size_t k = 0; k < count; ++k)
    chosen.push_back(static_cast<std::size_t>(
        std::lround(static_cast<double>(k * last) / static_cast<double>(count - 1))));
  return chosen;
}

}  // namespace

void save_png(vtkRenderWindow* window, const fs::path& file) {
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window);
  image->SetInputBufferTypeToRGB();
  image->ReadFrontBufferOff();
  vtkNew<vtkPNGWriter> png;
  png->SetInputConnection(image->GetOutputPort());
  png->SetCompressionLevel(3);
  png->WriteToMemoryOn();
  png->Write();
  vtkUnsignedCharArray* bytes = png->GetResult();
  if (!bytes || bytes->GetNumberOfValues() == 0)
    throw std::runtime_error(fmt::format("{}: the picture cannot be read back from the display", file.string()));
  write_atomically(file, std::string(reinterpret_cast<const char*>(bytes->GetPointer(0)),
                                          static_cast<std::size_t>(bytes->GetNumberOfValues())));
}

void write_pictures(const ViewOptions& options) {
  Show show(options);
  const auto [width, height] = picture_size(options.size);
  const auto window = hidden_window(show, width, height);
  show.frame(*parse_view(options.camera), width, height);
  const auto draw = [&](const fs::path& file) {
    show.picture().renderer()->ResetCameraClippingRange();
    window->Render();
    save_png(window, file);
  };
  if (!options.screenshot.empty()) {
    draw(options.screenshot);
    fmt::print("frame {} in {}\n", show.at(), options.screenshot);
    return;
  }
  fs::create_directories(options.pictures);
  const std::vector<std::size_t> chosen = chosen_frames(options.frames, show.last());
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    show.go_to(chosen[k]);
    draw(fs::path(options.pictures) / fmt::format("frame_{:04}.png", k));
  }
  fmt::print("{} pictures in {}\n", chosen.size(), options.pictures);
}

}  // namespace drench
