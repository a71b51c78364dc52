#pragma once
// Small helpers for filling VTK grids; for the .cpp files of src/output only.

#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkDataSetAttributes.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>

#include <cstddef>
#include <span>
#include <type_traits>

#include "output/grids.hpp"

namespace drench {

/// Adds the field `name` with `count` values value(i), Vec3 or scalar, to `to` as an array of type `Array`.
template <class Array, class Value>
void add_field(vtkDataSetAttributes* to, const char* name, std::size_t count, Value&& value) {
  using Out = typename Array::ValueType;
  constexpr bool vector = std::is_convertible_v<decltype(value(std::size_t{0})), Vec3>;
  vtkNew<Array> array;
  array->SetName(name);
  array->SetNumberOfComponents(vector ? 3 : 1);
  array->SetNumberOfTuples(static_cast<vtkIdType>(count));
  Out* out = array->GetPointer(0);
  for (std::size_t i = 0; i < count; ++i) {
    if constexpr (vector) {
      const Vec3 v = value(i);
      for (std::size_t k = 0; k < 3; ++k) out[3 * i + k] = static_cast<Out>(v[k]);
    } else {
      out[i] = static_cast<Out>(value(i));
    }
  }
  to->AddArray(array);
}

inline vtkSmartPointer<vtkPoints> make_points(std::span<const Vec3> positions) {
  auto points = vtkSmartPointer<vtkPoints>::New();
  points->SetDataTypeToFloat();
  points->SetNumberOfPoints(static_cast<vtkIdType>(positions.size()));
  for (std::size_t i = 0; i < positions.size(); ++i) points->SetPoint(static_cast<vtkIdType>(i), positions[i].data());
  return points;
}

/// A grid of `positions` with one vertex cell each.
inline Grid make_vertices(std::span<const Vec3> positions) {
  const auto count = static_cast<vtkIdType>(positions.size());
  vtkNew<vtkIdTypeArray> offsets, connectivity;
  offsets->SetNumberOfValues(count + 1);
  connectivity->SetNumberOfValues(count);
  for (vtkIdType i = 0; i <= count; ++i) offsets->SetValue(i, i);
  for (vtkIdType i = 0; i < count; ++i) connectivity->SetValue(i, i);
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, connectivity);
  auto grid = Grid::New();
  grid->SetPoints(make_points(positions));
  grid->SetCells(VTK_VERTEX, cells);
  return grid;
}

/// Arrays that the scene has no need of are empty in a HostState; in the picture they are 0.
template <class T>
T value_or_zero(const std::vector<T>& values, std::size_t i) {
  return i < values.size() ? values[i] : T{};
}

/// Pa: the sum of what both pressure solves leave at particle i.
inline double particle_pressure(const Model& model, const HostState& state, std::size_t i) {
  return model.rest_density *
         (value_or_zero(state.fluid_kappa_density, i) + value_or_zero(state.fluid_kappa_divergence, i));
}

}  // namespace drench
