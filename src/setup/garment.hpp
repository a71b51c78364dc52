#pragma once
// How large a garment's mesh is, how fine, and where water would meet it.

#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "setup/mesh_guess.hpp"
#include "setup/surface_mesh.hpp"

namespace drench {

/// A mesh as cloth: in metres, with what suggestions follow from.
struct Garment {
  SurfaceMesh mesh;          // placed, with its seams welded
  MeshGuess guess;           // of the file
  Vec3 shift{0, 0, 0};       // m, added after scaling
  double weld = 0;           // m: sews its seams where the distance that is chosen automatically does not; 0: that one
  Index welded = 0;          // pairs of points that only this distance sews
  std::string unit_warning;  // one line where the unit is a guess, else ""
  Box box;                   // m
  double size = 0;           // m; the longest side of the box
  double edge = 0;           // m; mean length of the edges
  double least_height = 0;   // m; of all its triangles
  double area = 0;           // m²
  bool open = false;         // it has boundary edges
  bool flat = false;         // it lies, rather than hangs: its height is below a tenth of its longest side
};

/// Guesses the unit and the axis that is up. A mesh far from the origin is shifted there, unless it is on a body.
/// SetupError: not fit for cloth.
Garment measure_garment(SurfaceMesh mesh, const std::string& label, const MeshGuess& guess, bool on_body);

/// The horizontal axis (0 or 2) along which a garment is thinner: its front looks that way.
int front_axis(const Garment& garment);

/// The frontmost point of the garment at this height (m), in the middle of its width; of its nodes the nearest to
/// there, where it has a hole.
Vec3 front_point(const Garment& garment, double height);

/// A box that holds the garment's topmost nodes: four at least, where it has so many.
Box top_band(const Garment& garment);

}  // namespace drench
