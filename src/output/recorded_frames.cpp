#include "output/recorded_frames.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <vtkErrorCode.h>
#include <vtkNew.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <stdexcept>

namespace drench {

namespace fs = std::filesystem;

namespace {

constexpr double at_its_time = 1e-3;  // of a picture's length: a frame so near to a picture is that picture's

/// Numbers of the pictures from the first frame to the last.
std::pair<std::int64_t, std::int64_t> picture_range(const std::vector<double>& times, double rate) {
  const auto first = static_cast<std::int64_t>(std::ceil(times.front() * rate - at_its_time));
  const auto last = static_cast<std::int64_t>(std::floor(times.back() * rate + at_its_time));
  return {first, std::max(first, last)};
}

std::size_t nearest(const std::vector<double>& times, double time) {
  const auto after = std::lower_bound(times.begin(), times.end(), time);
  if (after == times.begin()) return 0;
  if (after == times.end()) return times.size() - 1;
  const auto at = static_cast<std::size_t>(after - times.begin());
  return time - times[at - 1] <= times[at] - time ? at - 1 : at;
}

bool whole(double value) { return std::abs(value - std::round(value)) < 1e-6 * std::max(1.0, value); }

/// "50, 25 or 10": the whole rates that meet every frame, or every second, third, … one.
std::string fitting_rates(double natural) {
  std::vector<std::string> rates;
  for (int k = 1; k <= 60 && rates.size() < 4; ++k)
    if (k == 1 || (whole(natural / k) && natural / k > 0.5)) rates.push_back(fmt::format("{:.6g}", natural / k));
  if (rates.size() == 1) return rates[0];
  const std::string last = rates.back();
  rates.pop_back();
  return fmt::format("{} or {}", fmt::join(rates, ", "), last);
}

}  // namespace

std::vector<RecordedFrame> recorded_frames(const fs::path& folder, const std::string& series) {
  const fs::path collection = folder / (series + ".pvd");
  if (!fs::exists(collection)) return {};
  std::ifstream in(collection, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (text.find("</VTKFile>") == std::string::npos)
    throw std::runtime_error(fmt::format("{}: is not a complete collection of frames", collection.string()));
  static const std::regex entry("<DataSet timestep=\"([^\"]*)\" part=\"[^\"]*\" file=\"([^\"]*)\"/>");
  std::map<double, RecordedFrame> frames;
  for (std::sregex_iterator it(text.begin(), text.end(), entry), end; it != end; ++it) {
    char* rest = nullptr;
    const std::string number = (*it)[1];
    const double time = std::strtod(number.c_str(), &rest);
    if (number.empty() || *rest || !std::isfinite(time))
      throw std::runtime_error(fmt::format("{}: '{}' is not a time", collection.string(), number));
    RecordedFrame& frame = frames[time];
    frame.time = time;
    frame.files.push_back(folder / (*it)[2].str());
  }
  std::vector<RecordedFrame> list;
  list.reserve(frames.size());
  for (auto& [time, frame] : frames) list.push_back(std::move(frame));
  return list;
}

vtkSmartPointer<vtkUnstructuredGrid> read_vtu(const fs::path& path) {
  if (!fs::is_regular_file(path)) throw std::runtime_error(fmt::format("{}: no such file", path.string()));
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  if (reader->CanReadFile(path.c_str())) reader->Update();
  vtkSmartPointer<vtkUnstructuredGrid> grid = reader->GetOutput();
  if (reader->GetErrorCode() != vtkErrorCode::NoError || !grid || !grid->GetPoints())
    throw std::runtime_error(fmt::format("{}: is not a complete frame", path.string()));
  return grid;
}

double frame_rate(const std::vector<double>& times) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  if (steps.empty()) return 24;
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  const double rate = 1 / steps[steps.size() / 2];
  return whole(rate) ? std::round(rate) : rate;
}

std::vector<std::size_t> frames_of_pictures(const std::vector<double>& times, double rate) {
  std::vector<std::size_t> frames;
  const auto [first, last] = picture_range(times, rate);
  for (std::int64_t k = first; k <= last; ++k) frames.push_back(nearest(times, static_cast<double>(k) / rate));
  return frames;
}

std::optional<std::string> rate_misfit(const std::vector<double>& times, double rate) {
  if (times.size() < 2) return std::nullopt;
  const auto [first, last] = picture_range(times, rate);
  const std::vector<std::size_t> shown = frames_of_pictures(times, rate);
  std::int64_t without = 0;
  double farthest = 0;
  for (std::int64_t k = first; k <= last; ++k) {
    const double off = std::abs(times[shown[static_cast<std::size_t>(k - first)]] - static_cast<double>(k) / rate);
    if (off * rate > at_its_time) ++without;
    farthest = std::max(farthest, off);
  }
  const double natural = frame_rate(times);
  if (without > 0)
    return fmt::format(
        "{} of {} pictures at {:.6g} per second have no frame at their time, up to {:.3g} ms off; the frames of the "
        "run "
        "fit {} per second, and a run with output.every: {:.6g} fits {:.6g}",
        without, last - first + 1, rate, 1e3 * farthest, fitting_rates(natural), 1 / rate, rate);
  const auto between = std::count_if(times.begin(), times.end(), [&](double time) {
    return std::abs(time * rate - std::round(time * rate)) > at_its_time;
  });
  if (rate < natural * (1 - 1e-6) || between == 0) return std::nullopt;  // leaving every second one out is no misfit
  return fmt::format("{} of {} frames lie between two pictures at {:.6g} per second", between, times.size(), rate);
}

}  // namespace drench
