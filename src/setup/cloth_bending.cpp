#include "setup/cloth_bending.hpp"

namespace drench {
namespace {

/// Of two rigidities in series, which carry the same moment.
double in_series(double a, double b) {
  if (a == b) return a;
  return a > 0 && b > 0 ? 2 / (1 / a + 1 / b) : 0;
}

/// The rigidities of a grid's cells, and of its lines at a node: in series along the line, side by side across it.
class CellRigidity {
 public:
  CellRigidity(const GridScene& grid, const Patchwork& fabric) : columns_(grid.nodes[0] - 1), rows_(grid.nodes[1] - 1) {
    for (Index cell = 0; cell < columns_ * rows_; ++cell) {
      const double a = fabric(2 * cell).bend, b = fabric(2 * cell + 1).bend;
      cell_.push_back(0.5 * (a + b));
    }
  }
  double cell(int i, int j) const { return cell_[static_cast<std::size_t>(i + j * columns_)]; }
  /// Of the line along x at a node that has cells on both sides of it.
  double along_x(int i, int j) const {
    return side_by_side(j, rows_, [&](int row) { return in_series(cell(i - 1, row), cell(i, row)); });
  }
  double along_z(int i, int j) const {
    return side_by_side(i, columns_, [&](int column) { return in_series(cell(column, j - 1), cell(column, j)); });
  }

 private:
  /// The mean of the cells before and after a line, one of them at the grid's boundary.
  template <class Rigidity>
  static double side_by_side(int line, int lines, Rigidity of) {
    if (line == 0) return of(0);
    return line == lines ? of(lines - 1) : 0.5 * (of(line - 1) + of(line));
  }
  int columns_, rows_;
  std::vector<double> cell_;
};

}  // namespace

double hinge_stiffness(const Patchwork& fabric, const MeshEdge& e, const std::vector<double>& area, double around) {
  if (fabric.same(e)) return fabric(e.triangle[0]).bend / around;
  double yielding = 0;  // Σ A/bend
  for (const Index t : e.triangle) {
    if (!(fabric(t).bend > 0)) return 0;
    yielding += area[static_cast<std::size_t>(t)] / fabric(t).bend;
  }
  return 1 / yielding;
}

void add_grid_bending(ClothMesh& mesh, const GridScene& grid, const Patchwork& fabric, Index first) {
  const auto [nx, nz] = grid.nodes;
  const double lx = grid.size[0] / (nx - 1), lz = grid.size[1] / (nz - 1);
  const CellRigidity bend(grid, fabric);
  const auto node = [&, columns = nx](int i, int j) { return first + i + j * columns; };
  const auto add = [&](const std::array<Index, 4>& nodes, const std::array<double, 4>& weight, double stiffness) {
    mesh.hinge.push_back(nodes);
    mesh.hinge_weight.push_back(weight);
    mesh.hinge_stiffness.push_back(stiffness);
  };
  const std::array<double, 4> line{2, 0, -1, -1}, twist{1, 1, -1, -1};
  for (int j = 0; j < nz; ++j) {
    for (int i = 0; i < nx; ++i) {
      const bool end_x = i == 0 || i == nx - 1, end_z = j == 0 || j == nz - 1;
      // The second of the four nodes has no weight.
      if (!end_x)
        add({node(i, j), node(i, j), node(i - 1, j), node(i + 1, j)}, line,
            (end_z ? 0.5 : 1) * bend.along_x(i, j) * lz / (lx * lx * lx));
      if (!end_z)
        add({node(i, j), node(i, j), node(i, j - 1), node(i, j + 1)}, line,
            (end_x ? 0.5 : 1) * bend.along_z(i, j) * lx / (lz * lz * lz));
      if (i + 1 < nx && j + 1 < nz)
        add({node(i, j), node(i + 1, j + 1), node(i + 1, j), node(i, j + 1)}, twist, 2 * bend.cell(i, j) / (lx * lz));
    }
  }
}

}  // namespace drench
