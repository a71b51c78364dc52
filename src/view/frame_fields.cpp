#include "view/frame_fields.hpp"

#include <vtkDataArray.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace drench {
namespace {

void widen(FieldRange& range, vtkDataArray* values) {
  double found[2];
  values->GetFiniteRange(found, values->GetNumberOfComponents() == 1 ? 0 : -1);
  if (!(found[0] <= found[1])) return;  // no values
  range.low = range.low <= range.high ? std::min(range.low, found[0]) : found[0];
  range.high = std::max(range.high, found[1]);
}

}  // namespace

std::string unit_of(const std::string& field) {
  static const std::map<std::string, std::string> units{
      {"velocity", "m/s"}, {"density", "kg/m³"},  {"pressure", "Pa"}, {"mass", "kg"},   {"radius", "m"},
      {"age", "s"},        {"liquid_mass", "kg"}, {"pin_force", "N"}, {"spin", "1/s"}};
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
