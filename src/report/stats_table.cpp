#include "report/stats_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "output/run_folder.hpp"

namespace drench {

StatsTable::StatsTable(const std::filesystem::path& path, const std::string& first) {
  std::ifstream in(path, std::ios::binary);
  std::string line;
  if (!in || !std::getline(in, line)) return;
  std::size_t begin = 0;
  for (std::size_t end; begin <= line.size(); begin = end + 1) {
    end = std::min(line.find(',', begin), line.size());
    names_.push_back(line.substr(begin, end - begin));
  }
  for (const std::string& name : names_) in_order_.push_back(&columns_[name]);
  if (names_.front() != first || !has("time") || columns_.size() != names_.size())
    throw FolderError(fmt::format("{}: its first line does not name the columns of a run", path.string()));
  for (std::size_t number = 2; std::getline(in, line); ++number) {
    if (in.eof()) break;  // no end of line: the run was killed while it wrote
    add_row(path, line.c_str(), number);
  }
}

void StatsTable::add_row(const std::filesystem::path& path, const char* line, std::size_t number) {
  const char* at = line;
  for (std::size_t k = 0; k < in_order_.size(); ++k) {
    char* end = nullptr;
    const double value = std::strtod(at, &end);
    const bool last = k + 1 == in_order_.size();
    if (end == at || *end != (last ? '\0' : ','))
      throw FolderError(fmt::format("{}:{}: is not a row of {} numbers", path.string(), number, names_.size()));
    in_order_[k]->push_back(value);
    at = end + 1;
  }
  ++rows_;
}

const std::vector<double>& StatsTable::column(const std::string& name) const {
  static const std::vector<double> none;
  const auto found = columns_.find(name);
  return found == columns_.end() ? none : found->second;
}

Summary summary_of(const std::vector<double>& values) {
  std::vector<double> finite;
  std::copy_if(values.begin(), values.end(), std::back_inserter(finite), [](double v) { return std::isfinite(v); });
  if (finite.empty()) return {};
  Summary s{finite.front(), finite.back(), finite.front(), finite.front(), 0, 0, 0};
  for (const double v : finite) {
    s.least = std::min(s.least, v);
    s.most = std::max(s.most, v);
    s.sum += v;
  }
  s.mean = s.sum / static_cast<double>(finite.size());
  const auto middle = finite.begin() + static_cast<std::ptrdiff_t>(finite.size() / 2);
  std::nth_element(finite.begin(), middle, finite.end());
  s.median = *middle;
  return s;
}

}  // namespace drench
