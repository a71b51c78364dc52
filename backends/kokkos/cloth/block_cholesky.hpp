#pragma once
// A host's Cholesky factor of a sparse symmetric positive matrix of 3 × 3 blocks: the cloth's Hessian
// (docs/theory/cloth.md, section 8). Columns that share their rows are dense panels, so loops run in vector registers.

#include <vector>

#include "cloth/dissection.hpp"
#include "host/panels.hpp"

namespace drench::kokkos_backend {

/// H = L Lᵀ. Threads share the parts of each level of a dissection; the order of all sums depends on the pattern
/// alone.
class BlockCholesky {
 public:
  /// Where a block lies: entry (r, c) at values()[at + c · stride + r].
  struct Place {
    std::size_t at;
    Index stride;
  };

  BlockCholesky() = default;
  /// `near[i]`: the nodes whose block with i is not 0, without i.
  explicit BlockCholesky(const NodeGraph& near);

  Index size() const { return static_cast<Index>(place_.size()); }
  /// Multiplications of a factorisation.
  double work() const;
  /// Numbers that it stores.
  double numbers() const;
  /// Memory for the factor; without it there is the pattern only.
  void make_room();

  /// Does L have block (i, j), or (j, i)? One of the two orders of a pair does.
  bool is_below(Index i, Index j) const { return place_[at(i)] >= place_[at(j)]; }
  Place block(Index i, Index j) const;
  /// Where node i comes in the order of elimination.
  Index place(Index i) const { return place_[at(i)]; }
  /// The part of the dissection that node i is in, and how many there are.
  Index part(Index i) const { return dissection_.part[at(i)]; }
  Index parts() const { return dissection_.parts(); }
  Real* values() { return values_.data(); }

  /// H = 0.
  void clear();
  /// L in place of H.
  void factor();
  /// x := H⁻¹ x, 3 numbers a node in the order of elimination.
  void solve(Real* x);

 private:
  /// Columns [first, first + nodes) with the rows below them; a column has `top` numbers for the columns' own rows, of
  /// which 3 · nodes are used, and then those below, `stride` in all. The first `inner` rows are of its own part.
  struct Panel {
    Index first, nodes, part, row_begin, rows, inner, top, stride;
    std::size_t at, inverse_at;
    Index update_begin, update_end;
    Index columns() const { return 3 * nodes; }
    Index below() const { return stride - top; }
  };
  /// What rows [from, to) of a panel, columns of `target`, subtract from it: runs of numbers.
  struct Update {
    Index source, target, from, to, run_begin, run_end;
  };

  NodeGraph eliminate(const NodeGraph& near);
  void make_panels(const NodeGraph& below);
  void add_panels(Index first, Index last, const std::vector<Index>& rows);
  void make_updates();
  void add_update(Panel& panel, Index from, Index to);
  void list_separators();
  Index row_in(const Panel& panel, Index node) const;
  void factor_panel(const Panel& panel);
  /// Factors the panels of a part, and subtracts what they do to its own.
  void factor_part(Index part);
  void subtract(const Update& update);
  /// Subtracts from the rows of a separator what the parts below it have left in lost_.
  void gather_losses(Index part, Real* x) const;
  /// The first half of a solution, L⁻¹ x; what it subtracts from rows of other parts goes to lost_.
  void forward(Index part, Real* x);
  /// The second half, L⁻ᵀ x.
  void backward(Index part, Real* x) const;
  Real* lost_of(Index part) { return lost_.data() + 3 * at(part) * separators_.size(); }

  Dissection dissection_;              // without its places
  std::vector<Index> place_, part_;    // of each node; of each place
  std::vector<Index> row_, panel_of_;  // places; the panel of each place
  std::vector<Panel> panels_;
  std::vector<std::vector<Index>> panels_of_, updates_of_;  // of each part; of each panel, from other parts
  std::vector<std::vector<Index>> panels_on_;               // of each level of separators
  std::vector<Update> updates_;
  std::vector<PanelRun> runs_;
  std::vector<Index> separators_;              // their places, part by part
  std::vector<Index> number_;                  // of each place among those
  std::vector<Index> first_separator_;         // of each part, in separators_
  std::vector<std::vector<Index>> below_;      // the parts below each
  std::vector<Real> values_, inverse_, lost_;  // lost_: 3 per separator's node, of each part
};

}  // namespace drench::kokkos_backend
