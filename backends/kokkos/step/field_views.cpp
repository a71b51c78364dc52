#include "step/field_views.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "state/needed_fields.hpp"

namespace drench::kokkos_backend {
namespace {

template <class T>
constexpr FieldView::Type type_of() {
  if constexpr (std::is_same_v<T, float>) return FieldView::Type::float32;
  if constexpr (std::is_same_v<T, double>) return FieldView::Type::float64;
  if constexpr (std::is_same_v<T, std::int64_t>) return FieldView::Type::int64;
  if constexpr (std::is_same_v<T, std::uint8_t>) return FieldView::Type::uint8;
}

/// A row as numbers.
template <class T>
struct Row {
  using number = T;
  static constexpr int columns = 1;
};
template <>
struct Row<Real3> {
  using number = Real;
  static constexpr int columns = 3;
};
template <>
struct Row<Vec3> {
  using number = double;
  static constexpr int columns = 3;
};
template <>
struct Row<drench::Quaternion> {
  using number = double;
  static constexpr int columns = 4;
};
static_assert(sizeof(Real3) == 3 * sizeof(Real) && sizeof(Vec3) == 3 * sizeof(double));

template <class T>
FieldView described(std::string_view name, std::string_view unit) {
  FieldView view;
  view.name = name;
  view.unit = unit;
  view.type = type_of<typename Row<T>::number>();
  view.columns = Row<T>::columns;
  view.row_bytes = sizeof(T);
  view.where = on_host ? FieldView::Memory::host : FieldView::Memory::cuda;
  return view;
}

/// The first `rows` entries of an array. The view's memory is one more owner of it.
template <class T>
FieldView of_array(std::string_view name, std::string_view unit, const Array<T>& a, Index rows) {
  FieldView view = described<T>(name, unit);
  view.rows = a.extent(0) > 0 ? rows : 0;
  view.data = view.rows > 0 ? a.data() : nullptr;
  view.memory = std::make_shared<Array<T>>(a);
  return view;
}

/// A part of each body's state, `offset` bytes into it; of bodies that all stand still a copy of `still`.
template <class T>
FieldView of_bodies(const char* name, const Bodies& bodies, std::size_t offset, const std::vector<T>& still) {
  FieldView view = described<T>(name, unit_of_field(name));
  view.rows = bodies.count;
  if (bodies.state.exists()) {
    view.data = reinterpret_cast<const std::byte*>(bodies.state.data()) + offset;
    view.row_bytes = sizeof(RigidState);
    view.memory = std::make_shared<Array<RigidState>>(bodies.state);
    return view;
  }
  const auto copy = std::make_shared<const std::vector<T>>(still);
  view.data = copy->data();
  view.where = FieldView::Memory::host;
  view.memory = copy;
  return view;
}

/// The members of RigidState have other names than the table's fields.
void add_bodies(const Bodies& bodies, std::vector<FieldView>& views) {
  static_assert(sizeof(Double3) == sizeof(Vec3) && sizeof(Quaternion) == sizeof(drench::Quaternion));
  views.push_back(of_bodies("body_position", bodies, offsetof(RigidState, position), bodies.static_position));
  views.push_back(of_bodies("body_orientation", bodies, offsetof(RigidState, orientation), bodies.static_orientation));
  views.push_back(of_bodies("body_velocity", bodies, offsetof(RigidState, velocity), bodies.static_velocity));
  views.push_back(of_bodies("body_angular_velocity", bodies, offsetof(RigidState, spin), bodies.static_spin));
}

}  // namespace

std::vector<FieldView> field_views(const Model& model, const Fluid& fluid, const Bodies& bodies, const Cloth& cloth) {
  std::vector<FieldView> views;
#define DRENCH_ADD(owner, name, host_type, unit, array, rows) \
  if (needs_field(model, #owner "_" #name)) views.push_back(of_array(#owner "_" #name, unit, array.name, rows));
#define DRENCH_PARTICLE(owner, name, type, unit, needed) \
  DRENCH_ADD(owner, name, type, unit, fluid.particles, fluid.particles.count)
  if (model.has_fluid()) {
    DRENCH_PARTICLE_FIELDS(DRENCH_PARTICLE)
  }
#undef DRENCH_PARTICLE
  if (model.has_boundary()) {
#define DRENCH_BOUNDARY(owner, name, type, unit, needed) \
  DRENCH_ADD(owner, name, type, unit, bodies.boundary, bodies.boundary.count)
    DRENCH_BOUNDARY_FIELDS(DRENCH_BOUNDARY)
#undef DRENCH_BOUNDARY
  }
  if (!model.bodies.empty()) add_bodies(bodies, views);
  if (model.has_cloth()) {
#define DRENCH_NODE(owner, name, type, unit, needed) DRENCH_ADD(owner, name, type, unit, cloth.nodes, cloth.nodes.count)
    DRENCH_NODE_FIELDS(DRENCH_NODE)
#undef DRENCH_NODE
#define DRENCH_SAMPLE(owner, name, type, unit, needed) \
  DRENCH_ADD(owner, name, type, unit, cloth.samples, cloth.samples.count)
    DRENCH_SAMPLE_FIELDS(DRENCH_SAMPLE)
#undef DRENCH_SAMPLE
  }
#undef DRENCH_ADD
  return views;
}

}  // namespace drench::kokkos_backend

namespace drench {

void copy_to_host(const FieldView& view, void* to) {
  using kokkos_backend::MemSpace;
  using DeviceBytes = Kokkos::View<const std::byte*, MemSpace, Kokkos::MemoryUnmanaged>;
  if (view.rows == 0) return;
  const std::size_t number = view.type == FieldView::Type::uint8 ? 1 : view.type == FieldView::Type::float32 ? 4 : 8;
  const std::size_t row = number * static_cast<std::size_t>(view.columns),
                    step = static_cast<std::size_t>(view.row_bytes);
  const std::size_t size = static_cast<std::size_t>(view.rows - 1) * step + row;
  std::vector<std::byte> span(size);
  const auto* data = static_cast<const std::byte*>(view.data);
  Kokkos::View<std::byte*, Kokkos::HostSpace, Kokkos::MemoryUnmanaged> host(span.data(), size);
  if (view.where == FieldView::Memory::host)
    std::memcpy(span.data(), data, size);
  else
    Kokkos::deep_copy(host, DeviceBytes(data, size));
  for (std::size_t k = 0; k < static_cast<std::size_t>(view.rows); ++k)
    std::copy_n(span.data() + k * step, row, static_cast<std::byte*>(to) + k * row);
}

}  // namespace drench
