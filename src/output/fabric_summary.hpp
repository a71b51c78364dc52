#pragma once
// What a run comes to for each porous cloth: when liquid struck through, how far it spread, when the cloth was dry.

#include <string>
#include <vector>

#include "pipeline/step_report.hpp"
#include "state/model.hpp"

namespace drench {

/// Follows the steps of a run (output.fabric). A run that goes on from a checkpoint follows those that it makes itself.
class FabricSummary {
 public:
  /// Cloth is dry when it holds less than this part of the most that it held, 1.
  static constexpr double dry = 0.01;

  void add(double time, const std::vector<FabricNumbers>& fabrics);
  /// A line for each porous cloth, "" without any.
  std::string lines(const Model& model) const;

 private:
  struct Cloth {
    FabricNumbers last;
    Quanta most = 0;
    double area = 0, warp = 0, weft = 0;  // m², m, m: the largest
    double struck = -1, dried = -1;       // s; −1: not yet
    bool struck_before = false;           // it was so in the first step that was seen
  };
  std::string line(const Model& model, const Cloth& cloth) const;
  std::vector<Cloth> cloths_;
  bool first_ = true;
};

}  // namespace drench
