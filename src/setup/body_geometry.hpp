#pragma once
// The shapes of the solid bodies: from the scene's description to a Body, and distances to the analytic ones.

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "setup/surface_mesh.hpp"
#include "state/host_state.hpp"
#include "state/model.hpp"

namespace drench {

/// Distance (m) of x to the body's surface at t = 0: positive on the free side, negative inside the solid. `normal` is
/// the unit vector towards the free side, the distance's gradient; on an edge or at a sphere's centre, one of those
/// possible. Of a mesh: from its distance field; 1e30 and no normal beyond it, and everywhere if it has none (it is a
/// thin wall).
double signed_distance(const Body& body, const Vec3& x, Vec3& normal);

/// Depths (m) inside a body up to this come from rounding, as of a cloth that lies on its surface.
double rounding_of(const Body& body);

/// "body 'cup'", or "bodies.1" of one without a name.
std::string body_label(const std::string& name, std::size_t index);
/// "body 'cup', bodies.0 and 7 more"
std::string body_labels(const std::vector<Body>& bodies, const std::set<std::size_t>& indices);

/// What the volume of a mesh is for: it decides what is advised if the mesh has large holes.
enum class MeshUse {
  solid,            // of a body beside moving cloth, or a dynamic one
  solid_or_vessel,  // of a body that may also be a thin wall
  liquid            // a source's
};

/// The texture coordinates of the file of a body's mesh, of the triangles as the body has them: turned outwards,
/// without those that are left out. `untextured`: SurfaceMesh::untextured of that file. SetupError: it cannot be read.
TextureCorners body_texture(const BodyScene& scene, const std::string& scene_path, std::size_t& untextured);

/// Resolves a body: unit normal and axis, spin in rad/s, mesh read, scaled, placed and closed (setup/solid_mesh.hpp). A
/// mesh without an inside, or one that the scene takes for a vessel, stays as it is: a thin wall. The samples are not
/// made here. `name` begins the text of a SetupError and of the lines that are added to `warnings`.
Body make_body(const BodyScene& scene, const std::string& scene_path, const std::string& name,
               std::vector<std::string>* warnings = nullptr, MeshUse use = MeshUse::solid_or_vessel);

/// SetupError: cloth cannot touch the mesh of this body, because it is a thin wall.
[[noreturn]] void refuse_thin_wall(const Body& body, const BodyScene& scene, const std::string& name);

/// Velocity (m/s) of the body's material at x, at t = 0.
Vec3 body_velocity(const Body& body, const Vec3& x);

/// The bodies' poses and velocities at t = 0.
void start_bodies(const Model& model, HostState& state);

/// Where the body's material point that is at x (m) at t = 0 is in this state.
Vec3 placed_point(const Body& body, const HostState& state, Index index, const Vec3& x);

}  // namespace drench
