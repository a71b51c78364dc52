#pragma once
// The sources that flow: nozzles, sprays and rain.

#include <string>
#include <vector>

#include "state/model.hpp"

namespace drench {

inline constexpr double max_mouth_points = 1e6;

/// "fluid: jet 1", "fluid: rain 2", "fluid: spray 0", "fluid: mesh_jet 3": of an entry of Model::jets, which has them
/// in this order.
std::string jet_label(const Model& model, std::size_t number);

/// Lattice and interval of a jet, which a SetupError calls `name`. Needs model.spacing. SetupError: a radius below d/2
/// or a side below d, a mouth of too many points, no velocity, an `up` along it, a centre outside the domain.
Jet make_jet(const Model& model, const JetScene& scene, const std::string& name);

/// Rain as a jet whose mouth is the rectangle: its offsets are a low-discrepancy sequence on it, and each particle has
/// the mass of a drop, or of several where one would have less than an eighth of a full particle's. SetupError, as
/// above, and for drops that are larger than a particle, or fall along no direction.
Jet make_rain(const Model& model, const RainScene& scene, const std::string& name);

/// A spray as a jet from a disc whose area is flow over speed: particles leave in the directions of a low-discrepancy
/// sequence on the cone. SetupError, as above.
Jet make_spray(const Model& model, const SprayScene& scene, const std::string& name);

/// The faces of a mesh as a jet. Reads its files. SetupError, as above, and those of emitting_faces().
Jet make_mesh_jet(const Model& model, const MeshJetScene& scene, const std::string& name);

/// The same of all jets of the scene, followed by its rains, sprays and mesh_jets. Needs model.bodies. A warning counts
/// the points of a mouth that are in a solid.
std::vector<Jet> make_jets(const Model& model, std::vector<std::string>& warnings);

}  // namespace drench
