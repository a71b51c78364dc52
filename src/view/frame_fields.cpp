#include "view/frame_fields.hpp"

#include <vtkDataArray.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace drench {
namespace {

constexpr double beyond = 0.005;  // share of the values at each end that do not widen the range

/// Finite values; lengths of vectors.
std::vector<double> numbers_of(vtkDataArray* values) {
  std::vector<double> numbers;
  const int components = values->GetNumberOfComponents();
  for (vtkIdType i = 0; i < values->GetNumberOfTuples(); ++i) {
    double square = 0;
    for (int c = 0; c < components; ++c) square += values->GetComponent(i, c) * values->GetComponent(i, c);
    const double number = components == 1 ? values->GetComponent(i, 0) : std::sqrt(square);
    if (std::isfinite(number)) numbers.push_back(number);
  }
  return numbers;
}

/// A few particles that are struck hard do not make all others look alike.
void widen(FieldRange& range, vtkDataArray* values) {
  std::vector<double> numbers = numbers_of(values);
  if (numbers.empty()) return;
  std::sort(numbers.begin(), numbers.end());
  const auto cut = static_cast<std::size_t>(beyond * static_cast<double>(numbers.size()));
  const double low = numbers[cut], high = numbers[numbers.size() - 1 - cut];
  const bool first = range.low > range.high;
  range.low = first ? low : std::min(range.low, low);
  range.high = first ? high : std::max(range.high, high);
}

}  // namespace

std::string unit_of(const std::string& field) {
  static const std::map<std::string, std::string> units{{"velocity", "m/s"}, {"density", "kg/m³"},
                                                        {"pressure", "Pa"},  {"fitted_pressure", "Pa"},
                                                        {"mass", "kg"},      {"radius", "m"},
                                                        {"age", "s"},        {"liquid_mass", "kg"},
                                                        {"pin_force", "N"},  {"contact_pressure", "Pa"},
                                                        {"spin", "1/s"},     {"concentration", "kg/kg"},
                                                        {"solute", "kg/m²"}, {"temperature", "°C"}};
  const auto it = units.find(field);
  return it == units.end() ? "" : it->second;
}

std::vector<FieldRange> field_ranges(const std::vector<Moment>& moments) {
  std::vector<FieldRange> ranges;
  for (const Moment& moment : moments)
    for (const auto& grid : {moment.fluid, moment.surface, moment.cloth}) {
      vtkPointData* fields = grid ? grid->GetPointData() : nullptr;
      for (int i = 0; fields && i < fields->GetNumberOfArrays(); ++i) {
        vtkDataArray* values = fields->GetArray(i);
        if (!values || !values->GetName() || std::string(values->GetName()) == "normal") continue;
        const auto known = std::find_if(ranges.begin(), ranges.end(),
                                        [&](const FieldRange& range) { return range.name == values->GetName(); });
        FieldRange& range = known != ranges.end() ? *known : ranges.emplace_back(FieldRange{values->GetName(), 1, 0});
        widen(range, values);
      }
    }
  std::erase_if(ranges, [](const FieldRange& range) { return range.low > range.high; });
  return ranges;
}

}  // namespace drench
