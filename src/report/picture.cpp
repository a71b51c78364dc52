#include "report/picture.hpp"

#include <fmt/format.h>
#include <vtkBase64Utilities.h>
#include <vtkImageData.h>
#include <vtkJPEGWriter.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>
#include <vtkPNGWriter.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <stdexcept>

#include "output/text_file.hpp"

namespace drench {

namespace {

constexpr int jpeg_quality = 88;

vtkSmartPointer<vtkImageData> image_of(const Picture& picture) {
  const auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(picture.width, picture.height, 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  auto* bytes = static_cast<unsigned char*>(image->GetScalarPointer());
  for (const Colour& pixel : picture.pixels)
    for (const float channel : pixel)
      *bytes++ = static_cast<unsigned char>(std::clamp(channel, 0.0F, 1.0F) * 255 + 0.5F);
  return image;
}

}  // namespace

Picture reduced(const Picture& picture, int factor) {
  Picture small(picture.width / factor, picture.height / factor, {0, 0, 0});
  const float share = 1.0F / static_cast<float>(factor * factor);
  for (int y = 0; y < small.height * factor; ++y)
    for (int x = 0; x < small.width * factor; ++x)
      for (std::size_t c = 0; c < 3; ++c) small.at(x / factor, y / factor)[c] += share * picture.at(x, y)[c];
  return small;
}

std::string data_url(const Picture& picture) {
  vtkNew<vtkJPEGWriter> writer;
  writer->SetInputData(image_of(picture));
  writer->SetQuality(jpeg_quality);
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* file = writer->GetResult();
  if (!file || file->GetNumberOfValues() == 0) throw std::runtime_error("a picture cannot be encoded as JPEG");
  const auto size = static_cast<std::size_t>(file->GetNumberOfValues());
  std::string text(4 * (size / 3 + 2), '\0');
  text.resize(vtkBase64Utilities::Encode(file->GetPointer(0), size, reinterpret_cast<unsigned char*>(text.data())));
  return "data:image/jpeg;base64," + text;
}

void write_png(const Picture& picture, const std::filesystem::path& path) {
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(image_of(picture));
  writer->WriteToMemoryOn();
  writer->Write();
  vtkUnsignedCharArray* file = writer->GetResult();
  if (!file || file->GetNumberOfValues() == 0) throw std::runtime_error("a picture cannot be encoded as PNG");
  write_atomically(path, std::string(reinterpret_cast<const char*>(file->GetPointer(0)),
                                     static_cast<std::size_t>(file->GetNumberOfValues())));
}

Picture read_png(const std::filesystem::path& path) {
  vtkNew<vtkPNGReader> reader;
  const bool readable = std::filesystem::is_regular_file(path) && reader->CanReadFile(path.c_str()) != 0;
  if (readable) {
    reader->SetFileName(path.c_str());
    reader->Update();
  }
  vtkImageData* image = reader->GetOutput();
  const bool good = readable && reader->GetErrorCode() == 0 && image->GetScalarType() == VTK_UNSIGNED_CHAR;
  if (!good) throw std::runtime_error(fmt::format("{}: is not a picture that can be read", path.string()));
  int size[3];
  image->GetDimensions(size);
  const int channels = image->GetNumberOfScalarComponents();
  Picture picture(size[0], size[1], {0, 0, 0});
  const auto* bytes = static_cast<const unsigned char*>(image->GetScalarPointer());
  for (Colour& pixel : picture.pixels) {
    for (int c = 0; c < 3; ++c)
      pixel[static_cast<std::size_t>(c)] = static_cast<float>(bytes[channels < 3 ? 0 : c]) / 255;
    bytes += channels;
  }
  return picture;
}

}  // namespace drench
