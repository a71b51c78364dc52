#include "view/png_files.hpp"

#include <fmt/format.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkOggTheoraWriter.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <algorithm>
#include <cmath>
#include <optional>
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
    chosen.push_back(
        static_cast<std::size_t>(std::lround(static_cast<double>(k * last) / static_cast<double>(count - 1))));
  return chosen;
}

vtkSmartPointer<vtkImageData> image_of(vtkRenderWindow* window) {
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window);
  image->SetInputBufferTypeToRGB();
  image->ReadFrontBufferOff();
  image->Update();
  return image->GetOutput();
}

void write_png(vtkImageData* image, const fs::path& file) {
  vtkNew<vtkPNGWriter> png;
  png->SetInputData(image);
  png->SetCompressionLevel(3);
  png->WriteToMemoryOn();
  png->Write();
  vtkUnsignedCharArray* bytes = png->GetResult();
  if (!bytes || bytes->GetNumberOfValues() == 0)
    throw std::runtime_error(fmt::format("{}: the picture cannot be read back from the display", file.string()));
  write_atomically(file, std::string(reinterpret_cast<const char*>(bytes->GetPointer(0)),
                                     static_cast<std::size_t>(bytes->GetNumberOfValues())));
}

/// An Ogg Theora film; the file is there once this ends.
class Film {
 public:
  Film(const std::string& file, double rate) : file_(file) {
    writer_->SetFileName(file.c_str());
    writer_->SetRate(std::max(1, static_cast<int>(std::lround(rate))));
    writer_->SetQuality(2);
  }
  void add(vtkImageData* image) {
    writer_->SetInputData(image);
    if (!begun_) writer_->Start();
    begun_ = true;
    writer_->Write();
    if (writer_->GetError() != 0) throw std::runtime_error(fmt::format("{}: cannot be written", file_));
  }
  void end() {
    writer_->End();
    if (!fs::exists(file_) || fs::file_size(file_) == 0)
      throw std::runtime_error(fmt::format("{}: cannot be written", file_));
  }

 private:
  std::string file_;
  bool begun_ = false;
  vtkNew<vtkOggTheoraWriter> writer_;
};

/// 1/s: as time goes from each of these frames to the next, at most 50.
double natural_rate(const std::vector<double>& times, const std::vector<std::size_t>& chosen) {
  const double interval =
      (times[chosen.back()] - times[chosen.front()]) / static_cast<double>(std::max<std::size_t>(1, chosen.size() - 1));
  return interval > 0 ? std::min(50.0, 1 / interval) : 1;
}

}  // namespace

void save_png(vtkRenderWindow* window, const fs::path& file) { write_png(image_of(window), file); }

void write_pictures(const ViewOptions& options) {
  Show show(options);
  const auto [width, height] = picture_size(options.size);
  const auto window = hidden_window(show, width, height);
  show.frame(*parse_view(options.camera), width, height);
  const auto draw = [&](const fs::path& file) {
    show.picture().renderer()->ResetCameraClippingRange();
    window->Render();
    const auto image = image_of(window);
    write_png(image, file);
    return image;
  };
  if (!options.screenshot.empty()) {
    draw(options.screenshot);
    fmt::print("frame {} in {}\n", show.at(), options.screenshot);
    return;
  }
  fs::create_directories(options.pictures);
  const std::vector<std::size_t> chosen = chosen_frames(options.frames, show.last());
  const double rate = options.fps > 0 ? options.fps : natural_rate(show.frames().times(), chosen);
  std::optional<Film> film;
  if (!options.animation.empty()) film.emplace(options.animation, rate);
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    show.go_to(chosen[k]);
    const auto image = draw(fs::path(options.pictures) / fmt::format("frame_{:04}.png", k));
    if (film) film->add(image);
  }
  fmt::print("{} pictures in {}, {:.6g} per second\n", chosen.size(), options.pictures, rate);
  if (!film) return;
  film->end();
  fmt::print("animation: {}\n", options.animation);
}

}  // namespace drench
