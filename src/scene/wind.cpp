#include <cmath>

#include "scene/scene.hpp"

namespace drench {

Vec3 WindScene::at(double time) const {
  Vec3 u = velocity.at(time);
  if (gusts.empty()) return u;
  const auto after = std::find_if(gusts.begin(), gusts.end(), [&](const GustScene& gust) { return gust.time > time; });
  const GustScene &next = after == gusts.end() ? gusts.back() : *after,
                  &last = after == gusts.begin() ? next : after[-1];
  const double part = next.time > last.time ? (time - last.time) / (next.time - last.time) : 0;
  for (std::size_t a = 0; a < 3; ++a) u[a] += (1 - part) * last.velocity[a] + part * next.velocity[a];
  return u;
}

double WindScene::fastest() const {
  const auto speed = [](const Vec3& u) { return std::hypot(u[0], u[1], u[2]); };
  if (velocity.has_keys()) {
    double gust = 0;
    for (const GustScene& g : gusts) gust = std::max(gust, speed(g.velocity));
    return velocity.largest() + gust;
  }
  double fastest = gusts.empty() ? velocity.largest() : 0;
  for (const GustScene& gust : gusts) fastest = std::max(fastest, speed(at(gust.time)));
  return fastest;
}

}  // namespace drench
