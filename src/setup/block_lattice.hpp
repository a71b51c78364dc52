#pragma once
// The lattice of particles that fills a block of liquid from side to side and holds the block's mass.

#include <array>
#include <string>

#include "base/types.hpp"
#include "scene/scene.hpp"

namespace drench {

/// The number of layers along an axis is the side over the spacing d, rounded; one more where layers would be wider
/// than 1.05 d. They fill the side, and the particles share the block's mass: where all sides are multiples of d, each
/// is a full particle. The density ratio on the lattice stays within 0.5 % of that of a lattice of spacing d (cubic
/// kernel, 2 spacings).
class BlockLattice {
 public:
  BlockLattice(const Box& box, double spacing);

  /// Of all particles. A double, since it may be too large for an integer.
  double count() const { return layers_[0] * layers_[1] * layers_[2]; }
  /// m: width of the layers along each axis.
  const Vec3& step() const { return step_; }
  /// m: of the narrowest layers.
  double narrowest() const;
  /// Quanta: of the lightest particle.
  Quanta least_mass() const { return least_; }
  /// "x", "x and z", "x, y and z": the axes along which layers are narrower than 0.95 d; "" for none.
  std::string squeezed_axes() const;

  /// Calls visit(position, mass) for each particle, x fastest. The masses' sum is the block's mass, rounded to a
  /// quantum.
  template <class Visit>
  void for_each(Visit visit) const {
    Quanta heavier = heavier_;
    for (double k = 0; k < layers_[2]; ++k)
      for (double j = 0; j < layers_[1]; ++j)
        for (double i = 0; i < layers_[0]; ++i)
          visit(Vec3{first_[0] + i * step_[0], first_[1] + j * step_[1], first_[2] + k * step_[2]},
                least_ + (heavier-- > 0 ? 1 : 0));
  }

 private:
  double spacing_;
  std::array<double, 3> layers_;  // whole numbers
  Vec3 first_, step_;
  Quanta least_ = quanta_per_particle;
  Quanta heavier_ = 0;  // so many of the first particles have a quantum more
};

}  // namespace drench
