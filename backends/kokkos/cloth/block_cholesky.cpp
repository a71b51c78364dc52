#include "cloth/block_cholesky.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/host_parallel.hpp"
#include "host/isa.hpp"

namespace drench::kokkos_backend {
namespace {

constexpr Index most_nodes = 10;  // of a panel: its own triangle is 32 numbers wide
constexpr Index whole(Index n) { return (n + spare_lanes - 1) / spare_lanes * spare_lanes; }

/// Room of a thread for one panel's products or one panel's rows.
Real* room_for(Index numbers) {
  static thread_local std::vector<Real> room;
  if (room.size() < static_cast<std::size_t>(numbers)) room.resize(static_cast<std::size_t>(numbers));
  return room.data();
}

}  // namespace

BlockCholesky::BlockCholesky(const NodeGraph& near) {
  make_panels(eliminate(near));
  make_updates();
}

/// Sets the order, and says which rows of L a column has.
NodeGraph BlockCholesky::eliminate(const NodeGraph& near) {
  dissection_ = dissect(near);
  place_ = std::move(dissection_.place);
  const std::vector<Index> last = postorder(elimination_tree(reordered(near, place_)));
  part_.resize(place_.size());
  for (std::size_t i = 0; i < place_.size(); ++i) {
    place_[i] = last[at(place_[i])];
    part_[at(place_[i])] = dissection_.part[i];
  }
  const NodeGraph ordered = reordered(near, place_);
  NodeGraph below(near.size()), children(near.size());
  std::vector<Index> seen(near.size(), -1);
  for (Index j = 0; j < size(); ++j) {
    seen[at(j)] = j;
    std::vector<Index>& own = below[at(j)];
    const auto take = [&](Index i) {
      if (i <= j || seen[at(i)] == j) return;
      seen[at(i)] = j;
      own.push_back(i);
    };
    for (const Index i : ordered[at(j)]) take(i);
    for (const Index child : children[at(j)])
      for (const Index i : below[at(child)]) take(i);
    std::sort(own.begin(), own.end());
    if (!own.empty()) children[at(own.front())].push_back(j);
  }
  return below;
}

/// Joins columns to panels, also where that adds some zeros: wide panels are quicker.
void BlockCholesky::make_panels(const NodeGraph& below) {
  constexpr double most_zeros = 0.1;  // of what is stored
  struct Group {
    Index first, last;  // columns
    double entries;     // that are not 0
  };
  const auto stored = [&](Index first, Index last) {
    const double columns = last - first + 1;
    return columns * (columns + 1) / 2 + columns * double(below[at(last)].size());
  };
  std::vector<Group> groups;
  for (Index j = 0; j < size(); ++j) {
    groups.push_back({j, j, 1 + double(below[at(j)].size())});
    while (groups.size() > 1) {
      const Group own = groups.back(), before = groups[groups.size() - 2];
      const std::vector<Index>& rows = below[at(before.last)];
      const double entries = before.entries + own.entries, all = stored(before.first, own.last);
      if (rows.empty() || rows.front() > own.last || part_[at(before.last)] != part_[at(own.last)] ||
          all - entries > most_zeros * all)
        break;
      groups.pop_back();
      groups.back() = {before.first, own.last, entries};
    }
  }
  panel_of_.resize(place_.size());
  for (const Group& g : groups) add_panels(g.first, g.last, below[at(g.last)]);
  std::size_t values = 0, inverse = 0;
  for (Panel& p : panels_) {
    p.at = values;
    p.inverse_at = inverse;
    values += at(p.columns()) * at(p.stride);
    inverse += at(p.columns()) * at(p.top);
  }
}

void BlockCholesky::make_room() {
  if (panels_.empty()) return;
  const Panel& last = panels_.back();
  values_.resize(last.at + at(last.columns()) * at(last.stride));
  inverse_.resize(last.inverse_at + at(last.columns()) * at(last.top));
  lost_.resize(3 * separators_.size() * at(dissection_.parts()));
}

void BlockCholesky::add_panels(Index first, Index last, const std::vector<Index>& rows) {
  const Index columns = last - first + 1, panels = (columns + most_nodes - 1) / most_nodes;
  for (Index k = 0; k < panels; ++k) {
    const Index begin = first + columns * k / panels, end = first + columns * (k + 1) / panels;
    Panel p{};
    p.first = begin;
    p.nodes = end - begin;
    p.part = part_[at(begin)];
    p.row_begin = static_cast<Index>(row_.size());
    for (Index i = end; i <= last; ++i) row_.push_back(i);
    row_.insert(row_.end(), rows.begin(), rows.end());
    p.rows = static_cast<Index>(row_.size()) - p.row_begin;
    while (p.inner < p.rows && part_[at(row_[at(p.row_begin + p.inner)])] == p.part) ++p.inner;
    p.top = whole(p.columns());
    p.stride = p.top + whole(3 * p.rows);
    for (Index i = begin; i < end; ++i) panel_of_[at(i)] = static_cast<Index>(panels_.size());
    panels_.push_back(p);
  }
}

void BlockCholesky::make_updates() {
  panels_of_.resize(at(dissection_.parts()));
  updates_of_.resize(panels_.size());
  for (Panel& p : panels_) {
    panels_of_[at(p.part)].push_back(static_cast<Index>(&p - panels_.data()));
    p.update_begin = static_cast<Index>(updates_.size());
    for (Index from = 0; from < p.rows;) {
      Index to = from + 1;
      while (to < p.rows && panel_of_[at(row_[at(p.row_begin + to)])] == panel_of_[at(row_[at(p.row_begin + from)])])
        ++to;
      add_update(p, from, to);
      from = to;
    }
    p.update_end = static_cast<Index>(updates_.size());
  }
  for (Index u = 0; u < static_cast<Index>(updates_.size()); ++u) {
    const Update& update = updates_[at(u)];
    if (panels_[at(update.source)].part != panels_[at(update.target)].part) updates_of_[at(update.target)].push_back(u);
  }
  list_separators();
}

void BlockCholesky::list_separators() {
  number_.assign(place_.size(), -1);
  below_.resize(at(dissection_.parts()));
  first_separator_.assign(at(dissection_.parts()) + 1, 0);
  panels_on_.resize(at(dissection_.levels) + 1);
  for (Index p = dissection_.first_part(1); p < dissection_.parts(); ++p) {
    std::vector<Index>& on_level = panels_on_[at(dissection_.level_of(p))];
    on_level.insert(on_level.end(), panels_of_[at(p)].begin(), panels_of_[at(p)].end());
    for (const Index k : panels_of_[at(p)])
      for (Index j = panels_[at(k)].first; j < panels_[at(k)].first + panels_[at(k)].nodes; ++j) {
        number_[at(j)] = static_cast<Index>(separators_.size());
        separators_.push_back(j);
      }
    first_separator_[at(p) + 1] = static_cast<Index>(separators_.size());
    for (Index below = 0; below < p; ++below)
      if (dissection_.is_below(below, p)) below_[at(p)].push_back(below);
  }
}

void BlockCholesky::add_update(Panel& panel, Index from, Index to) {
  Update update{static_cast<Index>(&panel - panels_.data()),
                panel_of_[at(row_[at(panel.row_begin + from)])],
                from,
                to,
                static_cast<Index>(runs_.size()),
                0};
  const Panel& target = panels_[at(update.target)];
  for (Index i = from; i < panel.rows; ++i) {
    const Index row = row_in(target, row_[at(panel.row_begin + i)]);
    const auto begun = static_cast<Index>(runs_.size()) > update.run_begin;
    if (begun && runs_.back().target + runs_.back().length == row)
      runs_.back().length += 3;
    else
      runs_.push_back({3 * i, row, 3});
  }
  update.run_end = static_cast<Index>(runs_.size());
  updates_.push_back(update);
}

/// Where the rows of a node begin in a panel's columns.
Index BlockCholesky::row_in(const Panel& panel, Index node) const {
  if (node < panel.first + panel.nodes) return 3 * (node - panel.first);
  const auto first = row_.begin() + panel.row_begin;
  return panel.top + 3 * static_cast<Index>(std::lower_bound(first, first + panel.rows, node) - first);
}

BlockCholesky::Place BlockCholesky::block(Index i, Index j) const {
  const Index row = place_[at(i)], column = place_[at(j)];
  const Panel& p = panels_[at(panel_of_[at(column)])];
  return {p.at + at(3 * (column - p.first)) * at(p.stride) + at(row_in(p, row)), p.stride};
}

double BlockCholesky::work() const {
  double sum = 0;
  for (const Panel& p : panels_)
    sum += double(p.columns()) * (4.5 * double(p.rows) * double(p.rows) + 0.5 * double(p.stride) * double(p.columns()));
  return sum;
}

double BlockCholesky::numbers() const {
  if (panels_.empty()) return 0;
  const Panel& last = panels_.back();
  return double(last.at) + double(last.columns()) * double(last.stride);
}

void BlockCholesky::clear() {
  constexpr std::size_t length = 1 << 16;
  host_parallel("drench::cloth::factor_clear", static_cast<Index>((values_.size() + length - 1) / length),
                [this](const Index k) {
                  std::fill(values_.data() + at(k) * length,
                            values_.data() + std::min(values_.size(), (at(k) + 1) * length), Real(0));
                });
}

void BlockCholesky::factor() {
  host_parallel("drench::cloth::factor_leaves", dissection_.parts_on(0), [this](const Index p) { factor_part(p); });
  for (Index level = 1; level <= dissection_.levels; ++level) {
    const std::vector<Index>& panels = panels_on_[at(level)];
    host_parallel("drench::cloth::factor_updates", static_cast<Index>(panels.size()), [&](const Index k) {
      for (const Index u : updates_of_[at(panels[at(k)])]) subtract(updates_[at(u)]);
    });
    const Index first = dissection_.first_part(level);
    host_parallel("drench::cloth::factor_separators", dissection_.parts_on(level),
                  [=, this](const Index p) { factor_part(first + p); });
  }
}

void BlockCholesky::factor_part(Index part) {
  for (const Index k : panels_of_[at(part)]) {
    const Panel& p = panels_[at(k)];
    factor_panel(p);
    for (Index u = p.update_begin; u < p.update_end; ++u)
      if (panels_[at(updates_[at(u)].target)].part == part) subtract(updates_[at(u)]);
  }
}

void BlockCholesky::factor_panel(const Panel& p) {
  Real inverse_pivot[3 * most_nodes];
  Real* const a = values_.data() + p.at;
  panel_loops().factor_panel(a, p.columns(), p.stride, inverse_pivot);
  panel_loops().invert_panel(a, p.columns(), p.stride, p.top, inverse_pivot, inverse_.data() + p.inverse_at);
}

void BlockCholesky::subtract(const Update& update) {
  const PanelLoops& loops = panel_loops();
  const Panel &panel = panels_[at(update.source)], &target = panels_[at(update.target)];
  const Real* const below = values_.data() + panel.at + panel.top;
  const Index from = 3 * update.from / spare_lanes * spare_lanes, end = panel.below();
  Real* const room = room_for(6 * end);
  const PanelRun *const first = runs_.data() + update.run_begin, *const last = runs_.data() + update.run_end;
  for (Index i = update.from; i < update.to; i += 2) {
    const bool two = i + 1 < update.to;
    (two ? loops.products_of_6 : loops.products_of_3)(below, panel.columns(), panel.stride, 3 * i, from, end, room,
                                                      end);
    Real* to[6]{};
    for (Index q = 0; q < (two ? 6 : 3); ++q) {
      const Index column = 3 * (row_[at(panel.row_begin + i + q / 3)] - target.first) + q % 3;
      to[q] = values_.data() + target.at + at(column) * at(target.stride);
    }
    (two ? loops.subtract_runs_of_6 : loops.subtract_runs_of_3)(room, end, first, last, to);
  }
}

void BlockCholesky::solve(Real* x) {
  host_parallel("drench::cloth::solve_leaves", dissection_.parts_on(0), [=, this](const Index p) { forward(p, x); });
  const auto of_level = [this](Index level, const auto& act) {
    const Index first = dissection_.first_part(level);
    host_parallel("drench::cloth::solve_separators", dissection_.parts_on(level),
                  [&](const Index p) { act(first + p); });
  };
  for (Index level = 1; level <= dissection_.levels; ++level)
    of_level(level, [=, this](const Index p) {
      gather_losses(p, x);
      forward(p, x);
    });
  for (Index level = dissection_.levels; level > 0; --level)
    of_level(level, [=, this](const Index p) { backward(p, x); });
  host_parallel("drench::cloth::solve_leaves", dissection_.parts_on(0), [=, this](const Index p) { backward(p, x); });
}

void BlockCholesky::gather_losses(Index part, Real* x) const {
  for (Index k = first_separator_[at(part)]; k < first_separator_[at(part) + 1]; ++k)
    for (const Index below : below_[at(part)])
      for (Index a = 0; a < 3; ++a)
        x[3 * separators_[at(k)] + a] -= lost_[3 * (at(below) * separators_.size() + at(k)) + at(a)];
}

void BlockCholesky::forward(Index part, Real* x) {
  Real* const lost = lost_of(part);
  std::fill_n(lost, 3 * separators_.size(), Real(0));
  const auto times = panel_loops().panel_times;
  Real own[3 * most_nodes + spare_lanes];
  for (const Index k : panels_of_[at(part)]) {
    const Panel& p = panels_[at(k)];
    times(inverse_.data() + p.inverse_at, p.columns(), p.top, p.top, x + 3 * p.first, own);
    std::copy_n(own, p.columns(), x + 3 * p.first);
    if (p.rows == 0) continue;
    Real* const room = room_for(p.below());
    times(values_.data() + p.at + p.top, p.columns(), p.stride, p.below(), own, room);
    const Index* const row = row_.data() + p.row_begin;
    for (Index i = 0; i < p.inner; ++i)
      for (Index a = 0; a < 3; ++a) x[3 * row[i] + a] -= room[3 * i + a];
    for (Index i = p.inner; i < p.rows; ++i)
      for (Index a = 0; a < 3; ++a) lost[3 * number_[at(row[i])] + a] += room[3 * i + a];
  }
}

void BlockCholesky::backward(Index part, Real* x) const {
  const auto subtract_from = panel_loops().subtract_transposed;
  Real own[3 * most_nodes + spare_lanes];
  const std::vector<Index>& panels = panels_of_[at(part)];
  for (std::size_t k = panels.size(); k-- > 0;) {
    const Panel& p = panels_[at(panels[k])];
    std::copy_n(x + 3 * p.first, p.columns(), own);
    std::fill(own + p.columns(), own + p.top, Real(0));
    if (p.rows > 0) {
      Real* const room = room_for(p.below());
      const Index* const row = row_.data() + p.row_begin;
      for (Index i = 0; i < p.rows; ++i) std::copy_n(x + 3 * row[i], 3, room + 3 * i);
      std::fill(room + 3 * p.rows, room + p.below(), Real(0));
      subtract_from(values_.data() + p.at + p.top, p.columns(), p.stride, p.below(), room, own);
    }
    Real sum[3 * most_nodes]{};
    subtract_from(inverse_.data() + p.inverse_at, p.columns(), p.top, p.top, own, sum);
    for (Index c = 0; c < p.columns(); ++c) x[3 * p.first + c] = -sum[c];
  }
}

}  // namespace drench::kokkos_backend
