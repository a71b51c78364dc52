// Wicking in drench against published measurements: constants are fitted to a part of the data, the rest is predicted.
// Data and sources: published_curves.hpp.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "published_curves.hpp"
#include "scene/fabrics.hpp"
#include "watched_cloth.hpp"

namespace drench::test {
namespace {

constexpr double predicted_within = 0.15;  // the aim for what was not fitted

/// D sⁿ and ℓ.
struct Law {
  double diffusivity, exponent, height;
};

/// Where the saturation falls below `level` along a strip that is full at 0: position along it, from the nodes' values.
double front(const std::vector<double>& saturation, double h, double level) {
  std::size_t last = 0;
  while (last + 1 < saturation.size() && saturation[last + 1] > level) ++last;
  if (last + 1 == saturation.size()) return static_cast<double>(last) * h;
  const double a = saturation[last], b = saturation[last + 1];
  return (static_cast<double>(last) + (a - level) / (a - b)) * h;
}

/// A strip two cells wide whose end at 0 is held full, along y if it hangs or along z of a table, dry at the start.
class Strip {
 public:
  Strip(const Law& law, int cells, double h, double step, bool hangs, Books& books)
      : cells_(cells), h_(h), axis_(hangs ? 1 : 2), run_(yaml(law, cells, h, step, hangs), books) {}
  void steps(int count) { run_.steps(count); }
  /// From 0 on, the mean over the width.
  std::vector<double> saturation() const {
    std::vector<double> sum(static_cast<std::size_t>(cells_) + 1, 0.0);
    for (std::size_t n = 0; n < run_.nodes(); ++n)
      sum[static_cast<std::size_t>(std::lround(run_.place(n)[axis_] / h_))] += run_.saturation(n) / 3;
    return sum;
  }

 private:
  static std::string yaml(const Law& law, int cells, double h, double step, bool hangs) {
    const double length = cells * h;
    return still_cloth(
        fmt::format("{{grid: {{size: [{}, {}], nodes: [3, {}]}}}}", 2 * h, length, cells + 1), step,
        fmt::format("diffusivity: {}, diffusion_exponent: {}, capillary_height: {}, max_saturation: 1", law.diffusivity,
                    law.exponent, law.height),
        fmt::format("    place: {{position: [0, {}, {}], rotate: {{axis: [1, 0, 0], degrees: {}}}}}\n"
                    "    hold_saturation: [{{box: {{min: [-1, -1, -1], max: [1, {}, {}]}}, value: 1}}]\n",
                    hangs ? length / 2 : 0, hangs ? 0 : length / 2, hangs ? 90 : 0, hangs ? h / 2 : 1,
                    hangs ? 1 : h / 2),
        hangs ? "gravity: [0, -9.81, 0]" : "gravity: [0, 0, 0]");
  }

  int cells_;
  double h_;
  std::size_t axis_;
  Watched run_;
};

/// Heights at wicking_times. The water's edge is where the eye sees fabric darken: a tenth full.
std::vector<double> heights(const Law& law, int cells, Books& books) {
  constexpr double h = 0.002;
  Strip strip(law, cells, h, 1, true, books);
  std::vector<double> found;
  int done = 0;
  for (const double time : wicking_times) {
    strip.steps(static_cast<int>(time) - done);
    done = static_cast<int>(time);
    found.push_back(front(strip.saturation(), h, 0.1));
  }
  return found;
}

/// The largest error of heights from the number `first` on, before `end`.
double worst(const std::vector<double>& found, const WickingCurve& curve, std::size_t first, std::size_t end) {
  double most = 0;
  for (std::size_t k = first; k < end; ++k) most = std::max(most, std::fabs(found[k] / curve.height[k] - 1));
  return most;
}

void print(const char* what, const std::vector<double>& found, const WickingCurve& curve) {
  std::printf("%s, %s:", what, curve.knit);
  for (std::size_t k = 0; k < found.size(); ++k)
    std::printf(" %.0f s %.1f of %.1f±%.1f mm;", wicking_times[k], 1e3 * found[k], 1e3 * curve.height[k],
                1e3 * curve.scatter[k]);
  std::printf("\n");
}

}  // namespace

TEST(published_fabric, socks_wick_as_measured) {
  // Least squares of the relative errors over the first 180 s, with n = 5 of 1, 2, 3 and 5 for the flat nylon.
  constexpr Law coarse{1.50e-4, 5, 0.126}, fine{2.02e-4, 5, 0.226};
  Books books;
  const auto found = heights(coarse, 60, books), finer = heights(fine, 90, books);
  const std::string reference = "Jasper & Tandel 2025, mean of nine strips";
  const WickingCurve& nylon = sock_curves[0];
  print("fitted to its first 180 s", found, nylon);
  report({"water in a hanging sock knit, flat nylon, 108 needles: height from 30 s to 180 s, fitted, − 1", reference,
          worst(found, nylon, 0, 4), 0.05});
  report({"flat nylon, 108 needles: height from 300 s to 600 s, predicted by its first 180 s, − 1", reference,
          worst(found, nylon, 4, 7), predicted_within});
  for (std::size_t c : {1u, 2u, 3u}) {
    print("predicted by the flat nylon", found, sock_curves[c]);
    report({fmt::format("{}: height from 30 s to 600 s, predicted by the flat nylon's first 180 s, − 1",
                        sock_curves[c].knit),
            reference, worst(found, sock_curves[c], 0, 7), predicted_within});
  }
  const WickingCurve& last = sock_curves[4];
  print("fitted to its first 180 s", finer, last);
  report({"flat polyester, 200 needles: height from 30 s to 180 s, fitted with the same exponent, − 1", reference,
          worst(finer, last, 0, 4), 0.05});
  report({"flat polyester, 200 needles: height from 300 s to 600 s, predicted by its first 180 s, − 1", reference,
          worst(finer, last, 4, 7), predicted_within});
  // The same for the knits of 144 needles, each with constants of its own.
  const Law flat{2.14e-4, 5, 0.206}, terry{1.465e-4, 5, 0.192};
  for (const auto& [law, c] : {std::pair(flat, 5u), std::pair(terry, 6u)}) {
    const WickingCurve& curve = sock_curves[c];
    const auto height = heights(law, 90, books);
    print("fitted to its first 180 s", height, curve);
    report({fmt::format("{}: height from 30 s to 180 s, fitted with the same exponent, − 1", curve.knit), reference,
            worst(height, curve, 0, 4), 0.05});
    report({fmt::format("{}: height from 300 s to 600 s, predicted by its first 180 s, − 1", curve.knit), reference,
            worst(height, curve, 4, 7), predicted_within});
  }
  books.print("sock knits that hang into water");
}

namespace {

/// The wicking of a named fabric.
Law law_of(const std::string& name) {
  Law law{};
  for (const Fabric& fabric : fabrics()) {
    if (fabric.name != name) continue;
    for (const FabricValue& v : fabric.values) {
      if (v.key == "porous.diffusivity") law.diffusivity = std::stod(v.value);
      if (v.key == "porous.diffusion_exponent") law.exponent = std::stod(v.value);
      if (v.key == "porous.capillary_height") law.height = std::stod(v.value);
    }
  }
  return law;
}

}  // namespace

/// What users get: the values in src/scene/fabrics.yaml, which are fitted to the whole curve.
TEST(published_fabric, named_fabrics_wick_as_measured) {
  Books books;
  for (const WickingCurve& curve : sock_curves) {
    const int cells = curve.height.back() < 0.1 ? 60 : 90;  // the strip ends well above the water's edge
    const auto found = heights(law_of(curve.fabric), cells, books);
    print("named fabric", found, curve);
    report({fmt::format("fabric {}: height from 30 s to 600 s, fitted, − 1", curve.fabric),
            "Jasper & Tandel 2025, mean of nine strips", worst(found, curve, 0, 7), 0.05});
  }
  books.print("named fabrics that hang into water");
}

namespace {

/// A strip on a table that fills from one end. D is fitted to the place of the front, the rest is predicted.
void compare_filling(const Imbibition& curve, const Law& law, int cells, double h, Books& books) {
  constexpr double time = 64, root = 8;
  Strip strip(law, cells, h, 0.5, false, books);
  strip.steps(128);
  const std::vector<double> s = strip.saturation();
  double absorbed = 0, off = 0;
  for (std::size_t k = 0; k < s.size(); ++k) absorbed += (k == 0 ? 0.5 : 1) * s[k] * h / root;
  for (const ProfilePoint& p : curve.profile) {
    const double at = p.o * root / h;
    const std::size_t k = static_cast<std::size_t>(at);
    const double here = s[k] + (at - static_cast<double>(k)) * (s[k + 1] - s[k]);
    if (p.o < 0.95 * curve.front) off = std::max(off, std::fabs(here - p.saturation));
    std::printf("%s: x/√t %.4g mm/√s: %.3f, published %.3f ± %.3f\n", curve.sheet, 1e3 * p.o, here, p.saturation,
                p.scatter);
  }
  const std::string what = fmt::format("water in {} after {:g} s: ", curve.sheet, time);
  report({what + "position of the front, fitted, − 1", curve.reference,
          std::fabs(front(s, h, 0.5) / root / curve.front - 1), 0.05});
  report({what + "absorbed liquid, predicted, − 1", curve.reference, std::fabs(absorbed / curve.absorbed - 1),
          predicted_within});
  report(
      {what + "saturation before 0.95 of the front, predicted, largest error", curve.reference, off, predicted_within});
}

}  // namespace

TEST(published_fabric, paper_and_a_membrane_fill_as_published) {
  Books books;
  compare_filling(paper, {4.1e-5, 20, 1}, 50, 0.0004, books);   // the largest n of the key: paper is steeper still
  compare_filling(membrane, {6.7e-5, 5, 1}, 60, 0.001, books);  // the n of the sock knits
  books.print("paper and a membrane that fill");
}

}  // namespace drench::test
