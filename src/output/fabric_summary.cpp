#include "output/fabric_summary.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "setup/cloth_mesh.hpp"

namespace drench {

void FabricSummary::add(double time, const std::vector<FabricNumbers>& fabrics) {
  cloths_.resize(fabrics.size());
  for (std::size_t k = 0; k < fabrics.size(); ++k) {
    Cloth& c = cloths_[k];
    const FabricNumbers& now = c.last = fabrics[k];
    c.most = std::max(c.most, now.liquid);
    c.area = std::max(c.area, now.wet_area);
    c.warp = std::max(c.warp, now.wet_warp);
    c.weft = std::max(c.weft, now.wet_weft);
    if (now.through() > 0 && c.struck < 0) {
      c.struck = time;
      c.struck_before = first_;
    }
    const bool is_dry = static_cast<double>(now.liquid) < dry * static_cast<double>(c.most);
    if (!is_dry) c.dried = -1;
    if (is_dry && c.dried < 0) c.dried = time;
  }
  first_ = false;
}

std::string FabricSummary::line(const Model& model, const Cloth& c) const {
  const auto grams = [&](Quanta quanta) { return 1000 * static_cast<double>(quanta) * model.quantum; };
  std::string text = fmt::format(
      "{}: holds {:.4g} g, at most {:.4g} g; wet at most {:.4g} cm², {:.4g} mm along the warp, "
      "{:.4g} mm along the weft",
      cloth_label(model.cloths[static_cast<std::size_t>(c.last.cloth)].name), grams(c.last.liquid), grams(c.most),
      1e4 * c.area, 1e3 * c.warp, 1e3 * c.weft);
  if (model.counts_faces())
    text += fmt::format("; absorbed {:.4g} g, rewet {:.4g} g", grams(c.last.taken_front + c.last.taken_back),
                        grams(c.last.returned()));
  if (c.struck >= 0)
    text += fmt::format("; strike-through {:.4g} g, first {} {:.4g} s", grams(c.last.through()),
                        c.struck_before ? "before" : "at", c.struck);
  if (c.dried >= 0) text += fmt::format("; dry at {:.4g} s", c.dried);
  return text + "\n";
}

std::string FabricSummary::lines(const Model& model) const {
  std::string text;
  for (const Cloth& c : cloths_) text += line(model, c);
  return text;
}

}  // namespace drench
