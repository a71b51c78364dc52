#include "output/particle_file.hpp"

#include <fmt/format.h>
#include <vtkDataArray.h>
#include <vtkPointData.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "output/text_file.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

enum class Kind { real32, real64, integer };

struct Column {
  std::string name;  // as the run has it
  Kind kind;
  vtkDataArray* values;
  int components;
};

Kind kind_of(vtkDataArray* array) {
  if (array->GetDataType() == VTK_DOUBLE) return Kind::real64;
  return array->GetDataType() == VTK_FLOAT ? Kind::real32 : Kind::integer;
}

std::vector<Column> columns_of(vtkUnstructuredGrid* particles) {
  std::vector<Column> columns;
  vtkPointData* fields = particles->GetPointData();
  for (int i = 0; i < fields->GetNumberOfArrays(); ++i)
    if (vtkDataArray* array = fields->GetArray(i); array && array->GetName())
      columns.push_back({array->GetName(), kind_of(array), array, array->GetNumberOfComponents()});
  return columns;
}

/// Appends a number's bytes, the highest or the lowest first.
template <std::endian order, class T>
void append(std::string& out, T value) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if constexpr (order != std::endian::native) std::reverse(bytes.begin(), bytes.end());
  out.append(bytes.data(), bytes.size());
}

template <std::endian order>
void append_value(std::string& out, const Column& column, Kind kind, vtkIdType row, int component) {
  const double value = column.values->GetComponent(row, component);
  if (kind == Kind::real64) return append<order>(out, value);
  if (kind == Kind::real32) return append<order>(out, static_cast<float>(value));
  if (std::abs(value) > std::numeric_limits<std::int32_t>::max())
    throw std::runtime_error(
        fmt::format("{} {:.0f} does not fit into the 4 bytes that such a file has for it", column.name, value));
  append<order>(out, static_cast<std::int32_t>(value));
}

std::string bgeo_name(const std::string& field) {
  if (field == "velocity") return "v";
  return field == "radius" ? "pscale" : field;
}

std::vector<std::string> ply_names(const Column& column) {
  if (column.components == 1) return {column.name};
  std::vector<std::string> names;
  for (int c = 0; c < column.components; ++c) {
    if (column.components > 3)
      names.push_back(fmt::format("{}_{}", column.name, c));
    else
      names.push_back(fmt::format("{}{}", column.name == "velocity" ? "v" : column.name + "_", "xyz"[c]));
  }
  return names;
}

const char* ply_type(Kind kind) { return kind == Kind::integer ? "int" : kind == Kind::real64 ? "double" : "float"; }

void append_bgeo_attribute(std::string& out, const Column& column) {
  constexpr auto big = std::endian::big;
  const std::string name = bgeo_name(column.name);
  append<big>(out, static_cast<std::uint16_t>(name.size()));
  out += name;
  append<big>(out, static_cast<std::uint16_t>(column.components));
  append<big>(out, std::int32_t{column.kind == Kind::integer ? 1 : column.components == 3 ? 5 : 0});
  for (int c = 0; c < column.components; ++c) append<big>(out, std::int32_t{0});  // of a point that says nothing
}

}  // namespace

void write_bgeo(const fs::path& path, vtkUnstructuredGrid* particles) {
  constexpr auto big = std::endian::big;
  const std::vector<Column> columns = columns_of(particles);
  const vtkIdType count = particles->GetNumberOfPoints();
  std::string out = "BgeoV";
  append<big>(out, std::int32_t{5});
  append<big>(out, static_cast<std::int32_t>(count));
  for (int i = 0; i < 3; ++i) append<big>(out, std::int32_t{0});  // primitives, point groups, primitive groups
  append<big>(out, static_cast<std::int32_t>(columns.size()));
  for (int i = 0; i < 3; ++i) append<big>(out, std::int32_t{0});  // attributes of vertices, of primitives, of the whole
  for (const Column& column : columns) append_bgeo_attribute(out, column);
  std::size_t row_bytes = 16;
  for (const Column& column : columns) row_bytes += 4 * static_cast<std::size_t>(column.components);
  out.reserve(out.size() + row_bytes * static_cast<std::size_t>(count) + 2);
  for (vtkIdType i = 0; i < count; ++i) {
    std::array<double, 3> x{};
    particles->GetPoint(i, x.data());
    for (const double c : x) append<big>(out, static_cast<float>(c));
    append<big>(out, 1.0F);  // homogeneous coordinate
    for (const Column& column : columns)
      for (int c = 0; c < column.components; ++c)
        append_value<big>(out, column, column.kind == Kind::integer ? Kind::integer : Kind::real32, i, c);
  }
  out += std::string("\x00\xff", 2);
  write_atomically(path, out);
}

void write_ply(const fs::path& path, vtkUnstructuredGrid* particles, double time) {
  constexpr auto little = std::endian::little;
  const std::vector<Column> columns = columns_of(particles);
  const vtkIdType count = particles->GetNumberOfPoints();
  std::string out = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment drench: particles at {:.10g} s, SI units\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n",
      time, count);
  for (const Column& column : columns)
    for (const std::string& name : ply_names(column))
      out += fmt::format("property {} {}\n", ply_type(column.kind), name);
  out += "end_header\n";
  for (vtkIdType i = 0; i < count; ++i) {
    std::array<double, 3> x{};
    particles->GetPoint(i, x.data());
    for (const double c : x) append<little>(out, static_cast<float>(c));
    for (const Column& column : columns)
      for (int c = 0; c < column.components; ++c) append_value<little>(out, column, column.kind, i, c);
  }
  write_atomically(path, out);
}

}  // namespace drench
